#include <bit>
#include <cstring>

#include "render/kernels/triangle_start.h"
#include "render/kernels/wide/facets_parts.h"
#include "render/march/ticks.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/kernels/wide/facets.cpp"
#include <hwy/foreach_target.h>  // compiles what follows once per machine

#include <hwy/highway.h>

#include "render/kernels/wide/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

inline constexpr std::size_t pack = FacetScratch::pack, packs = FacetScratch::packs, lanes = FacetScratch::lanes;
inline constexpr std::uint64_t pack_bits = (std::uint64_t{1} << pack) - 1;

using Longs = hn::RebindToSigned<Doubles>;
using UnsignedLongs = hn::RebindToUnsigned<Doubles>;
using Counts = hn::Rebind<std::uint32_t, Doubles>;
using VecI64 = hn::Vec<Longs>;
inline constexpr Longs longs{};
inline constexpr UnsignedLongs unsigned_longs{};
inline constexpr Counts counts{};

/// Larger than any number in the facets' frame that matters, and small enough for sums.
inline constexpr float beyond = 1e30f;

/// The depth of what is nowhere.
inline constexpr float never = 4 * beyond;

/// What bounds of a group are widened by: more than the rounding of places and of the bounds themselves.
inline constexpr float bound_margin = 0x1p-20f;

/// Rays of a chunk by the axis on which they move most, and by the way they move along it.
struct Directions {
  std::uint64_t along[3];
  std::uint64_t down[3];
  std::uint64_t usable;  ///< rays of finite numbers, that move, and start near enough
};

HWY_INLINE Directions directions_of(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                                    double farthest) {
  Directions bits{};
  const VecD largest_start = hn::Set(doubles, farthest / surface.scale);
  for (std::size_t r = 0; r < count; r += double_lanes) {
    VecD size[3], d[3];
    MaskD usable = hn::And(hn::FirstN(doubles, count - r),
                           hn::Le(hn::Load(doubles, rays.t_min + r), hn::Load(doubles, rays.t_max + r)));
    for (int a = 0; a < 3; ++a) {
      d[a] = hn::Load(doubles, rays.direction[a] + r);
      size[a] = hn::Abs(d[a]);
      const VecD start = hn::Sub(hn::Load(doubles, rays.origin[a] + r), hn::Set(doubles, surface.anchor[a]));
      usable = hn::And(usable, hn::And(is_finite(d[a]), hn::Le(hn::Abs(start), largest_start)));
    }
    const MaskD x = hn::And(hn::Ge(size[0], size[1]), hn::Ge(size[0], size[2]));
    const MaskD y = hn::AndNot(x, hn::Ge(size[1], size[2]));
    const VecD largest = hn::Max(size[0], hn::Max(size[1], size[2]));
    usable = hn::And(usable,
                     hn::And(hn::Gt(largest, hn::Set(doubles, 0x1p-400)), hn::Lt(largest, hn::Set(doubles, 0x1p400))));
    const MaskD along[3] = {x, y, hn::Not(hn::Or(x, y))};
    for (int a = 0; a < 3; ++a) {
      bits.along[a] |= bits_of(doubles, hn::And(usable, along[a])) << r;
      bits.down[a] |= bits_of(doubles, hn::Lt(d[a], hn::Zero(doubles))) << r;
    }
    bits.usable |= bits_of(doubles, usable) << r;
  }
  return bits;
}

/// The lanes of a chunk's rays.
HWY_INLINE std::uint64_t lanes_of(std::uint64_t rays) {
  std::uint64_t in_lanes = 0;
  for (std::size_t quad = 0; quad < lanes / 4; ++quad) in_lanes |= (rays >> 4 * quad & 15) << lane_of(4 * quad);
  return in_lanes;
}

HWY_INLINE float least_of(VecF v) {
  return hn::GetLane(hn::MinOfLanes(floats, v));
}
HWY_INLINE float largest_of(VecF v) {
  return hn::GetLane(hn::MaxOfLanes(floats, v));
}

/// x_a y_b - y_a x_b. Without a fused operation: the rounded products of the edge seen from its other end are the same
/// ones, so that the sign is opposite to the bit; and as rounding is monotone, it is never the wrong one.
HWY_INLINE VecF edge_function(VecF ax, VecF ay, VecF bx, VecF by) {
  return hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx));
}

/// The rays of a chunk that move most along one axis, one way.
template <bool certified>
class FacetWalk {
 public:
  HWY_INLINE FacetWalk(const FacetSurface& surface, const RayArrays& rays, std::size_t count, const HitArrays& hits,
                       int axis, bool down, FacetScratch& scratch, KernelCounters& counters)
      : surface_(surface),
        rays_(rays),
        hits_(hits),
        scratch_(scratch),
        counters_(counters),
        count_(count),
        u_((axis + 1) % 3),
        v_((axis + 2) % 3),
        w_(axis),
        sign_(down ? -1.0f : 1.0f) {
    describe_rays();
  }

  /// Traces these lanes: together where they lie close, else pack by pack, or each alone.
  void trace(std::uint64_t lanes_alive) {
    begin_group(lanes_alive);
    if (is_narrow(lanes_alive)) return walk(lanes_alive);
    for (std::size_t p = 0; p < packs; ++p) {
      const std::uint64_t in_pack = lanes_alive & pack_bits << pack * p;
      if (in_pack == 0) continue;
      begin_group(in_pack);
      if (is_narrow(in_pack)) {
        walk(in_pack);
        continue;
      }
      for (std::uint64_t bits = in_pack; bits != 0; bits &= bits - 1) {
        const std::uint64_t alone = bits & (~bits + 1);
        begin_group(alone);
        walk(alone);
      }
    }
  }

  HWY_INLINE Unanswered unanswered() const { return unanswered_; }

 private:
  /// Of all rays of the chunk, as if all moved along this axis; those that do not, stay without hits.
  HWY_INLINE void describe_rays() {
    HWY_ALIGN float slope[2][lanes], shift[2][lanes], begin[lanes], end[lanes];
    const VecD scale = hn::Set(doubles, surface_.scale);
    const VecD towards = hn::Set(doubles, static_cast<double>(sign_));
    const int minor[2] = {u_, v_};
    for (std::size_t r = 0; r < count_; r += double_lanes) {
      const VecD d = hn::Load(doubles, rays_.direction[w_] + r);
      const VecD inverse = hn::Div(hn::Set(doubles, 1.0), d);
      const auto start = [&](int axis) HWY_ATTR {
        return hn::Mul(hn::Sub(hn::Load(doubles, rays_.origin[axis] + r), hn::Set(doubles, surface_.anchor[axis])),
                       scale);
      };
      const VecD w = start(w_);
      for (int m = 0; m < 2; ++m) {
        const VecD s = hn::Mul(hn::Load(doubles, rays_.direction[minor[m]] + r), inverse);
        store(s, slope[m] + r);
        store(hn::Sub(start(minor[m]), hn::Mul(s, w)), shift[m] + r);
      }
      const VecD speed = hn::Mul(d, scale);
      store(hn::Mul(towards, hn::MulAdd(hn::Load(doubles, rays_.t_min + r), speed, w)), begin + r);
      store(hn::Mul(towards, hn::MulAdd(hn::Load(doubles, rays_.t_max + r), speed, w)), end + r);
    }
    if (rays_.start_side != nullptr)
      for (std::size_t r = 0; r < count_; ++r)
        scratch_.start_side[lane_of(r)] = static_cast<float>(rays_.start_side[r]);
    for (std::size_t quad = 0; 4 * quad < count_; ++quad) {
      const auto place = [&](const float* from, float* to)
                             HWY_ATTR { std::memcpy(to + lane_of(4 * quad), from + 4 * quad, 4 * sizeof(float)); };
      for (int m = 0; m < 2; ++m) place(slope[m], scratch_.slope[m]), place(shift[m], scratch_.shift[m]);
      place(begin, scratch_.begin), place(end, scratch_.end);
    }
  }

  /// Numbers too large for floats become large ones.
  HWY_INLINE static void store(VecD v, float* to) {
    const VecD largest = hn::Set(doubles, static_cast<double>(beyond));
    hn::StoreU(hn::DemoteTo(half_floats, hn::Max(hn::Min(v, largest), hn::Neg(largest))), half_floats, to);
  }

  HWY_INLINE MaskF alive_in(std::uint64_t lanes_alive, std::size_t lane) const {
    return mask_of(floats, lanes_alive >> lane);
  }

  /// Makes these lanes, and no others, ready, and bounds the places of their rays.
  void begin_group(std::uint64_t lanes_alive) {
    const VecF none = hn::Set(floats, -beyond);
    float first = beyond, last = -beyond;
    for (std::size_t r = 0; r < lanes; r += float_lanes) {
      const MaskF alive = alive_in(lanes_alive, r);
      const VecF begin = hn::Load(floats, scratch_.begin + r), end = hn::Load(floats, scratch_.end + r);
      hn::Store(hn::IfThenElse(alive, end, none), floats, scratch_.depth + r);
      hn::Store(hn::Set(ints, FacetScratch::no_facet), ints, scratch_.facet + r);
      if constexpr (certified) {
        hn::Store(hn::IfThenElse(alive, end, none), floats, scratch_.far + r);
        hn::Store(hn::Set(floats, never), floats, scratch_.nearest + r);
        hn::Store(hn::Set(floats, never), floats, scratch_.second + r);
        hn::Store(hn::Set(floats, never), floats, scratch_.doubt + r);
      }
      const float least = least_of(hn::IfThenElse(alive, begin, hn::Set(floats, beyond)));
      const float most = largest_of(hn::IfThenElse(alive, end, none));
      first = least < first ? least : first, last = most > last ? most : last;
    }
    // The part of the facets' box, along w, in which there are rays.
    first -= bound_margin, last += bound_margin;
    const bool down = sign_ < 0;
    const float low = down ? -last : first, high = down ? -first : last;
    w_low_ = surface_.low[w_] > low ? surface_.low[w_] : low;
    w_high_ = surface_.high[w_] < high ? surface_.high[w_] : high;
    if (has_facets()) bound_places(lanes_alive);
  }

  /// False where no facet lies between the depths at which the group's rays begin and end.
  HWY_INLINE bool has_facets() const { return surface_.facet_count != 0 && w_low_ <= w_high_; }

  /// Lines that the places of each pack's rays keep between, and the group's: u at w is at least -(offset + slope w) by
  /// the first of four, at most offset + slope w by the second; v by the others. The least of linear functions lies
  /// above the straight line between any two of its values.
  HWY_INLINE void bound_places(std::uint64_t lanes_alive) {
    HWY_ALIGN float at_low[lanes / 4], at_high[lanes / 4];
    const VecF w_low = hn::Set(floats, w_low_), w_high = hn::Set(floats, w_high_);
    for (std::size_t p = 0; p < packs; ++p) {
      float* bound[2] = {at_low + 4 * p, at_high + 4 * p};
      if ((lanes_alive >> pack * p & pack_bits) == 0) {
        for (int l = 0; l < 4; ++l) bound[0][l] = bound[1][l] = -beyond;
        continue;
      }
      for (int m = 0; m < 2; ++m) {
        VecF least[2], most[2];
        for (int e = 0; e < 2; ++e) least[e] = hn::Set(floats, beyond), most[e] = hn::Set(floats, -beyond);
        for (std::size_t i = 0; i < pack; i += float_lanes) {
          const std::size_t r = pack * p + i;
          const MaskF alive = alive_in(lanes_alive, r);
          const VecF slope = hn::Load(floats, scratch_.slope[m] + r), shift = hn::Load(floats, scratch_.shift[m] + r);
          for (int e = 0; e < 2; ++e) {
            const VecF place = hn::MulAdd(slope, e == 0 ? w_low : w_high, shift);
            least[e] = hn::Min(least[e], hn::IfThenElse(alive, place, least[e]));
            most[e] = hn::Max(most[e], hn::IfThenElse(alive, place, most[e]));
          }
        }
        for (int e = 0; e < 2; ++e) {
          bound[e][2 * m] = bound_margin - least_of(least[e]);
          bound[e][2 * m + 1] = bound_margin + largest_of(most[e]);
        }
      }
    }
    for (int l = 0; l < 4; ++l) {
      group_at_low_[l] = group_at_high_[l] = -beyond;
      for (std::size_t p = 0; p < packs; ++p) {
        const float low = at_low[4 * p + static_cast<std::size_t>(l)],
                    high = at_high[4 * p + static_cast<std::size_t>(l)];
        group_at_low_[l] = low > group_at_low_[l] ? low : group_at_low_[l];
        group_at_high_[l] = high > group_at_high_[l] ? high : group_at_high_[l];
      }
    }
    // Over a short way a slope would be lost in rounding: there the bounds are constant.
    const bool is_short = w_high_ - w_low_ < 0x1p-8f;
    const VecF inverse = hn::Set(floats, is_short ? 0.0f : 1 / (w_high_ - w_low_));
    for (std::size_t i = 0; i < lanes / 4; i += float_lanes) {
      const VecF low = hn::Load(floats, at_low + i), high = hn::Load(floats, at_high + i);
      const VecF slope = hn::Mul(hn::Sub(high, low), inverse);
      const VecF base = is_short ? hn::Max(low, high) : low;
      hn::Store(slope, floats, scratch_.cull_slope + i);
      hn::Store(hn::NegMulAdd(slope, w_low, base), floats, scratch_.cull_offset + i);
    }
    for (int l = 0; l < 4; ++l) {
      const float low = group_at_low_[l], high = group_at_high_[l];
      line_slope_[l] = is_short ? 0.0f : (high - low) / (w_high_ - w_low_);
      line_offset_[l] = (is_short && high > low ? high : low) - line_slope_[l] * w_low_;
    }
  }

  /// False when the rays lie so far apart that most of what one meets is met by no other; reckoned with facets spread
  /// evenly over their box.
  HWY_INLINE bool is_narrow(std::uint64_t lanes_alive) const {
    if ((lanes_alive & (lanes_alive - 1)) == 0 || !has_facets()) return true;
    float share = 1;
    for (int m = 0; m < 2; ++m) {
      const int axis = m == 0 ? u_ : v_;
      const float size = surface_.high[axis] - surface_.low[axis] + bound_margin;
      const float at_low = group_at_low_[2 * m] + group_at_low_[2 * m + 1];
      const float at_high = group_at_high_[2 * m] + group_at_high_[2 * m + 1];
      const float width = (at_low > at_high ? at_low : at_high) / size;
      share *= width < 1 ? width : 1;
    }
    constexpr float facets_per_ray = 24;
    return share * static_cast<float>(surface_.facet_count) <=
           facets_per_ray * static_cast<float>(std::popcount(lanes_alive));
  }

  struct Entry {
    float near;
    std::uint32_t node;
    std::int32_t level;  ///< -1: a block
  };

  void walk(std::uint64_t lanes_alive) {
    visits_ = 0;
    if (has_facets()) {
      for (std::size_t p = 0; p < packs; ++p) find_pack_far(p);
      find_group_far();
      Entry stack[(FacetNode::size - 1) * FacetSurface::largest_level_count + 1];
      std::size_t top = 0;
      stack[top++] = {-beyond, 0, surface_.level_count - 1};
      while (top != 0) {
        const Entry entry = stack[--top];
        if (entry.near > group_far_) continue;
        ++visits_;
        if (entry.level >= 0) {
          open(entry, stack, top);
          ++nodes_;
        } else {
          const std::uint64_t start = surface_.time_phases ? ticks_now() : 0;
          look_into(entry.node);
          if (surface_.time_phases) counters_.intersection_ticks += ticks_now() - start;
          ++blocks_;
        }
      }
    }
    finish(lanes_alive);
  }

  /// Puts those children of a node that the group may meet on the stack, the nearest on top.
  HWY_INLINE void open(const Entry& entry, Entry* stack, std::size_t& top) {
    const FacetNode& node = surface_.levels[entry.level][entry.node];
    HWY_ALIGN float near_of[FacetNode::size];
    std::uint64_t met = 0;
    for (std::size_t i = 0; i < FacetNode::size; i += float_lanes) {
      const VecF w_low = hn::Max(hn::Load(floats, node.low[w_] + i), hn::Set(floats, w_low_));
      const VecF w_high = hn::Min(hn::Load(floats, node.high[w_] + i), hn::Set(floats, w_high_));
      const VecF near = sign_ < 0 ? hn::Neg(w_high) : w_low;
      MaskF in = hn::And(hn::Le(w_low, w_high), hn::Le(near, hn::Set(floats, group_far_)));
      for (int m = 0; m < 2; ++m) {
        const int axis = m == 0 ? u_ : v_;
        const VecF low = hn::Load(floats, node.low[axis] + i), high = hn::Load(floats, node.high[axis] + i);
        const auto bound = [&](int l) HWY_ATTR {
          return hn::MulAdd(hn::Set(floats, line_slope_[l]), line_slope_[l] > 0 ? w_high : w_low,
                            hn::Set(floats, line_offset_[l]));
        };
        in = hn::And(in, hn::Ge(hn::Add(bound(2 * m), high), hn::Zero(floats)));
        in = hn::And(in, hn::Ge(hn::Sub(bound(2 * m + 1), low), hn::Zero(floats)));
      }
      hn::Store(near, floats, near_of + i);
      met |= bits_of(floats, in) << i;
    }
    const std::size_t bottom = top;
    for (; met != 0; met &= met - 1) {
      const auto child = static_cast<std::uint32_t>(std::countr_zero(met));
      const Entry added{near_of[child], FacetNode::size * entry.node + child, entry.level - 1};
      std::size_t place = top++;
      for (; place > bottom && stack[place - 1].near < added.near; --place) stack[place] = stack[place - 1];
      stack[place] = added;
    }
  }

  /// Facets of a block that the group may meet, one by one.
  HWY_INLINE void look_into(std::uint32_t block_index) {
    const FacetBlock& block = surface_.blocks[block_index];
    const std::uint32_t first = block_index * FacetBlock::size;
    const std::uint32_t in_block =
        surface_.facet_count - first < FacetBlock::size ? surface_.facet_count - first : FacetBlock::size;
    std::uint64_t met = 0;
    for (std::size_t i = 0; i < FacetBlock::size; i += float_lanes) {
      VecF w[4];
      for (int c = 0; c < 4; ++c) w[c] = hn::Load(floats, block.corner[c][w_] + i);
      const VecF w_low = hn::Min(hn::Min(w[0], w[1]), hn::Min(w[2], w[3]));
      const VecF w_high = hn::Max(hn::Max(w[0], w[1]), hn::Max(w[2], w[3]));
      const VecF near = sign_ < 0 ? hn::Neg(w_high) : w_low;
      hn::Store(near, floats, facet_near_ + i);
      hn::Store(sign_ < 0 ? hn::Neg(w_low) : w_high, floats, facet_far_ + i);
      MaskF in = hn::And(hn::Ge(w_high, hn::Set(floats, w_low_)), hn::Le(w_low, hn::Set(floats, w_high_)));
      in = hn::And(in, hn::Le(near, hn::Set(floats, group_far_)));
      VecF size = hn::Sub(w_high, w_low);
      for (int m = 0; m < 2; ++m) {
        const int axis = m == 0 ? u_ : v_;
        VecF below = hn::Set(floats, -beyond), above = below;  // the most that any corner is within a bound
        VecF low = hn::Set(floats, beyond), high = hn::Set(floats, -beyond);
        for (int c = 0; c < 4; ++c) {
          const VecF place = hn::Load(floats, block.corner[c][axis] + i);
          const auto bound = [&](int l) HWY_ATTR {
            return hn::MulAdd(hn::Set(floats, line_slope_[l]), w[c], hn::Set(floats, line_offset_[l]));
          };
          below = hn::Max(below, hn::Add(bound(2 * m), place));
          above = hn::Max(above, hn::Sub(bound(2 * m + 1), place));
          if constexpr (certified) low = hn::Min(low, place), high = hn::Max(high, place);
        }
        in = hn::And(in, hn::And(hn::Ge(below, hn::Zero(floats)), hn::Ge(above, hn::Zero(floats))));
        if constexpr (certified) size = hn::Max(size, hn::Sub(high, low));
      }
      if constexpr (certified) {
        // Corners of a facet near a ray have places of at most twice its size, d: products of a place and an error, of
        // two errors, and the rounding of two products and a difference.
        const VecF d = hn::Add(size, size);
        const VecF factor = hn::MulAdd(hn::Set(floats, 1.25f), d, hn::Set(floats, 4.25f));
        const VecF margin =
            hn::Mul(hn::Set(floats, place_error), hn::MulAdd(d, factor, hn::Set(floats, 3 * place_error)));
        hn::Store(margin, floats, margin_ + i);
      }
      met |= bits_of(floats, in) << i;
    }
    met &= (std::uint64_t{1} << in_block) - 1;
    std::uint32_t changed = 0;
    for (; met != 0; met &= met - 1)
      changed |= test_facet(block, first, static_cast<std::uint32_t>(std::countr_zero(met)));
    if (changed == 0) return;
    for (; changed != 0; changed &= changed - 1) find_pack_far(static_cast<std::size_t>(std::countr_zero(changed)));
    find_group_far();
  }

  /// A facet's corners in all lanes.
  struct Corners {
    VecF u[4], v[4], w[4];
  };

  /// @return  the packs of which a ray was hit
  HWY_INLINE std::uint32_t test_facet(const FacetBlock& block, std::uint32_t first, std::uint32_t f) {
    Corners corners;
    for (int c = 0; c < 4; ++c) {
      corners.u[c] = hn::Set(floats, block.corner[c][u_][f]);
      corners.v[c] = hn::Set(floats, block.corner[c][v_][f]);
      corners.w[c] = hn::Set(floats, block.corner[c][w_][f]);
    }
    std::uint64_t outside = 0;
    HWY_ALIGN static constexpr float sign_of_u[16] = {1, -1, 0, 0, 1, -1, 0, 0, 1, -1, 0, 0, 1, -1, 0, 0};
    HWY_ALIGN static constexpr float sign_of_v[16] = {0, 0, 1, -1, 0, 0, 1, -1, 0, 0, 1, -1, 0, 0, 1, -1};
    for (std::size_t i = 0; i < lanes / 4; i += float_lanes) {
      const VecF slope = hn::Load(floats, scratch_.cull_slope + i), offset = hn::Load(floats, scratch_.cull_offset + i);
      const VecF along_u = hn::Load(floats, sign_of_u + i), along_v = hn::Load(floats, sign_of_v + i);
      VecF within = hn::Set(floats, -beyond);
      for (int c = 0; c < 4; ++c) {
        const VecF bound = hn::MulAdd(slope, corners.w[c], offset);
        within = hn::Max(within, hn::MulAdd(along_u, corners.u[c], hn::MulAdd(along_v, corners.v[c], bound)));
      }
      outside |= bits_of(floats, hn::Lt(within, hn::Zero(floats))) << i;
    }
    std::uint32_t changed = 0;
    for (std::size_t p = 0; p < packs; ++p) {
      if ((outside >> 4 * p & 15) != 0 || facet_near_[f] > scratch_.pack_far[p]) continue;
      ++tests_;
      if (test_pack(corners, p, first + f, f)) changed |= 1U << p;
    }
    return changed;
  }

  /// @return  true when a ray was hit
  HWY_INLINE bool test_pack(const Corners& corners, std::size_t p, std::uint32_t facet, std::uint32_t f) {
    bool changed = false;
    const VecF zero = hn::Zero(floats);
    for (std::size_t i = 0; i < pack; i += float_lanes) {
      const std::size_t r = pack * p + i;
      const VecF slope_u = hn::Load(floats, scratch_.slope[0] + r), slope_v = hn::Load(floats, scratch_.slope[1] + r);
      const VecF shift_u = hn::Load(floats, scratch_.shift[0] + r), shift_v = hn::Load(floats, scratch_.shift[1] + r);
      VecF x[4], y[4];
      for (int c = 0; c < 4; ++c) {
        x[c] = hn::Sub(hn::NegMulAdd(slope_u, corners.w[c], corners.u[c]), shift_u);
        y[c] = hn::Sub(hn::NegMulAdd(slope_v, corners.w[c], corners.v[c]), shift_v);
      }
      const VecF ab = edge_function(x[0], y[0], x[1], y[1]), bc = edge_function(x[1], y[1], x[2], y[2]);
      const VecF cd = edge_function(x[2], y[2], x[3], y[3]), da = edge_function(x[3], y[3], x[0], y[0]);
      const VecF ac = edge_function(x[0], y[0], x[2], y[2]), ca = hn::Neg(ac);
      MaskF is_abc, any;
      if constexpr (certified) {
        const VecF margin = hn::Set(floats, margin_[f]), minus = hn::Neg(margin);
        const VecF least = hn::Min(hn::Min(ab, bc), hn::Min(cd, da)), most = hn::Max(hn::Max(ab, bc), hn::Max(cd, da));
        any = hn::Or(hn::Ge(least, minus), hn::Le(most, margin));
        if (hn::AllFalse(floats, any)) continue;
        // The edge between the ends of a triangle's last corner is none.
        const MaskF is_triangle =
            hn::And(hn::And(hn::Eq(corners.u[2], corners.u[3]), hn::Eq(corners.v[2], corners.v[3])),
                    hn::Eq(corners.w[2], corners.w[3]));
        const VecF third = hn::IfThenElse(is_triangle, bc, cd);
        const VecF least_edge = hn::Min(hn::Min(ab, bc), hn::Min(third, da)),
                   most_edge = hn::Max(hn::Max(ab, bc), hn::Max(third, da));
        const MaskF sure = hn::Or(hn::Gt(least_edge, margin), hn::Lt(most_edge, minus));
        changed |= note_certified(corners, x, y, sure, any, ab, bc, cd, da, ac, r, facet, f);
        continue;
      }
      const VecF least_abc = hn::Min(hn::Min(ab, bc), ca), most_abc = hn::Max(hn::Max(ab, bc), ca);
      const VecF least_acd = hn::Min(hn::Min(cd, da), ac), most_acd = hn::Max(hn::Max(cd, da), ac);
      is_abc = hn::Or(hn::Ge(least_abc, zero), hn::Le(most_abc, zero));
      const MaskF is_acd = hn::Or(hn::Ge(least_acd, zero), hn::Le(most_acd, zero));
      any = hn::Or(is_abc, is_acd);
      if (hn::AllFalse(floats, any)) continue;
      // A triangle seen edge-on has no inside: where it has neighbours, they are met.
      const VecF weight_abc = hn::Add(hn::Add(ab, bc), ca), weight_acd = hn::Add(hn::Add(cd, da), ac);
      is_abc = hn::And(is_abc, hn::Ne(weight_abc, zero));
      any = hn::Or(is_abc, hn::And(is_acd, hn::Ne(weight_acd, zero)));
      const VecF depth =
          depth_at(corners, is_abc, ab, bc, cd, da, ac, hn::IfThenElse(is_abc, weight_abc, weight_acd), f);
      const VecF best = hn::Load(floats, scratch_.depth + r);
      const VecI best_facet = hn::Load(ints, scratch_.facet + r),
                 this_facet = hn::Set(ints, static_cast<std::int32_t>(facet));
      const MaskF is_lower = hn::RebindMask(floats, hn::Lt(this_facet, best_facet));
      const MaskF is_first = hn::Or(hn::Lt(depth, best), hn::And(hn::Eq(depth, best), is_lower));
      MaskF hit = hn::And(hn::And(any, is_first), hn::Ge(depth, hn::Load(floats, scratch_.begin + r)));
      if (rays_.start_side != nullptr)
        hit = hn::And(hit, leaves_start_side(corners, facet, slope_u, slope_v, shift_u, shift_v, r));
      if (hn::AllFalse(floats, hit)) continue;
      hn::Store(hn::IfThenElse(hit, depth, best), floats, scratch_.depth + r);
      hn::Store(hn::IfThenElse(hn::RebindMask(ints, hit), this_facet, best_facet), ints, scratch_.facet + r);
      changed = true;
    }
    return changed;
  }

  /// Rays that come to the facet on the side on which they start, or of which that is unknown.
  HWY_INLINE MaskF leaves_start_side(const Corners& corners, std::uint32_t facet, VecF slope_u, VecF slope_v,
                                     VecF shift_u, VecF shift_v, std::size_t r) const {
    const double* gradient = surface_.fields[facet].gradient;
    double largest = 0;
    for (int a = 0; a < 3; ++a) {
      const double size = gradient[a] < 0 ? -gradient[a] : gradient[a];
      largest = size > largest ? size : largest;
    }
    const auto component = [&](int axis)
                               HWY_ATTR { return hn::Set(floats, static_cast<float>(gradient[axis] / largest)); };
    const VecF rise = hn::Mul(hn::Set(floats, sign_),
                              hn::MulAdd(slope_u, component(u_), hn::MulAdd(slope_v, component(v_), component(w_))));
    const VecF start_side = hn::Load(floats, scratch_.start_side + r), leaving = hn::Mul(rise, start_side);
    // Written so that the facet of a flat cell, whose gradient is none, counts.
    if (!surface_.is_of_triangles) return hn::Not(hn::Gt(leaving, hn::Zero(floats)));
    // As starts_in of triangle_start.h; a normal here is 1 to 1.7 long.
    const VecF w = hn::Mul(hn::Set(floats, sign_), hn::Load(floats, scratch_.begin + r));
    const VecF away_u = hn::Sub(hn::MulAdd(slope_u, w, shift_u), corners.u[0]),
               away_v = hn::Sub(hn::MulAdd(slope_v, w, shift_v), corners.v[0]);
    const VecF away = hn::MulAdd(away_u, component(u_),
                                 hn::MulAdd(away_v, component(v_), hn::Mul(hn::Sub(w, corners.w[0]), component(w_))));
    const MaskF is_far = hn::Gt(hn::Abs(away), hn::Set(floats, static_cast<float>(start_distance)));
    return hn::Or(hn::Or(is_far, hn::Lt(leaving, hn::Zero(floats))), hn::Eq(start_side, hn::Zero(floats)));
  }

  /// The mean of the corners' depths by the areas opposite, between the least of them and the largest.
  HWY_INLINE VecF depth_at(const Corners& corners, MaskF is_abc, VecF ab, VecF bc, VecF cd, VecF da, VecF ac,
                           VecF weight, std::uint32_t f) const {
    const VecF of_a = hn::IfThenElse(is_abc, bc, cd), of_c = hn::IfThenElse(is_abc, ab, da);
    const VecF of_other = hn::IfThenElse(is_abc, hn::Neg(ac), ac),
               other = hn::IfThenElse(is_abc, corners.w[1], corners.w[3]);
    const VecF sum = hn::MulAdd(of_a, corners.w[0], hn::MulAdd(of_c, corners.w[2], hn::Mul(of_other, other)));
    const VecF depth = hn::Mul(hn::Set(floats, sign_), hn::Div(sum, weight));
    return hn::Min(hn::Max(depth, hn::Set(floats, facet_near_[f])), hn::Set(floats, facet_far_[f]));
  }

  /// Hits that are proven, and doubts.
  /// @param sure  rays that pass through the facet for certain; the exact one included
  /// @param any   rays that may pass through it
  HWY_INLINE bool note_certified(const Corners& corners, const VecF* x, const VecF* y, MaskF sure, MaskF any, VecF ab,
                                 VecF bc, VecF cd, VecF da, VecF ac, std::size_t r, std::uint32_t facet,
                                 std::uint32_t f) {
    const VecF zero = hn::Zero(floats), e = hn::Set(floats, place_error);
    for (const VecF* place : {x, y}) {
      const VecF least = hn::Min(hn::Min(place[0], place[1]), hn::Min(place[2], place[3]));
      const VecF most = hn::Max(hn::Max(place[0], place[1]), hn::Max(place[2], place[3]));
      any = hn::And(any, hn::And(hn::Le(least, e), hn::Ge(most, hn::Neg(e))));
    }
    const VecF begin = hn::Load(floats, scratch_.begin + r), end = hn::Load(floats, scratch_.end + r);
    const VecF facet_near = hn::Sub(hn::Set(floats, facet_near_[f]), e),
               facet_far = hn::Add(hn::Set(floats, facet_far_[f]), e);
    any = hn::And(any, hn::And(hn::Ge(facet_far, begin), hn::Le(facet_near, end)));
    const VecF far_before = hn::Load(floats, scratch_.far + r);
    any = hn::And(any, hn::Le(facet_near, far_before));
    if (hn::AllFalse(floats, any)) return false;
    if (surface_.fields[facet].doubt > beyond) sure = no_lane(floats);

    // On which side of the diagonal the ray passes is told by the diagonal.
    const VecF weight_abc = hn::Sub(hn::Add(ab, bc), ac), weight_acd = hn::Add(hn::Add(cd, da), ac);
    const VecF least_abc = hn::Min(hn::Min(ab, bc), hn::Neg(ac)), most_abc = hn::Max(hn::Max(ab, bc), hn::Neg(ac));
    const MaskF is_abc = hn::Or(hn::Ge(least_abc, zero), hn::Le(most_abc, zero));
    const VecF weight = hn::IfThenElse(is_abc, weight_abc, weight_acd);
    const VecF depth = depth_at(corners, is_abc, ab, bc, cd, da, ac, weight, f);
    // Weights are off by the margin each.
    const VecF thickness = hn::Sub(facet_far, facet_near);
    const VecF share = hn::Min(hn::Set(floats, 1.0f), hn::Div(hn::Set(floats, 4 * margin_[f]), hn::Abs(weight)));
    const VecF error = hn::MulAdd(thickness, share, hn::Add(e, e));
    const VecF low = hn::Sub(depth, error), high = hn::Add(depth, error);
    sure = hn::And(hn::And(sure, any), hn::And(hn::Gt(low, begin), hn::Lt(high, end)));
    const MaskF unsure = hn::AndNot(sure, any);

    VecF nearest = hn::Load(floats, scratch_.nearest + r), second = hn::Load(floats, scratch_.second + r);
    if (!hn::AllFalse(floats, unsure)) keep_doubts(unsure, facet_near, r, facet);
    second = hn::Min(second, hn::IfThenElse(sure, hn::Max(nearest, low), second));
    nearest = hn::Min(nearest, hn::IfThenElse(sure, low, nearest));
    hn::Store(second, floats, scratch_.second + r);
    hn::Store(nearest, floats, scratch_.nearest + r);
    const VecF best = hn::Load(floats, scratch_.depth + r);
    const MaskF hit = hn::And(sure, hn::Lt(depth, best));
    if (hn::AllFalse(floats, hit)) return false;
    const VecI best_facet = hn::Load(ints, scratch_.facet + r),
               this_facet = hn::Set(ints, static_cast<std::int32_t>(facet));
    hn::Store(hn::IfThenElse(hit, depth, best), floats, scratch_.depth + r);
    hn::Store(hn::IfThenElse(hit, high, far_before), floats, scratch_.far + r);
    hn::Store(hn::IfThenElse(hn::RebindMask(ints, hit), this_facet, best_facet), ints, scratch_.facet + r);
    return true;
  }

  /// In a certified answer: the facet is to be looked at again for these rays.
  HWY_INLINE void keep_doubts(MaskF unsure, VecF near, std::size_t r, std::uint32_t facet) {
    const VecF doubt = hn::Load(floats, scratch_.doubt + r);
    hn::Store(hn::Min(doubt, hn::IfThenElse(unsure, near, doubt)), floats, scratch_.doubt + r);
    for (std::uint64_t bits = bits_of(floats, unsure); bits != 0; bits &= bits - 1) {
      const auto ray = static_cast<std::uint32_t>(ray_of(r + static_cast<std::size_t>(std::countr_zero(bits))));
      if (scratch_.doubt_count < FacetScratch::doubt_capacity)
        scratch_.doubts[scratch_.doubt_count++] = {ray, facet};
      else
        unanswered_.whole |= std::uint64_t{1} << ray;
    }
  }

  HWY_INLINE void find_pack_far(std::size_t p) {
    const float* reach = certified ? scratch_.far : scratch_.depth;
    VecF most = hn::Load(floats, reach + pack * p);
    for (std::size_t i = float_lanes; i < pack; i += float_lanes)
      most = hn::Max(most, hn::Load(floats, reach + pack * p + i));
    scratch_.pack_far[p] = largest_of(most) + (certified ? 2 * place_error : 0);
  }
  HWY_INLINE void find_group_far() {
    group_far_ = scratch_.pack_far[0];
    for (std::size_t p = 1; p < packs; ++p)
      group_far_ = scratch_.pack_far[p] > group_far_ ? scratch_.pack_far[p] : group_far_;
  }

  /// Numbers of lanes, in the order of the rays from r on.
  template <class T>
  HWY_INLINE static void in_order_of_rays(const T* of_lanes, std::size_t r, T* out) {
    constexpr std::size_t run = double_lanes < 4 ? double_lanes : 4;
    for (std::size_t i = 0; i < double_lanes; i += run)
      std::memcpy(out + i, of_lanes + lane_of(r + i), run * sizeof(T));
  }
  HWY_INLINE static VecD depths(const float* of_lanes, std::size_t r) {
    HWY_ALIGN float ordered[lanes];
    in_order_of_rays(of_lanes, r, ordered);
    return hn::PromoteTo(doubles, hn::Load(half_floats, ordered));
  }

  /// Writes the hits of a group, and counts.
  HWY_INLINE void finish(std::uint64_t lanes_alive) {
    std::uint64_t rays_alive = 0;
    for (std::size_t quad = 0; quad < lanes / 4; ++quad)
      rays_alive |= (lanes_alive >> lane_of(4 * quad) & 15) << 4 * quad;
    for (std::size_t r = 0; r < count_; r += double_lanes)
      if (const std::uint64_t bits = rays_alive >> r & ((std::uint64_t{1} << double_lanes) - 1); bits != 0)
        finish_rays(bits, r);
    const auto ray_count = static_cast<std::uint64_t>(std::popcount(lanes_alive));
    counters_.macrocells_visited += nodes_ * ray_count;
    counters_.cells_visited += blocks_ * ray_count;
    counters_.cells_solved += tests_ * (ray_count < pack ? ray_count : pack);
    nodes_ = blocks_ = tests_ = 0;
  }

  /// @param alive  a bit for each of the rays from r on
  HWY_INLINE void finish_rays(std::uint64_t alive, std::size_t r) {
    hn::BlendedStore(hn::Set(counts, static_cast<std::uint32_t>(visits_)), mask_of(counts, alive), counts,
                     hits_.cost + r);
    HWY_ALIGN std::int32_t facet[lanes];
    in_order_of_rays(scratch_.facet, r, facet);
    const VecI64 index = hn::PromoteTo(longs, hn::Load(half_ints, facet));
    MaskD hit = hn::And(mask_of(doubles, alive),
                        hn::RebindMask(doubles, hn::Ne(index, hn::Set(longs, FacetScratch::no_facet))));
    if constexpr (certified) {
      const VecD far = hn::IfThenElse(hit, depths(scratch_.far, r), depths(scratch_.end, r));
      const MaskD not_proven = hn::Le(depths(scratch_.second, r), far);
      const MaskD in_doubt = hn::AndNot(not_proven, hn::Le(depths(scratch_.doubt, r), far));
      unanswered_.whole |= (bits_of(doubles, not_proven) & alive) << r;
      unanswered_.part |= (bits_of(doubles, in_doubt) & alive) << r;
      hit = hn::AndNot(not_proven, hit);
    }
    if (!hn::AllFalse(doubles, hit)) write_hits(hit, index, r);
  }

  /// The place is where the cell's own field is the isovalue, by its gradient in double; where rounding leads that out
  /// of the cell, or the cell is flat, it is the facet's.
  HWY_INLINE void write_hits(MaskD hit, VecI64 facet, std::size_t r) {
    static_assert(sizeof(FacetField) == 6 * sizeof(double));
    const VecI64 index = hn::IfThenElseZero(hn::RebindMask(longs, hit), facet);
    const VecI64 place = hn::Add(hn::ShiftLeft<2>(index), hn::Add(index, index));
    const double* fields = surface_.fields->gradient;
    const auto number = [&](int i) HWY_ATTR { return hn::GatherIndex(doubles, fields + i, place); };
    VecD value = number(3), speed = hn::Zero(doubles), gradient[3];
    for (int a = 0; a < 3; ++a) {
      gradient[a] = number(a);
      const VecD o = hn::Sub(hn::Load(doubles, rays_.origin[a] + r), hn::Set(doubles, surface_.anchor[a]));
      value = hn::MulAdd(gradient[a], o, value);
      speed = hn::MulAdd(gradient[a], hn::Load(doubles, rays_.direction[a] + r), speed);
      hn::BlendedStore(gradient[a], hit, doubles, hits_.gradient[a] + r);
    }
    const VecI64 sizes = hn::BitCast(longs, number(5));
    const VecD cell_size =
        hn::PromoteTo(doubles, hn::BitCast(half_floats, hn::TruncateTo(counts, hn::BitCast(unsigned_longs, sizes))));
    const VecD doubt = hn::PromoteTo(
        doubles,
        hn::BitCast(half_floats, hn::TruncateTo(counts, hn::ShiftRight<32>(hn::BitCast(unsigned_longs, sizes)))));
    const VecD d = hn::Load(doubles, rays_.direction[w_] + r);
    const VecD to_mesh = hn::Set(doubles, static_cast<double>(sign_) / surface_.scale);
    const VecD start = hn::Sub(hn::Load(doubles, rays_.origin[w_] + r), hn::Set(doubles, surface_.anchor[w_]));
    const VecD t_facet = hn::Div(hn::MulSub(depths(scratch_.depth, r), to_mesh, start), d);
    const VecD t_field = hn::Div(hn::Neg(value), speed);
    const VecD off = hn::Abs(hn::Mul(hn::Sub(t_field, t_facet), d));
    const MaskD is_near = hn::And(hn::Le(off, hn::Mul(cell_size, hn::Set(doubles, 0x1p-6))),
                                  hn::Lt(doubt, hn::Set(doubles, static_cast<double>(beyond))));
    const VecD t = hn::Min(hn::Max(hn::IfThenElse(is_near, t_field, t_facet), hn::Load(doubles, rays_.t_min + r)),
                           hn::Load(doubles, rays_.t_max + r));
    if constexpr (certified) hit = prove(hit, is_near, gradient, value, speed, t, cell_size, doubt, r);
    hn::BlendedStore(t, hit, doubles, hits_.t + r);
    hn::BlendedStore(hn::Set(doubles, surface_.isovalue), hit, doubles, hits_.value + r);
    const auto cell_and_tet = hn::BitCast(unsigned_longs, number(4));
    const auto hit_counts = mask_of(counts, bits_of(doubles, hit));
    hn::BlendedStore(hn::And(cell_and_tet, hn::Set(unsigned_longs, 0xffffffff)), hn::RebindMask(unsigned_longs, hit),
                     unsigned_longs, hits_.cell + r);
    hn::BlendedStore(hn::TruncateTo(counts, hn::ShiftRight<32>(cell_and_tet)), hit_counts, counts, hits_.tet + r);
    hn::BlendedStore(hn::Set(counts, 1), hit_counts, counts, hits_.root_count + r);
  }

  /// Writes the bounds of hits. With u = 2^-53: the field at the origin is off by 8u of the terms that are added up,
  /// and so is its slope; inside the cell by what the gradient is off by.
  /// @return  those that are good enough: within a quarter of a thousandth of the cell
  HWY_INLINE MaskD prove(MaskD hit, MaskD is_by_field, const VecD* gradient, VecD value, VecD speed, VecD t,
                         VecD cell_size, VecD doubt, std::size_t r) {
    VecD terms = hn::Abs(value), slopes = hn::Zero(doubles);
    for (int a = 0; a < 3; ++a) {
      const VecD g = hn::Abs(gradient[a]);
      const VecD o = hn::Sub(hn::Load(doubles, rays_.origin[a] + r), hn::Set(doubles, surface_.anchor[a]));
      terms = hn::MulAdd(g, hn::Add(hn::Abs(o), hn::Set(doubles, 1 / surface_.scale)), terms);
      slopes = hn::MulAdd(g, hn::Abs(hn::Load(doubles, rays_.direction[a] + r)), slopes);
    }
    const VecD rounding = hn::Mul(hn::Set(doubles, 0x1p-48), hn::MulAdd(hn::Abs(t), slopes, terms));
    const VecD error = hn::Div(hn::Add(doubt, rounding), hn::Abs(speed));
    const VecD largest = hn::Mul(hn::Set(doubles, 0.25e-3), cell_size);
    const VecD in_depth = hn::Mul(error, hn::Abs(hn::Load(doubles, rays_.direction[w_] + r)));
    const MaskD is_good = hn::And(is_by_field, hn::Le(in_depth, largest));
    hn::BlendedStore(error, hit, doubles, hits_.error + r);
    unanswered_.whole |= bits_of(doubles, hn::AndNot(is_good, hit)) << r;
    return hn::And(hit, is_good);
  }

  const FacetSurface& surface_;
  const RayArrays& rays_;
  const HitArrays& hits_;
  FacetScratch& scratch_;
  KernelCounters& counters_;
  std::size_t count_;
  int u_, v_, w_;
  float sign_;  ///< depth = sign w
  float w_low_ = 0, w_high_ = 0;
  float group_at_low_[4], group_at_high_[4], line_offset_[4], line_slope_[4];
  float group_far_ = 0;
  alignas(64) float facet_near_[FacetBlock::size], facet_far_[FacetBlock::size];
  alignas(
      64) float margin_[FacetBlock::size];  ///< certified: what an edge's function is off by, at most, near the facet
  Unanswered unanswered_;
  std::uint64_t visits_ = 0, nodes_ = 0, blocks_ = 0, tests_ = 0;
};

template <bool certified>
Unanswered first_facets(const FacetSurface& surface, const RayArrays& rays, std::size_t count, const HitArrays& hits,
                        FacetScratch& scratch, KernelCounters& counters) {
  const Directions directions = directions_of(surface, rays, count, certified ? certified_reach : reach);
  const std::uint64_t all = count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
  Unanswered unanswered{.whole = all & ~directions.usable};
  scratch.doubt_count = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool down : {false, true}) {
      const std::uint64_t chosen = directions.along[axis] & (down ? directions.down[axis] : ~directions.down[axis]);
      if (chosen == 0) continue;
      FacetWalk<certified> walk(surface, rays, count, hits, axis, down, scratch, counters);
      walk.trace(lanes_of(chosen));
      unanswered.whole |= walk.unanswered().whole;
      unanswered.part |= walk.unanswered().part;
    }
  unanswered.part &= ~unanswered.whole;
  return unanswered;
}

FirstFacets first_facets_by(bool certified) {
  return certified ? first_facets<true> : first_facets<false>;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace rhoray::render::wide {

FirstFacets first_facets_on(Machine machine, bool certified) {
#if HWY_TARGETS & HWY_AVX3
  if (machine == Machine::avx512) return N_AVX3::first_facets_by(certified);
#endif
#if HWY_TARGETS & HWY_AVX2
  if (machine == Machine::avx2) return N_AVX2::first_facets_by(certified);
#endif
#if HWY_TARGETS & HWY_SSE4
  if (__builtin_cpu_supports("sse4.1")) return N_SSE4::first_facets_by(certified);
#endif
  return HWY_NAMESPACE::first_facets_by(certified);
}

}  // namespace rhoray::render::wide

#endif
