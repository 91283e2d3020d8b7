// The rays of a group, prepared for the search for the largest values in meshes. Included again for
// each machine.
#if defined(RHORAY_WIDE_TET_MAXIMUM_RAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_TET_MAXIMUM_RAYS_INL_H
#undef RHORAY_WIDE_TET_MAXIMUM_RAYS_INL_H
#else
#define RHORAY_WIDE_TET_MAXIMUM_RAYS_INL_H
#endif

#include <cstdint>
#include <cstring>
#include <limits>

#include "render/tets/largest/parts.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {
namespace {

using TetScratch = TetMaximumScratch;

inline constexpr double infinite = std::numeric_limits<double>::infinity();

/// The major axis of each ray of a chunk, on which it moves most.
struct MainAxes {
  /// Rays that are finite, move, and start less than `reach` mesh sizes away.
  std::uint64_t along[3];
  std::uint64_t down;      ///< rays that move down their axis
  std::uint64_t left_out;  ///< the other rays, including those that end before they begin
};

HWY_INLINE MainAxes main_axes(const TetMaximumField& field, const RayArrays& rays, std::size_t count) {
  MainAxes axes{};
  double size = 0;
  for (int a = 0; a < 3; ++a) size = field.high[a] - field.low[a] > size ? field.high[a] - field.low[a] : size;
  const VecD farthest = hn::Set(doubles, reach * size);
  std::uint64_t usable_rays = 0;
  for (std::size_t r = 0; r < count; r += double_lanes) {
    VecD length[3], d[3];
    MaskD usable = hn::And(hn::FirstN(doubles, count - r),
                           hn::Le(hn::Load(doubles, rays.t_min + r), hn::Load(doubles, rays.t_max + r)));
    for (int a = 0; a < 3; ++a) {
      d[a] = hn::Load(doubles, rays.direction[a] + r);
      length[a] = hn::Abs(d[a]);
      const VecD start =
          hn::Sub(hn::Load(doubles, rays.origin[a] + r), hn::Set(doubles, 0.5 * (field.low[a] + field.high[a])));
      usable = hn::And(usable, hn::And(is_finite(d[a]), hn::Le(hn::Abs(start), farthest)));
    }
    const MaskD x = hn::And(hn::Ge(length[0], length[1]), hn::Ge(length[0], length[2]));
    const MaskD y = hn::AndNot(x, hn::Ge(length[1], length[2]));
    const VecD largest = hn::Max(length[0], hn::Max(length[1], length[2]));
    usable = hn::And(usable,
                     hn::And(hn::Gt(largest, hn::Set(doubles, 0x1p-400)), hn::Lt(largest, hn::Set(doubles, 0x1p400))));
    const MaskD along[3] = {x, y, hn::Not(hn::Or(x, y))};
    VecD main = d[2];
    for (int a = 0; a < 3; ++a) {
      axes.along[a] |= bits_of(doubles, hn::And(usable, along[a])) << r;
      main = hn::IfThenElse(along[a], d[a], main);
    }
    axes.down |= bits_of(doubles, hn::Lt(main, hn::Zero(doubles))) << r;
    usable_rays |= bits_of(doubles, usable) << r;
  }
  axes.left_out = (count == TetScratch::lanes ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) & ~usable_rays;
  return axes;
}

/// Returns the lanes of a chunk's rays.
HWY_INLINE std::uint64_t in_lanes(std::uint64_t rays) {
  std::uint64_t there = 0;
  for (std::size_t quad = 0; quad < TetScratch::lanes / 4; ++quad)
    there |= (rays >> 4 * quad & 15) << lane_of(4 * quad);
  return there;
}

/// Rays that share a major axis and a direction along it, and straight lines that bound those of
/// each pack.
class TetRays {
 public:
  HWY_INLINE TetRays(const TetMaximumField& field, const RayArrays& rays, std::size_t count, int axis, bool moves_down,
                     std::uint64_t lanes_alive, TetScratch& scratch)
      : field_(field),
        scratch_(scratch),
        u((axis + 1) % 3),
        v((axis + 2) % 3),
        w(axis),
        is_down(moves_down),
        alive(lanes_alive) {
    double size = 0, largest = 0;
    for (int a = 0; a < 3; ++a) {
      middle[a] = 0.5 * (field.low[a] + field.high[a]);
      size = larger(size, field.high[a] - field.low[a]);
      largest = larger(largest, larger(-field.low[a], field.high[a]));
    }
    describe(rays, count, size);
    bound_packs();
    place_error = 0x1p-49 * (farthest_ + 2 * size);
    describe_for_tree(larger(largest, size));
  }

  double middle[3];  ///< of the mesh
  /// In mesh units: upper bound of the error of a position in a ray's picture plane, here or in the
  /// scalar kernel, from computing in double. The slope has an error of 2^-52 of itself; its
  /// product, a difference and the shift 2^-53 each; the scalar kernel's 7.2 * 2^-53
  /// (RayShearOf::errors).
  double place_error;
  float tree_margin;  ///< the same in units of boxes, with rounding to single precision
  /// Bounds of all packs, with their lines, in units of boxes.
  float group_offset[4], group_slope[4];
  float first, last;  ///< range of the ends of all rays, in units of boxes
  /// All rays begin and end farther from the mesh, along w, than half its largest side.
  bool go_through;

 private:
  const TetMaximumField& field_;
  TetScratch& scratch_;
  double farthest_ = 0;

 public:
  const int u, v, w;
  const bool is_down;
  const std::uint64_t alive;  ///< lanes in use

  HWY_INLINE static double larger(double a, double b) { return a > b ? a : b; }

 private:
  HWY_INLINE void describe(const RayArrays& rays, std::size_t count, double size) {
    HWY_ALIGN double slope[2][TetScratch::lanes], shift[2][TetScratch::lanes], begin[TetScratch::lanes],
        end[TetScratch::lanes];
    const int minor[2] = {u, v};
    VecD farthest = hn::Zero(doubles);
    const VecD outside = hn::Set(doubles, 0.5 * (field_.high[w] - field_.low[w]) + 0.5 * size);
    MaskD stops_short = no_lane(doubles);
    for (std::size_t r = 0; r < count; r += double_lanes) {
      const VecD d = hn::Load(doubles, rays.direction[w] + r), inverse = hn::Div(hn::Set(doubles, 1.0), d);
      const auto start = [&](int axis) HWY_ATTR {
        return hn::Sub(hn::Load(doubles, rays.origin[axis] + r), hn::Set(doubles, middle[axis]));
      };
      const VecD at = start(w);
      const MaskD there = hn::FirstN(doubles, count - r);
      farthest = hn::Max(farthest, hn::IfThenElseZero(there, hn::Abs(at)));
      for (int m = 0; m < 2; ++m) {
        const VecD s = hn::Mul(hn::Load(doubles, rays.direction[minor[m]] + r), inverse), from = start(minor[m]);
        farthest = hn::Max(farthest, hn::IfThenElseZero(there, hn::Abs(from)));
        hn::Store(s, doubles, slope[m] + r);
        hn::Store(hn::Sub(from, hn::Mul(s, at)), doubles, shift[m] + r);
      }
      const VecD from = hn::MulAdd(hn::Load(doubles, rays.t_min + r), d, at),
                 to = hn::MulAdd(hn::Load(doubles, rays.t_max + r), d, at);
      const VecD least = hn::Min(from, to), most = hn::Max(from, to);
      hn::Store(least, doubles, begin + r);
      hn::Store(most, doubles, end + r);
      const MaskD goes_through = hn::And(hn::Le(least, hn::Neg(outside)), hn::Ge(most, outside));
      stops_short = hn::Or(stops_short, hn::AndNot(goes_through, there));
    }
    go_through = hn::AllFalse(doubles, stops_short);
    farthest_ = hn::GetLane(hn::MaxOfLanes(doubles, farthest));
    for (std::size_t quad = 0; 4 * quad < count; ++quad) {
      const auto place = [&](const double* from, double* to)
                             HWY_ATTR { std::memcpy(to + lane_of(4 * quad), from + 4 * quad, 4 * sizeof(double)); };
      for (int m = 0; m < 2; ++m) place(slope[m], scratch_.slope[m]), place(shift[m], scratch_.shift[m]);
      place(begin, scratch_.begin), place(end, scratch_.end);
    }
    for (std::size_t r = 0; r < TetScratch::lanes; r += double_lanes) {
      const MaskD living = mask_of(doubles, alive >> r);
      hn::Store(hn::IfThenElse(living, hn::Set(doubles, -infinite), hn::Set(doubles, infinite)), doubles,
                scratch_.reached + r);
    }
    for (std::size_t r = 0; r < TetScratch::lanes; r += float_lanes)
      hn::Store(hn::IfThenElse(mask_of(floats, alive >> r), hn::Set(floats, -1.0f), hn::Set(floats, 2.0f)), floats,
                scratch_.reached_share + r);
  }

  /// The minimum of linear functions is above the straight line between any two of its values.
  HWY_INLINE void bound_packs() {
    const double low = field_.low[w] - middle[w], high = field_.high[w] - middle[w];
    // Over a short distance a slope would be lost in rounding, so the bounds are constant there.
    const bool is_short = high - low < 1e-6 * (field_.high[u] - field_.low[u] + field_.high[v] - field_.low[v]);
    const double inverse = is_short ? 0 : 1 / (high - low), unit = field_.box_unit;
    double group_low[4], group_high[4];
    for (int l = 0; l < 4; ++l) group_low[l] = group_high[l] = -infinite;
    for (std::size_t p = 0; p < TetScratch::packs; ++p) {
      const std::uint64_t in_pack = alive >> TetScratch::pack * p & pack_bits;
      if (in_pack == 0) continue;
      for (int m = 0; m < 2; ++m) {
        VecD least[2], most[2];
        for (int e = 0; e < 2; ++e) least[e] = hn::Set(doubles, infinite), most[e] = hn::Set(doubles, -infinite);
        for (std::size_t i = 0; i < TetScratch::pack; i += double_lanes) {
          const std::size_t r = TetScratch::pack * p + i;
          const MaskD living = mask_of(doubles, in_pack >> i);
          const VecD slope = hn::Load(doubles, scratch_.slope[m] + r), shift = hn::Load(doubles, scratch_.shift[m] + r);
          for (int e = 0; e < 2; ++e) {
            const VecD place = hn::MulAdd(slope, hn::Set(doubles, e == 0 ? low : high), shift);
            least[e] = hn::Min(least[e], hn::IfThenElse(living, place, least[e]));
            most[e] = hn::Max(most[e], hn::IfThenElse(living, place, most[e]));
          }
        }
        for (int side = 0; side < 2; ++side) {
          const int l = 2 * m + side;
          double at[2];
          for (int e = 0; e < 2; ++e)
            at[e] = side == 0 ? -hn::GetLane(hn::MinOfLanes(doubles, least[e]))
                              : hn::GetLane(hn::MaxOfLanes(doubles, most[e]));
          group_low[l] = larger(group_low[l], at[0]), group_high[l] = larger(group_high[l], at[1]);
          const double slope = (at[1] - at[0]) * inverse;
          scratch_.line_slope[4 * p + static_cast<std::size_t>(l)] = slope;
          scratch_.line_offset[4 * p + static_cast<std::size_t>(l)] =
              is_short ? larger(at[0], at[1]) : at[0] - slope * low;
        }
      }
    }
    for (int l = 0; l < 4; ++l) {
      const double slope = (group_high[l] - group_low[l]) * inverse;
      const double offset = is_short ? larger(group_low[l], group_high[l]) : group_low[l] - slope * low;
      const double side = l % 2 == 0 ? -1 : 1, across = middle[l < 2 ? u : v];
      group_slope[l] = static_cast<float>(slope);
      group_offset[l] = static_cast<float>((offset + side * across - slope * middle[w]) / unit);
    }
  }

  /// Computes the rays in units of boxes. Rays that hit the mesh have positions, including shifts,
  /// of at most twice the largest coordinate. These, slopes, and what is computed from both have an
  /// error of 2^-24 of that each.
  HWY_INLINE void describe_for_tree(double largest) {
    const double inverse = 1 / field_.box_unit;  // a power of two
    tree_margin = static_cast<float>((0x1p-19 * largest + place_error) * inverse);
    const int minor[2] = {u, v};
    VecF least = hn::Set(floats, std::numeric_limits<float>::max()), most = hn::Neg(least);
    for (std::size_t r = 0; r < TetScratch::lanes; r += double_lanes) {
      const auto store = [&](VecD x, float* to)
                             HWY_ATTR { hn::Store(hn::DemoteTo(half_floats, x), half_floats, to + r); };
      for (int m = 0; m < 2; ++m) {
        const VecD slope = hn::Load(doubles, scratch_.slope[m] + r);
        const VecD shift =
            hn::Add(hn::Load(doubles, scratch_.shift[m] + r),
                    hn::NegMulAdd(slope, hn::Set(doubles, middle[w]), hn::Set(doubles, middle[minor[m]])));
        store(slope, scratch_.tree_slope[m]);
        store(hn::Mul(shift, hn::Set(doubles, inverse)), scratch_.tree_shift[m]);
      }
      const auto along = [&](const double* from) HWY_ATTR {
        return hn::Mul(hn::Add(hn::Load(doubles, from + r), hn::Set(doubles, middle[w])), hn::Set(doubles, inverse));
      };
      store(along(scratch_.begin), scratch_.tree_begin);
      store(along(scratch_.end), scratch_.tree_end);
    }
    for (std::size_t r = 0; r < TetScratch::lanes; r += float_lanes) {
      const MaskF living = mask_of(floats, alive >> r);
      least = hn::Min(least, hn::IfThenElse(living, hn::Load(floats, scratch_.tree_begin + r), least));
      most = hn::Max(most, hn::IfThenElse(living, hn::Load(floats, scratch_.tree_end + r), most));
    }
    first = hn::GetLane(hn::MinOfLanes(floats, least)), last = hn::GetLane(hn::MaxOfLanes(floats, most));
  }

  static constexpr std::uint64_t pack_bits = (std::uint64_t{1} << TetScratch::pack) - 1;
};

}  // namespace
}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
