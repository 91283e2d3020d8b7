// Where single precision leaves open what the largest value on a ray is, cells are looked at closely: in double, side
// by side.
#if defined(RHORAY_WIDE_MAXIMUM_LOOKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_LOOKS_INL_H
#undef RHORAY_WIDE_MAXIMUM_LOOKS_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_LOOKS_INL_H
#endif

#include <bit>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "render/kernels/wide/lanes-inl.h"
#include "render/kernels/wide/maximum_cubic-inl.h"
#include "render/kernels/wide/maximum_samples-inl.h"
#include "render/kernels/wide/maximum_state-inl.h"
#include "render/march/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// The scalar kernel's operations one by one (largest_in_cell<double>, grid_maximum.h), on the cells that are left.
class CloseLooks {
 public:
  explicit CloseLooks(SearchState& state) : state_(state), field_(state.field), scratch_(state.scratch) {}

  /// Puts the suspects of a box to the others, but for those that what was reached since rules out.
  /// @param low_w  where the box begins on the major axis
  HWY_NOINLINE void keep_suspects(double highest, double unit, double low_w) {
    BlockSuspects& at_hand = scratch_.at_hand;
    Suspects& suspects = scratch_.suspects;
    const double scale = 1 / unit;  // exact: a power of two
    for (std::size_t i = 0; i < at_hand.count; ++i) {
      const auto ray = static_cast<std::size_t>(at_hand.ray[i]);
      const double bound = highest + static_cast<double>(at_hand.bound[i]) * scale;
      const double from = low_w + static_cast<double>(at_hand.from[i]);
      if (!may_improve(ray, bound, from)) continue;
      suspects.ray[suspects.count] = at_hand.ray[i];
      suspects.from[suspects.count] = from;
      suspects.to[suspects.count] = low_w + static_cast<double>(at_hand.to[i]);
      suspects.bound[suspects.count++] = bound;
    }
    at_hand.count = 0;
    if (suspects.count > Suspects::capacity - BlockSuspects::capacity) decide();
  }

  /// Looks closely at the suspects that what was reached since does not rule out.
  HWY_NOINLINE void decide() {
    const std::uint64_t start = field_.time_phases ? ticks_now() : 0;
    Suspects& suspects = scratch_.suspects;
    for (std::size_t i = 0; i < suspects.count; ++i) {
      const auto ray = static_cast<std::size_t>(suspects.ray[i]);
      if (!may_improve(ray, suspects.bound[i], suspects.from[i])) continue;
      put_look(suspects.ray[i], state_.time_at(ray, suspects.from[i]), state_.time_at(ray, suspects.to[i]));
      if (scratch_.looks_left.count == first_looks) look_closely();
    }
    look_closely();
    suspects.count = 0;
    state_.find_lowest_reached();
    if (field_.time_phases) scratch_.ticks += ticks_now() - start;
  }

 private:
  /// False where no value up to `bound`, from that place on, takes the place of what was reached.
  HWY_INLINE bool may_improve(std::size_t ray, double bound, double from) const {
    const double reached = scratch_.reached[ray];
    return bound > reached || (bound == reached && from < static_cast<double>(scratch_.lines.reached_at[ray]));
  }

  static constexpr std::size_t first_looks = 128;

  /// The cell in the middle, up to rounding; those around it follow as far as the part reaches.
  HWY_INLINE void put_look(std::int32_t ray, double from, double to) {
    const RayGroup& group = scratch_.group;
    const double middle = 0.5 * (from + to);
    std::int32_t cell[3];
    for (int a = 0; a < 3; ++a) {
      const double at = group.origin[a][ray] + middle * group.direction[a][ray];
      cell[a] = at > 0 ? (at < field_.leaf_count[a] ? floored(at) : field_.leaf_count[a] - 1) : 0;
    }
    LastLooks& last = scratch_.last_looks[ray];
    const std::size_t kept = last.next++ % LastLooks::kept;
    last.key[kept] = key_of(cell), last.from[kept] = from, last.to[kept] = to;
    put_look(ray, cell, from, to, 0);
  }

  HWY_INLINE static std::uint64_t key_of(const std::int32_t* cell) {
    return static_cast<std::uint64_t>(cell[0]) | static_cast<std::uint64_t>(cell[1]) << 16 |
           static_cast<std::uint64_t>(cell[2]) << 32;
  }

  HWY_INLINE void put_look(std::int32_t ray, const std::int32_t* cell, double from, double to, std::int32_t way) {
    Looks& looks = scratch_.looks_left;
    const std::size_t i = looks.count++;
    for (int a = 0; a < 3; ++a) looks.cell[a][i] = cell[a];
    looks.ray[i] = ray, looks.from[i] = from, looks.to[i] = to, looks.way[i] = way;
  }

  /// The cell beside one on its ray, unless it is looked at anyway, and what follows it as well.
  HWY_INLINE void put_neighbour(std::size_t of, int axis, int step, std::int32_t way) {
    const Looks& looks = scratch_.looks_left;
    std::int32_t cell[3] = {looks.cell[0][of], looks.cell[1][of], looks.cell[2][of]};
    cell[axis] += step;
    if (cell[axis] < 0 || cell[axis] >= field_.leaf_count[axis]) return;
    const LastLooks& last = scratch_.last_looks[looks.ray[of]];
    for (std::size_t i = 0; i < LastLooks::kept; ++i)
      if (last.key[i] == key_of(cell) && (way < 0 ? last.from[i] <= looks.from[of] : last.to[i] >= looks.to[of]))
        return;
    put_look(looks.ray[of], cell, looks.from[of], looks.to[of], way);
  }

  HWY_NOINLINE void look_closely() {
    Looks& looks = scratch_.looks_left;
    std::size_t first = 0;
    while (first < looks.count) {
      // Each look may add two.
      if (looks.count + 2 * double_lanes > Looks::capacity) {
        const std::size_t left = looks.count - first;
        for (std::size_t i = 0; i < left; ++i) {
          looks.ray[i] = looks.ray[first + i], looks.way[i] = looks.way[first + i];
          looks.from[i] = looks.from[first + i], looks.to[i] = looks.to[first + i];
          for (auto& cell : looks.cell) cell[i] = cell[first + i];
        }
        looks.count = left, first = 0;
      }
      const std::size_t count = looks.count - first < double_lanes ? looks.count - first : double_lanes;
      for (std::size_t i = first + count; i < first + double_lanes; ++i) looks.ray[i] = looks.ray[first];
      look_at_cells(first, count);
      first += count;
    }
    looks.count = 0;
  }

  /// Some looks side by side, operation for operation as largest_in_cell<double> (grid_maximum.h).
  HWY_INLINE void look_at_cells(std::size_t first, std::size_t count) {
    const Looks& looks = scratch_.looks_left;
    const RayGroup& group = scratch_.group;
    const VecD zero = hn::Zero(doubles), one = hn::Set(doubles, 1.0);
    scratch_.looks += count;

    HWY_ALIGN double corner[8][8];
    read_corners(first, count, corner);
    // One by one where that is AVX-512: a gather takes longer on some processors (Zen 4).
    const std::int32_t* ray = looks.ray + first;
    const auto of_ray = [ray](const double* n) HWY_ATTR {
#if HWY_TARGET <= HWY_AVX3 && HWY_TARGET != HWY_SCALAR
      return VecD{
          _mm512_set_pd(n[ray[7]], n[ray[6]], n[ray[5]], n[ray[4]], n[ray[3]], n[ray[2]], n[ray[1]], n[ray[0]])};
#else
      constexpr hn::RebindToSigned<Doubles> longs;
      return hn::GatherIndex(doubles, n, hn::PromoteTo(longs, hn::LoadU(half_ints, ray)));
#endif
    };

    // The whole way through the cell.
    VecD low[3], entry[3], exit[3];
    VecD t_in = of_ray(group.t_in), t_out = of_ray(group.t_out);
    for (int a = 0; a < 3; ++a) {
      low[a] = hn::PromoteTo(doubles, hn::LoadU(half_ints, looks.cell[a] + first));
      const VecD high = hn::Add(low[a], one);
      const bool is_down = (group.octant >> a & 1) != 0;
      const VecD plane_origin = of_ray(group.plane_origin[a]), inverse = of_ray(group.inverse[a]);
      entry[a] = hn::Mul(hn::Sub(is_down ? high : low[a], plane_origin), inverse);
      exit[a] = hn::Mul(hn::Sub(is_down ? low[a] : high, plane_origin), inverse);
      t_in = hn::Max(entry[a], t_in), t_out = hn::Min(exit[a], t_out);
    }
    MaskD through_in[3], through_out[3];
    MaskD later = hn::Lt(zero, zero), earlier = later;
    for (int a = 2; a >= 0; --a) {  // the last plane passed at t_in, in the order x, y, z
      const MaskD is_at = hn::Eq(entry[a], t_in);
      through_in[a] = hn::AndNot(later, is_at);
      later = hn::Or(later, is_at);
    }
    for (int a = 0; a < 3; ++a) {  // the first plane passed at t_out
      const MaskD is_at = hn::Eq(exit[a], t_out);
      through_out[a] = hn::AndNot(earlier, is_at);
      earlier = hn::Or(earlier, is_at);
    }

    VecD f[8];
    VecD bound = hn::Load(doubles, corner[0]);
    MaskD has_data = is_finite(bound);
    f[0] = bound;
    for (int c = 1; c < 8; ++c) {
      f[c] = hn::Load(doubles, corner[c]);
      bound = hn::Max(bound, f[c]);
      has_data = hn::And(has_data, is_finite(f[c]));
    }
    const VecD known = of_ray(scratch_.known_value);
    const MaskD improves =
        hn::Or(hn::Gt(bound, known), hn::And(hn::Eq(bound, known), hn::Lt(t_in, of_ray(scratch_.known_t))));
    // Rounding, where planes are passed at nearly the same time, may have named a cell beside the ray.
    const VecD from = hn::LoadU(doubles, looks.from + first), to = hn::LoadU(doubles, looks.to + first);
    const MaskD is_on_ray = hn::And(hn::Lt(t_in, t_out), hn::And(hn::Le(t_in, to), hn::Ge(t_out, from)));
    const MaskD is_first = hn::Eq(hn::PromoteTo(doubles, hn::LoadU(half_ints, looks.way + first)), zero);
    const MaskD is_stray = hn::AndNot(is_on_ray, is_first);
    if (!hn::AllFalse(doubles, is_stray)) walk_strays(first, bits_of(doubles, is_stray) & first_rays(count));

    const MaskD wanted = hn::And(hn::And(has_data, hn::Lt(t_in, t_out)), hn::AndNot(is_stray, improves));
    if (!hn::AllFalse(doubles, wanted)) {
      VecD largest_size = zero;
      for (VecD& value : f) {
        value = hn::Sub(value, bound);
        largest_size = hn::Max(largest_size, hn::Abs(value));
      }
      VecD in[3], out[3];
      for (int a = 0; a < 3; ++a) {
        const VecD o = of_ray(group.origin[a]), d = of_ray(group.direction[a]);
        const VecD near_face = (group.octant >> a & 1) != 0 ? one : zero, far_face = hn::Sub(one, near_face);
        const auto place = [&](VecD t) HWY_ATTR {
          return hn::Min(hn::Max(hn::Sub(hn::Add(o, hn::Mul(t, d)), low[a]), zero), one);
        };
        in[a] = hn::IfThenElse(through_in[a], near_face, place(t_in));
        out[a] = hn::IfThenElse(through_out[a], far_face, place(t_out));
      }
      const Answer answer = largest_on_way(f, in, out);
      const VecD along = hn::Add(hn::Mul(hn::Sub(one, answer.s), t_in), hn::Mul(answer.s, t_out));
      const VecD t = hn::Min(hn::Max(along, t_in), t_out);
      const VecD value = hn::Add(bound, answer.value);
      // Differences that need another unit are left to the scalar kernel's own code.
      const MaskD is_far = hn::And(
          hn::Gt(largest_size, zero),
          hn::Or(hn::Gt(largest_size, hn::Set(doubles, 0x1p900)), hn::Lt(largest_size, hn::Set(doubles, 0x1p-900))));
      const MaskD is_far_and_wanted = hn::And(wanted, is_far);
      if (!hn::AllFalse(doubles, is_far_and_wanted))
        walk_strays(first, bits_of(doubles, is_far_and_wanted) & first_rays(count));
      take_answers(first, count, hn::And(hn::AndNot(is_far, wanted), hn::Ge(value, known)), value, t,
                   hn::And(hn::Eq(value, bound), hn::Eq(t, t_in)));
    }
    follow(first, first_rays(count) & ~bits_of(doubles, is_stray), t_in, t_out, through_in, through_out);
  }

  /// Looks at these as the scalar kernel walks.
  HWY_NOINLINE void walk_strays(std::size_t first, std::uint64_t lanes) {
    const Looks& looks = scratch_.looks_left;
    for (std::uint64_t bits = lanes; bits != 0; bits &= bits - 1) {
      const std::size_t i = first + static_cast<std::size_t>(std::countr_zero(bits));
      const auto ray = static_cast<std::size_t>(looks.ray[i]);
      const std::uint32_t place = scratch_.group.index[ray];
      field_.look_closely(field_.context, state_.rays, place, looks.from[i], looks.to[i], scratch_.found[place]);
      state_.knows(ray, scratch_.found[place]);
    }
  }

  HWY_INLINE void take_answers(std::size_t first, std::size_t count, MaskD wanted, VecD value, VecD t, MaskD at_entry) {
    HWY_ALIGN double values[8], times[8];
    hn::Store(value, doubles, values);
    hn::Store(t, doubles, times);
    const std::uint64_t entry_bits = bits_of(doubles, at_entry);
    const Looks& looks = scratch_.looks_left;
    for (std::uint64_t bits = bits_of(doubles, wanted) & first_rays(count); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      const std::size_t i = first + static_cast<std::size_t>(lane);
      const auto ray = static_cast<std::size_t>(looks.ray[i]);
      FoundMaximum& found = scratch_.found[scratch_.group.index[ray]];
      const auto id = static_cast<std::uint64_t>(
          (static_cast<std::int64_t>(looks.cell[2][i]) * field_.leaf_count[1] + looks.cell[1][i]) *
              field_.leaf_count[0] +
          looks.cell[0][i]);
      const FoundMaximum here{values[lane], times[lane], id, (entry_bits >> lane & 1) != 0};
      if (!is_better(here, found)) continue;
      found = here;
      state_.knows(ray, found);
    }
  }

  /// Goes on to the cells before and behind, as far as the parts of the rays in question reach.
  HWY_INLINE void follow(std::size_t first, std::uint64_t lanes, VecD t_in, VecD t_out, const MaskD* through_in,
                         const MaskD* through_out) {
    const Looks& looks = scratch_.looks_left;
    const VecD ways = hn::PromoteTo(doubles, hn::LoadU(hn::Rebind<std::int32_t, Doubles>(), looks.way + first));
    const VecD zero = hn::Zero(doubles);
    const MaskD before = hn::And(hn::Lt(hn::LoadU(doubles, looks.from + first), t_in), hn::Le(ways, zero));
    const MaskD behind = hn::And(hn::Gt(hn::LoadU(doubles, looks.to + first), t_out), hn::Ge(ways, zero));
    const std::uint64_t before_bits = bits_of(doubles, before) & lanes, behind_bits = bits_of(doubles, behind) & lanes;
    if ((before_bits | behind_bits) == 0) return;
    for (int a = 0; a < 3; ++a) {
      const int step = (scratch_.group.octant >> a & 1) != 0 ? -1 : 1;
      for (std::uint64_t bits = bits_of(doubles, through_in[a]) & before_bits; bits != 0; bits &= bits - 1)
        put_neighbour(first + static_cast<std::size_t>(std::countr_zero(bits)), a, -step, -1);
      for (std::uint64_t bits = bits_of(doubles, through_out[a]) & behind_bits; bits != 0; bits &= bits - 1)
        put_neighbour(first + static_cast<std::size_t>(std::countr_zero(bits)), a, step, 1);
    }
  }

  HWY_INLINE void read_corners(std::size_t first, std::size_t count, double (*corner)[8]) const {
    using formats::ElementType;
    const Looks& looks = scratch_.looks_left;
    switch (field_.type) {
      case ElementType::U8:
        return corners_of<std::uint8_t>(field_.source, looks, first, count, corner);
      case ElementType::I8:
        return corners_of<std::int8_t>(field_.source, looks, first, count, corner);
      case ElementType::U16:
        return corners_of<std::uint16_t>(field_.source, looks, first, count, corner);
      case ElementType::I16:
        return corners_of<std::int16_t>(field_.source, looks, first, count, corner);
      case ElementType::U32:
        return corners_of<std::uint32_t>(field_.source, looks, first, count, corner);
      case ElementType::I32:
        return corners_of<std::int32_t>(field_.source, looks, first, count, corner);
      case ElementType::F32:
        return corners_of<float>(field_.source, looks, first, count, corner);
      default:
        return corners_of<double>(field_.source, looks, first, count, corner);
    }
  }

  SearchState& state_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
