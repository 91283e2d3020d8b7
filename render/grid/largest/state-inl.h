// State of the search for the largest values of a group of rays.
#if defined(RHORAY_WIDE_MAXIMUM_STATE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_STATE_INL_H
#undef RHORAY_WIDE_MAXIMUM_STATE_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_STATE_INL_H
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "render/grid/largest/parts.h"
#include "render/grid/largest/samples-inl.h"
#include "render/traverse/frustum_walk.h"
#include "render/traverse/group-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/octant.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Conversions to single precision on the safe side.
HWY_INLINE float float_not_above(double x) {
  const float rounded = static_cast<float>(x);
  if (!(static_cast<double>(rounded) > x)) return rounded;
  const float lower = rounded - 0x1p-23F * (rounded < 0 ? -rounded : rounded);
  return lower < rounded ? lower : -std::numeric_limits<float>::min();
}
HWY_INLINE float float_not_below(double x) {
  return -float_not_above(-x);
}

inline constexpr float nothing_float = -std::numeric_limits<float>::infinity();

/// 0, 1, 2 and so on.
alignas(64) inline constexpr auto lane_numbers = [] {
  std::array<std::int32_t, float_lanes> numbers{};
  for (std::size_t lane = 0; lane < numbers.size(); ++lane) numbers[lane] = static_cast<std::int32_t>(lane);
  return numbers;
}();

/// State shared by the parts of the search for one group of rays.
///
/// Positions in single precision are off by less than `margin`, 8 units of rounding of the
/// lattice's extent: start and slope of a line are rounded once, and so are their product and sum.
/// Regions are widened by it, so that a ray is found in every region that it passes in double
/// precision.
struct SearchState {
  const MaximumField& field;
  const RayArrays& rays;
  MaximumScratch& scratch;
  const MirroredLattice& lattice;
  const Frustum& frustum;
  float margin;         ///< more than positions are off in single precision
  double exact_margin;  ///< the same in double precision
  /// This far inside a face no other plane is passed near it, whatever the rounding.
  float clear_of_edges;
  /// No ray begins farther along the major axis, in single precision.
  float latest_from = 0;
  std::size_t vectors = 0;          ///< vectors of floats that hold all rays of the group
  double lowest_reached = nothing;  ///< no more than any ray has reached
  bool has_risen = false;           ///< some ray has reached more since lowest_reached was found

  SearchState(const MaximumField& of_field, const RayArrays& of_rays, MaximumScratch& memory,
              const MirroredLattice& mirrored, const Frustum& around)
      : field(of_field), rays(of_rays), scratch(memory), lattice(mirrored), frustum(around) {
    int longest = 0;
    for (const int count : mirrored.node_count) longest = count > longest ? count : longest;
    VecD largest = hn::Zero(doubles);
    for (std::size_t r = 0; r < memory.rays.count; r += double_lanes)
      for (const auto& origin : memory.rays.origin) largest = hn::Max(largest, hn::Abs(hn::Load(doubles, origin + r)));
    const double furthest = hn::GetLane(hn::MaxOfLanes(doubles, largest));
    exact_margin = 0x1p-46 * (furthest + 16 * longest);
    margin = 0x1p-21F * 16 * static_cast<float>(longest) + static_cast<float>(0x1p-46 * furthest);
    clear_of_edges = 16 * margin + 0x1p-9F;  // and 36 margins of a slab
    make_lines();
  }

  /// Computes the rays as functions of the position on the major axis. The margin covers all
  /// rounding in these.
  HWY_INLINE void make_lines() {
    const SearchedRays& group = scratch.rays;
    GroupLines& lines = scratch.lines;
    const int w = frustum.major;
    for (std::size_t r = 0; r < group.count; r += double_lanes) {
      const VecD o_w = mirrored_origin(lattice, group, w, r), d_w = speed(group, w, r);
      const auto store = [&](VecD x, float* to)
                             HWY_ATTR { hn::Store(hn::DemoteTo(half_floats, x), half_floats, to + r); };
      for (int m = 0; m < 2; ++m) {
        const VecD slope = hn::Div(speed(group, frustum.minor[m], r), d_w);
        const VecD start = hn::NegMulAdd(o_w, slope, mirrored_origin(lattice, group, frustum.minor[m], r));
        hn::Store(start, doubles, lines.exact_start[m] + r);
        hn::Store(slope, doubles, lines.exact_slope[m] + r);
        store(start, lines.start[m]);
        store(slope, lines.slope[m]);
        const VecD inverse = hn::Div(hn::Set(doubles, 1.0), slope);
        store(hn::Min(inverse, hn::Set(doubles, 0x1p40)), lines.inverse[m]);
      }
      const VecD around = hn::Set(doubles, static_cast<double>(margin));
      store(hn::Sub(hn::MulAdd(hn::Load(doubles, group.t_in + r), d_w, o_w), around), lines.from);
      store(hn::Add(hn::MulAdd(hn::Load(doubles, group.t_out + r), d_w, o_w), around), lines.to);
    }
    vectors = (group.count + float_lanes - 1) / float_lanes;
    for (std::size_t r = 0; r < vectors * float_lanes; ++r) {
      const bool is_inside = r < group.count && (group.inside[r / 64] >> r % 64 & 1) != 0;
      lines.reached[r] = is_inside ? nothing_float : std::numeric_limits<float>::infinity();
      lines.reached_at[r] = std::numeric_limits<float>::infinity();
      scratch.reached[r] = scratch.known_value[r] = nothing;
      scratch.known_t[r] = std::numeric_limits<double>::infinity();
      scratch.visits[r] = 0;
      for (std::uint64_t& key : scratch.last_looks[r].key) key = ~std::uint64_t{0};
      scratch.last_looks[r].next = 0;
      if (!is_inside) lines.from[r] = 1, lines.to[r] = 0;
    }
    put_lines_around();
    scratch.suspects.count = scratch.suspects.boxes = scratch.looks_left.count = 0;
  }

  /// Computes lines through the ends of the group's part of the lattice. Rays rise on the minor
  /// axes, and so do these lines.
  HWY_INLINE void put_lines_around() {
    const GroupLines& lines = scratch.lines;
    VectorLines& around = scratch.around;
    const auto first = static_cast<float>(frustum.first), last = static_cast<float>(frustum.last);
    const float inverse_length = last > first ? 1 / (last - first) : 0;
    const VecF far_away = hn::Set(floats, 0x1p100F);
    VecF latest = hn::Neg(far_away);
    for (std::size_t vector = 0; vector < vectors; ++vector) {
      around.reached[vector] = nothing_float;
      const std::size_t r = vector * float_lanes;
      const VecF from = hn::Load(floats, lines.from + r);
      const MaskF is_inside = hn::Le(from, hn::Load(floats, lines.to + r));
      latest = hn::IfThenElse(is_inside, hn::Max(latest, from), latest);
      for (int m = 0; m < 2; ++m) {
        const VecF start = hn::Load(floats, lines.start[m] + r), slope = hn::Load(floats, lines.slope[m] + r);
        const auto lowest_at = [&](float w) HWY_ATTR {
          const VecF at = hn::MulAdd(slope, hn::Set(floats, w), start);
          return hn::GetLane(hn::MinOfLanes(floats, hn::IfThenElse(is_inside, at, far_away)));
        };
        const auto highest_at = [&](float w) HWY_ATTR {
          const VecF at = hn::MulAdd(slope, hn::Set(floats, w), start);
          return hn::GetLane(hn::MaxOfLanes(floats, hn::IfThenElse(is_inside, at, hn::Neg(far_away))));
        };
        const float low = lowest_at(first), high = highest_at(first);
        around.low_slope[m][vector] = (lowest_at(last) - low) * inverse_length;
        around.high_slope[m][vector] = (highest_at(last) - high) * inverse_length;
        around.low[m][vector] = low - first * around.low_slope[m][vector];
        around.high[m][vector] = high - first * around.high_slope[m][vector];
      }
    }
    latest_from = hn::GetLane(hn::MaxOfLanes(floats, latest));
  }

  /// Vectors with rays that may pass a region and have not reached more than its largest value, as
  /// bits.
  ///
  /// Where the lines around them are near the lattice, their numbers are at most five times its
  /// extent. Rounding (of both factors and the sum, of the part's ends, of the slope) moves them by
  /// less than 26 units. A ray's own error is less than a margin of 8, and eight margins cover
  /// both.
  HWY_INLINE std::uint64_t vectors_through(const int* region, float edge, float largest) const {
    const VectorLines& around = scratch.around;
    const float low_w = static_cast<float>(region[frustum.major]) * edge;
    const auto first = static_cast<float>(frustum.first), last = static_cast<float>(frustum.last);
    const VecF near = hn::Set(floats, low_w - margin > first ? low_w - margin : first),
               far = hn::Set(floats, low_w + edge + margin < last ? low_w + edge + margin : last);
    std::uint64_t bits = 0;
    for (std::size_t v = 0; v < vectors; v += float_lanes) {
      MaskF passing = hn::And(hn::FirstN(floats, vectors - v),
                              hn::Le(hn::Load(floats, around.reached + v), hn::Set(floats, largest)));
      for (int m = 0; m < 2; ++m) {
        const float low = static_cast<float>(region[frustum.minor[m]]) * edge;
        const VecF lowest =
            hn::MulAdd(hn::Load(floats, around.low_slope[m] + v), near, hn::Load(floats, around.low[m] + v));
        const VecF highest =
            hn::MulAdd(hn::Load(floats, around.high_slope[m] + v), far, hn::Load(floats, around.high[m] + v));
        // NaN, from an eye too far away, passes.
        passing = hn::AndNot(hn::Or(hn::Gt(lowest, hn::Set(floats, low + edge + 8 * margin)),
                                    hn::Lt(highest, hn::Set(floats, low - 8 * margin))),
                             passing);
      }
      bits |= bits_of(floats, passing) << v;
    }
    return bits;
  }

  /// False for eyes so far away that positions in a box have larger errors than those of single
  /// precision.
  HWY_INLINE bool is_exact() const { return exact_margin <= 0x1p-20; }

  /// True where every ray that passes a box is in the volume before it, and meets cells with data
  /// there.
  /// @param low_w  where the box begins on the major axis
  HWY_INLINE bool is_come_to(double low_w) const {
    return is_exact() && !field.has_gaps && low_w > static_cast<double>(latest_from) + 4 * static_cast<double>(margin);
  }

  /// True for regions that the volume has; `place` is their position there.
  HWY_INLINE bool find_in_file(const int* mirrored, bool is_block, const StoredRanges& level, int* place) const {
    for (int a = 0; a < 3; ++a) {
      place[a] = is_block ? lattice.block(a, mirrored[a]) : lattice.node(a, mirrored[a]);
      if (place[a] < 0 || place[a] >= level.count[a]) return false;
    }
    return true;
  }

  /// A region in the form in which rays are compared with it: wider by the margin.
  struct Bounds {
    VecF first, last, low[2], high[2], largest;
  };
  HWY_INLINE Bounds bounds_of(const int* region, float edge, float largest) const {
    Bounds bounds;
    const float low_w = static_cast<float>(region[frustum.major]) * edge;
    bounds.first = hn::Set(floats, low_w - margin), bounds.last = hn::Set(floats, low_w + edge + margin);
    for (int m = 0; m < 2; ++m) {
      const float low = static_cast<float>(region[frustum.minor[m]]) * edge;
      bounds.low[m] = hn::Set(floats, low - margin), bounds.high[m] = hn::Set(floats, low + edge + margin);
    }
    bounds.largest = hn::Set(floats, largest);
    return bounds;
  }

  /// Rays of a vector that pass a region and can be changed by it.
  struct Passing {
    MaskF rays;
    VecF from, to;
  };
  HWY_INLINE Passing rays_through(const Bounds& region, std::size_t r) const {
    const GroupLines& lines = scratch.lines;
    Passing passing;
    passing.from = hn::Max(hn::Load(floats, lines.from + r), region.first);
    passing.to = hn::Min(hn::Load(floats, lines.to + r), region.last);
    for (int m = 0; m < 2; ++m) {
      const VecF start = hn::Load(floats, lines.start[m] + r), inverse = hn::Load(floats, lines.inverse[m] + r);
      passing.from = hn::Max(passing.from, hn::Mul(hn::Sub(region.low[m], start), inverse));
      passing.to = hn::Min(passing.to, hn::Mul(hn::Sub(region.high[m], start), inverse));
    }
    passing.rays = hn::And(hn::Le(passing.from, passing.to),
                           may_improve(region.largest, passing.from, hn::Load(floats, lines.reached + r),
                                       hn::Load(floats, lines.reached_at + r)));
    return passing;
  }

  /// Parts of a vector's rays in a box, relative to its lowest corner: positions on the minor axes
  /// as functions of that on the major one.
  struct PartsInBox {
    VecF from, to, start[2], slope[2];
  };

  /// @param low  the box's lowest corner, by axis
  HWY_INLINE PartsInBox parts_in_box(std::size_t r, VecF from, VecF to, const double* low) const {
    const double low_w = low[frustum.major];
    const VecF low_w_float = hn::Set(floats, static_cast<float>(low_w));
    PartsInBox parts{.from = hn::Sub(from, low_w_float), .to = hn::Sub(to, low_w_float), .start = {}, .slope = {}};
    for (int m = 0; m < 2; ++m) {
      VecD start[parts_of_floats];
      for (std::size_t part = 0; part < parts_of_floats; ++part) {
        const std::size_t ray = r + part * double_lanes;
        const VecD at_low = hn::MulAdd(hn::Load(doubles, scratch.lines.exact_slope[m] + ray), hn::Set(doubles, low_w),
                                       hn::Load(doubles, scratch.lines.exact_start[m] + ray));
        start[part] = hn::Sub(at_low, hn::Set(doubles, low[frustum.minor[m]]));
      }
      parts.start[m] = as_floats(start);
      parts.slope[m] = hn::Load(floats, scratch.lines.slope[m] + r);
    }
    return parts;
  }

  /// Counts a box for the chosen rays of a vector, and the cells that they pass in it.
  /// @param last  index of its last cell on the major axis and the minor ones
  HWY_INLINE void count_cells(std::size_t r, MaskF chosen, const PartsInBox& parts, const float* last) const {
    VecF visits = hn::Set(floats, 2.0F);
    const auto add = [&](VecF first_place, VecF last_place, float end) HWY_ATTR {
      const auto cell = [&](VecF place) HWY_ATTR {
        return hn::Min(hn::Trunc(hn::Max(place, hn::Zero(floats))), hn::Set(floats, end));
      };
      visits = hn::Add(visits, hn::Sub(cell(last_place), cell(first_place)));
    };
    add(parts.from, parts.to, last[0]);
    for (int m = 0; m < 2; ++m)
      add(hn::MulAdd(parts.slope[m], parts.from, parts.start[m]), hn::MulAdd(parts.slope[m], parts.to, parts.start[m]),
          last[1 + m]);
    float* const counted = scratch.visits + r;
    hn::Store(hn::Add(hn::Load(floats, counted), hn::IfThenElseZero(chosen, visits)), floats, counted);
  }

  /// Adds the chosen rays of a vector to those at a box.
  /// @param low_w    where it begins on the major axis
  /// @param reached  what they have reached, in the box's unit
  HWY_INLINE void put_at_box(std::size_t r, MaskF chosen, const PartsInBox& parts, double low_w, VecF reached) const {
    const GroupLines& lines = scratch.lines;
    RaysAtBlock& at_block = scratch.at_block;
    const std::size_t at = at_block.count;
    // The order of a ray's lanes, computed once for all its numbers.
    const VecI lanes = hn::Compress(hn::Load(ints, lane_numbers.data()), hn::RebindMask(ints, chosen));
    const auto order = hn::IndicesFromVec(floats, lanes);
    const auto put = [&](VecF x, float* numbers)
                         HWY_ATTR { hn::StoreU(hn::TableLookupLanes(x, order), floats, numbers + at); };
    for (int m = 0; m < 2; ++m) {
      put(parts.start[m], at_block.start[m]), put(parts.slope[m], at_block.slope[m]);
      put(hn::Load(floats, lines.inverse[m] + r), at_block.inverse[m]);
    }
    put(parts.from, at_block.from), put(parts.to, at_block.to), put(reached, at_block.reached);
    const VecF reached_at = hn::Sub(hn::Load(floats, lines.reached_at + r), hn::Set(floats, static_cast<float>(low_w)));
    put(hn::Add(reached_at, hn::Set(floats, margin)), at_block.reached_at);
    hn::StoreU(hn::Add(lanes, hn::Set(ints, static_cast<std::int32_t>(r))), ints, at_block.ray + at);
    at_block.count += hn::CountTrue(floats, chosen);
  }

  /// Pads with lanes that pass through nothing.
  HWY_INLINE void close_box() const {
    RaysAtBlock& at_block = scratch.at_block;
    hn::StoreU(hn::Set(ints, at_block.ray[0]), ints, at_block.ray + at_block.count);
    hn::StoreU(hn::Set(floats, 1.0F), floats, at_block.from + at_block.count);
    hn::StoreU(hn::Zero(floats), floats, at_block.to + at_block.count);
  }

  /// False where no value up to `bound`, from this position on, replaces what was reached.
  HWY_INLINE static MaskF may_improve(VecF bound, VecF from, VecF reached, VecF reached_at) {
    return hn::Or(hn::Gt(bound, reached), hn::And(hn::Eq(bound, reached), hn::Lt(from, reached_at)));
  }

  /// Numbers in single precision that are not above x; equal to x where x is such a number.
  HWY_INLINE static hn::Vec<HalfFloats> floats_not_above(VecD x) {
    const auto largest = hn::Set(half_floats, std::numeric_limits<float>::max());
    const auto nearest = hn::Min(hn::DemoteTo(half_floats, x), largest);
    const VecD is_above =
        hn::IfThenElse(hn::Gt(hn::PromoteTo(doubles, nearest), x), hn::Set(doubles, 1.0), hn::Zero(doubles));
    const auto lower = hn::Min(hn::NegMulAdd(hn::Abs(nearest), hn::Set(half_floats, 0x1p-23F), nearest),
                               hn::Sub(nearest, hn::Set(half_floats, std::numeric_limits<float>::min())));
    return hn::IfThenElse(hn::Gt(hn::DemoteTo(half_floats, is_above), hn::Zero(half_floats)), lower, nearest);
  }

  /// Records that some value on the ray is at least `value`, no farther away than `place`.
  /// @param below  no more than the value, in single precision
  HWY_INLINE void set_reached(std::size_t ray, double value, float below, float place) {
    if (!(value > scratch.reached[ray] || (value == scratch.reached[ray] && place < scratch.lines.reached_at[ray])))
      return;
    scratch.reached[ray] = value;
    scratch.lines.reached[ray] = below;
    scratch.lines.reached_at[ray] = place;
  }

  /// Records what was found on a ray.
  HWY_INLINE void knows(std::size_t ray, const FoundMaximum& found) {
    scratch.known_value[ray] = found.value, scratch.known_t[ray] = found.t;
    set_reached(ray, found.value, float_not_above(found.value), float_not_below(place_at(ray, found.t)) + margin);
  }

  /// The position of a ray on the major axis.
  HWY_INLINE double place_at(std::size_t ray, double t) const {
    const SearchedRays& group = scratch.rays;
    const int w = frustum.major;
    const double o = lattice.is_mirrored(w) ? lattice.plane(w, 0) - group.origin[w][ray] : group.origin[w][ray];
    const double d = group.direction[w][ray];
    return o + t * (d < 0 ? -d : d);
  }

  HWY_INLINE void find_lowest_reached() {
    float lowest = std::numeric_limits<float>::infinity();
    for (std::size_t vector = 0; vector < vectors; ++vector) {
      const VecF reached = hn::Load(floats, scratch.lines.reached + vector * float_lanes);
      const float here = hn::GetLane(hn::MinOfLanes(floats, reached));
      scratch.around.reached[vector] = here;
      lowest = here < lowest ? here : lowest;
    }
    lowest_reached = static_cast<double>(lowest);
    has_risen = false;
  }
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
