// Where single precision leaves open what the largest value on a ray is, cells are evaluated
// closely: in double precision, side by side.
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

#include "render/grid/largest/cubic-inl.h"
#include "render/grid/largest/samples-inl.h"
#include "render/grid/largest/state-inl.h"
#include "render/traverse/lanes-inl.h"
#include "render/traverse/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Performs the scalar kernel's operations one by one (largest_in_cell<double> of
/// render/grid/reference/largest.h) on the cells that are left.
class CandidateRefinement {
 public:
  explicit CandidateRefinement(SearchState& state) : state_(state), field_(state.field), scratch_(state.scratch) {}

  /// Opens a box: suspects added from now on are in this box.
  /// @param low_w  where it begins on the major axis
  HWY_INLINE void open_box(double highest, double unit, double low_w) {
    Suspects& suspects = scratch_.suspects;
    if (suspects.boxes == Suspects::most_boxes || suspects.count > Suspects::capacity * 3 / 4) decide();
    const bool replaces = suspects.boxes != 0 && suspects.box[suspects.boxes - 1].first == suspects.count;
    suspects.boxes += !replaces;
    // Exact: a power of two.
    suspects.box[suspects.boxes - 1] = {highest, 1 / unit, low_w, suspects.count};
  }

  /// Evaluates the suspects that what was reached since does not rule out. The last box stays open.
  HWY_NOINLINE void decide() {
    const std::uint64_t start = field_.time_phases ? ticks_now() : 0;
    Suspects& suspects = scratch_.suspects;
    CandidateList& looks = scratch_.looks_left;
    suspects.box[suspects.boxes].first = suspects.count;
    std::size_t count = 0;
    for (std::size_t b = 0; b < suspects.boxes; ++b) {
      const Suspects::Box box = suspects.box[b];
      for (std::size_t i = box.first; i < suspects.box[b + 1].first; ++i) {
        const double bound = box.highest + static_cast<double>(suspects.bound[i]) * box.scale;
        const double from = box.low_w + static_cast<double>(suspects.from[i]);
        looks.ray[count] = suspects.ray[i];
        looks.from[count] = from, looks.to[count] = box.low_w + static_cast<double>(suspects.to[i]);
        count += may_improve(suspects.ray[i], bound, from);  // unpredictable, so without a branch
        if (count < first_looks) continue;
        look_closely(count);
        count = 0;
      }
    }
    look_closely(count);
    if (suspects.boxes > 1) suspects.box[0] = suspects.box[suspects.boxes - 1], suspects.boxes = 1;
    suspects.box[0].first = suspects.count = 0;
    state_.find_lowest_reached();
    if (field_.time_phases) scratch_.ticks += ticks_now() - start;
  }

 private:
  /// False where no value up to `bound`, from this position on, replaces what was reached.
  HWY_INLINE bool may_improve(std::int32_t ray, double bound, double from) const {
    const double reached = scratch_.reached[ray];
    const bool is_larger = bound > reached, is_equal = bound == reached;
    const bool is_nearer = from < static_cast<double>(scratch_.lines.reached_at[ray]);
    return is_larger | (is_equal & is_nearer);
  }

  static constexpr std::size_t first_looks = 128;

  /// Along a way of some length on the major axis, in cells, a ray moves by at most four times as
  /// much on each of the others. So values rise by at most nine times this length times the field's
  /// range. The rest is for rounding.
  static constexpr double most_rise = 10;

  /// Where a ray passes a face clear of its edges, the walk in single precision visits the cell
  /// beyond, too, with a part of its own. This bounds the values in that cell. It leaves out only
  /// what extends from the cell to this side. Over so much, the sum on all axes, values change by
  /// no more than 8 margins of a block. They are taken to be off by 12 (BlockWalk), of which 3 are
  /// for the positions.
  static constexpr double most_beyond = 8 * 0x1p-18;

  /// True where a ray passes a face so far inside that it passes no other plane near there.
  HWY_INLINE MaskD is_clear_of_edges(const FacePassage& face) const {
    const VecD near_edge = hn::Set(doubles, static_cast<double>(state_.clear_of_edges));
    const VecD far_edge = hn::Sub(hn::Set(doubles, 1.0), near_edge);
    if (!state_.is_exact()) return no_lane(doubles);
    const auto is_clear = [&](int a) HWY_ATTR {
      return hn::Or(face.through[a], hn::And(hn::Gt(face.p[a], near_edge), hn::Lt(face.p[a], far_edge)));
    };
    return hn::And(is_clear(0), hn::And(is_clear(1), is_clear(2)));
  }

  /// Numbers of rays side by side.
  HWY_INLINE static VecD of_rays(const double* n, const std::int32_t* ray) {
    // One by one on AVX-512: a gather takes longer on some processors (Zen 4).
#if HWY_TARGET <= HWY_AVX3 && HWY_TARGET != HWY_SCALAR
    return VecD{_mm512_set_pd(n[ray[7]], n[ray[6]], n[ray[5]], n[ray[4]], n[ray[3]], n[ray[2]], n[ray[1]], n[ray[0]])};
#else
    constexpr hn::RebindToSigned<Doubles> longs;
    return hn::GatherIndex(doubles, n, hn::PromoteTo(longs, hn::LoadU(half_ints, ray)));
#endif
  }

  /// Converts positions on the major axis to times, and finds the cells in the middle, up to
  /// rounding. Those around it follow as far as the part reaches.
  HWY_INLINE void find_cells() {
    const SearchedRays& group = scratch_.rays;
    CandidateList& looks = scratch_.looks_left;
    const int w = state_.frustum.major;
    const bool is_mirrored = state_.lattice.is_mirrored(w);
    const VecD end = hn::Set(doubles, state_.lattice.plane(w, 0)), half = hn::Set(doubles, 0.5);
    for (std::size_t i = looks.count; i % double_lanes != 0; ++i) looks.ray[i] = looks.ray[0];
    for (std::size_t i = 0; i < looks.count; i += double_lanes) {
      const std::int32_t* ray = looks.ray + i;
      const VecD plane_origin = of_rays(group.plane_origin[w], ray), inverse = of_rays(group.inverse[w], ray);
      const VecD t_in = of_rays(group.t_in, ray), t_out = of_rays(group.t_out, ray);
      const auto time_at = [&](VecD place) HWY_ATTR {
        const VecD plane = is_mirrored ? hn::Sub(end, place) : place;
        return hn::Min(hn::Max(hn::Mul(hn::Sub(plane, plane_origin), inverse), t_in), t_out);
      };
      const VecD from = time_at(hn::LoadU(doubles, looks.from + i)), to = time_at(hn::LoadU(doubles, looks.to + i));
      hn::StoreU(from, doubles, looks.from + i);
      hn::StoreU(to, doubles, looks.to + i);
      const VecD middle = hn::Mul(half, hn::Add(from, to));
      for (int a = 0; a < 3; ++a) {
        const VecD at = hn::Add(of_rays(group.origin[a], ray), hn::Mul(middle, of_rays(group.direction[a], ray)));
        const VecD last = hn::Set(doubles, static_cast<double>(field_.leaf_count[a] - 1));
        const VecD cell = hn::Min(hn::Max(hn::Floor(at), hn::Zero(doubles)), last);
        hn::StoreU(hn::DemoteTo(half_ints, cell), half_ints, looks.cell[a] + i);
      }
    }
    for (std::size_t i = 0; i < looks.count; ++i) {
      looks.way[i] = 0;
      FinalCandidates& last = scratch_.last_looks[looks.ray[i]];
      const std::size_t kept = last.next++ % FinalCandidates::kept;
      const std::int32_t cell[3] = {looks.cell[0][i], looks.cell[1][i], looks.cell[2][i]};
      last.key[kept] = key_of(cell), last.from[kept] = looks.from[i], last.to[kept] = looks.to[i];
    }
  }

  HWY_INLINE static std::uint64_t key_of(const std::int32_t* cell) {
    return static_cast<std::uint64_t>(cell[0]) | static_cast<std::uint64_t>(cell[1]) << 16 |
           static_cast<std::uint64_t>(cell[2]) << 32;
  }

  HWY_INLINE void put_look(std::int32_t ray, const std::int32_t* cell, double from, double to, std::int32_t way) {
    CandidateList& looks = scratch_.looks_left;
    const std::size_t i = looks.count++;
    for (int a = 0; a < 3; ++a) looks.cell[a][i] = cell[a];
    looks.ray[i] = ray, looks.from[i] = from, looks.to[i] = to, looks.way[i] = way;
  }

  /// Adds the cell next to one on its ray, unless it is evaluated anyway, together with what
  /// follows it.
  HWY_INLINE void put_neighbour(std::size_t of, int axis, int step, std::int32_t way) {
    const CandidateList& looks = scratch_.looks_left;
    std::int32_t cell[3] = {looks.cell[0][of], looks.cell[1][of], looks.cell[2][of]};
    cell[axis] += step;
    if (cell[axis] < 0 || cell[axis] >= field_.leaf_count[axis]) return;
    const FinalCandidates& last = scratch_.last_looks[looks.ray[of]];
    for (std::size_t i = 0; i < FinalCandidates::kept; ++i)
      if (last.key[i] == key_of(cell) && (way < 0 ? last.from[i] <= looks.from[of] : last.to[i] >= looks.to[of]))
        return;
    put_look(looks.ray[of], cell, looks.from[of], looks.to[of], way);
  }

  /// Evaluates the parts of rays in the candidate list, and what follows from them.
  HWY_NOINLINE void look_closely(std::size_t count) {
    CandidateList& looks = scratch_.looks_left;
    looks.count = count;
    find_cells();
    std::size_t first = 0;
    while (first < looks.count) {
      // Each candidate adds at most two, and the added ones add one: there are never more than two
      // for each original one.
      if (looks.count + 2 * first_looks > CandidateList::capacity) {
        const std::size_t left = looks.count - first;
        for (std::size_t i = 0; i < left; ++i) {
          looks.ray[i] = looks.ray[first + i], looks.way[i] = looks.way[first + i];
          looks.from[i] = looks.from[first + i], looks.to[i] = looks.to[first + i];
          for (auto& cell : looks.cell) cell[i] = cell[first + i];
        }
        looks.count = left, first = 0;
      }
      // Read all corners first: values just written one by one are slow to read side by side.
      const std::size_t end = looks.count < first + first_looks ? looks.count : first + first_looks;
      read_corners_of(first, end);
      for (; first < end; first += double_lanes) {
        for (std::size_t i = looks.count; i < first + double_lanes; ++i) looks.ray[i] = looks.ray[first];
        look_at_cells(first, end - first < double_lanes ? end - first : double_lanes);
      }
      first = end;
    }
    looks.count = 0;
  }

  /// Evaluates some candidates side by side, with exactly the operations of largest_in_cell<double>
  /// (render/grid/reference/largest.h).
  HWY_INLINE void look_at_cells(std::size_t first, std::size_t count) {
    const CandidateList& looks = scratch_.looks_left;
    const SearchedRays& group = scratch_.rays;
    const VecD zero = hn::Zero(doubles), one = hn::Set(doubles, 1.0);
    scratch_.looks += count;

    const auto of_ray = [&](const double* n) HWY_ATTR { return of_rays(n, looks.ray + first); };

    // The whole way through the cell.
    VecD low[3], entry[3], exit[3];
    const VecD begin = of_ray(group.t_in), end = of_ray(group.t_out);
    VecD t_in = begin, t_out = end;
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
    MaskD enters_by_face = hn::Lt(zero, zero), leaves_by_face = enters_by_face;
    for (int a = 2; a >= 0; --a) {  // the last plane passed at t_in, in the order x, y, z
      const MaskD is_at = hn::Eq(entry[a], t_in);
      through_in[a] = hn::AndNot(enters_by_face, is_at);
      enters_by_face = hn::Or(enters_by_face, is_at);
    }
    for (int a = 0; a < 3; ++a) {  // the first plane passed at t_out
      const MaskD is_at = hn::Eq(exit[a], t_out);
      through_out[a] = hn::AndNot(leaves_by_face, is_at);
      leaves_by_face = hn::Or(leaves_by_face, is_at);
    }

    VecD f[8];
    VecD bound = corner(0, first);
    MaskD has_data = is_finite(bound);
    f[0] = bound;
    for (int c = 1; c < 8; ++c) {
      f[c] = corner(c, first);
      bound = hn::Max(bound, f[c]);
      has_data = hn::And(has_data, is_finite(f[c]));
    }
    const VecD known = of_ray(scratch_.known_value);
    const MaskD improves =
        hn::Or(hn::Gt(bound, known), hn::And(hn::Eq(bound, known), hn::Lt(t_in, of_ray(scratch_.known_t))));
    // Rounding, where planes are passed at nearly the same time, may have given a cell beside the
    // ray.
    const VecD from = hn::LoadU(doubles, looks.from + first), to = hn::LoadU(doubles, looks.to + first);
    const MaskD is_on_ray = hn::And(hn::Lt(t_in, t_out), hn::And(hn::Le(t_in, to), hn::Ge(t_out, from)));
    const MaskD is_first = hn::Eq(hn::PromoteTo(doubles, hn::LoadU(half_ints, looks.way + first)), zero);
    const MaskD is_stray = hn::AndNot(is_on_ray, is_first);
    if (!hn::AllFalse(doubles, is_stray)) walk_strays(first, bits_of(doubles, is_stray) & first_rays(count));

    const MaskD wanted = hn::And(hn::And(has_data, hn::Lt(t_in, t_out)), hn::AndNot(is_stray, improves));
    // No less than the values where the ray enters and leaves the cell, and what it has certainly
    // reached.
    VecD at_entry = bound, at_exit = bound, best = known;
    MaskD is_clear_in = hn::AndNot(is_first, is_first), is_clear_out = is_clear_in;
    if (!hn::AllFalse(doubles, wanted)) {
      FacePassage in, out;
      for (int a = 0; a < 3; ++a) {
        const VecD o = of_ray(group.origin[a]), d = of_ray(group.direction[a]);
        const bool is_down = (group.octant >> a & 1) != 0;
        const VecD near_face = is_down ? one : zero, far_face = hn::Sub(one, near_face);
        const auto place = [&](VecD t) HWY_ATTR {
          return hn::Min(hn::Max(hn::Sub(hn::Add(o, hn::Mul(t, d)), low[a]), zero), one);
        };
        in.through[a] = through_in[a], in.is_high[a] = is_down;
        out.through[a] = through_out[a], out.is_high[a] = !is_down;
        in.p[a] = hn::IfThenElse(through_in[a], near_face, place(t_in));
        out.p[a] = hn::IfThenElse(through_out[a], far_face, place(t_out));
      }
      is_clear_in = hn::And(enters_by_face, is_clear_of_edges(in));
      is_clear_out = hn::And(leaves_by_face, is_clear_of_edges(out));
      const VecD on_face_in = value_on_face(f, in), on_face_out = value_on_face(f, out);
      VecD largest_size = zero;
      for (VecD& value : f) {
        value = hn::Sub(value, bound);
        largest_size = hn::Max(largest_size, hn::Abs(value));
      }
      const Answer answer = largest_on_way(f, in.p, out.p);
      const VecD value_in = hn::IfThenElse(enters_by_face, on_face_in, hn::Add(bound, answer.first));
      const VecD value_out = hn::IfThenElse(leaves_by_face, on_face_out, hn::Add(bound, answer.last));
      const VecD inside = hn::Add(bound, answer.value);
      VecD s = answer.s;
      VecD value = hn::IfThenElse(hn::Eq(s, zero), value_in, hn::IfThenElse(hn::Eq(s, one), value_out, inside));
      const MaskD is_in = hn::Gt(value_in, value);
      value = hn::IfThenElse(is_in, value_in, value), s = hn::IfThenZeroElse(is_in, s);
      const MaskD is_out = hn::Gt(value_out, value);
      value = hn::IfThenElse(is_out, value_out, value), s = hn::IfThenElse(is_out, one, s);
      const VecD along = hn::Add(hn::Mul(hn::Sub(one, s), t_in), hn::Mul(s, t_out));
      const VecD t = hn::Min(hn::Max(along, t_in), t_out);
      at_entry = hn::IfThenElse(wanted, value_in, bound);
      at_exit = hn::IfThenElse(wanted, value_out, bound);
      best = hn::IfThenElse(wanted, hn::Max(known, value), known);
      // Differences that need another unit are left to the scalar kernel's own code.
      const MaskD is_far = hn::And(
          hn::Gt(largest_size, zero),
          hn::Or(hn::Gt(largest_size, hn::Set(doubles, 0x1p900)), hn::Lt(largest_size, hn::Set(doubles, 0x1p-900))));
      const MaskD is_far_and_wanted = hn::And(wanted, is_far);
      if (!hn::AllFalse(doubles, is_far_and_wanted))
        walk_strays(first, bits_of(doubles, is_far_and_wanted) & first_rays(count));
      const MaskD may_be_better =
          hn::Or(hn::Gt(value, known), hn::And(hn::Eq(value, known), hn::Le(t, of_ray(scratch_.known_t))));
      take_answers(first, count, hn::And(hn::AndNot(is_far, wanted), may_be_better), value, t, t_in);
      // An answer in another unit, or none: nothing is known.
      at_entry = hn::IfThenElse(is_far_and_wanted, best, at_entry);
      at_exit = hn::IfThenElse(is_far_and_wanted, best, at_exit);
    }
    // What extends outside the cell by next to nothing has no values much larger than those at its
    // ends.
    const VecD speed = hn::Abs(of_ray(group.direction[state_.frustum.major]));
    const VecD speeds = hn::Add(speed, hn::Add(hn::Abs(of_ray(group.direction[state_.frustum.minor[0]])),
                                               hn::Abs(of_ray(group.direction[state_.frustum.minor[1]]))));
    const VecD steepest = hn::Set(doubles, field_.range * most_rise), least = hn::Set(doubles, state_.exact_margin);
    const auto goes_on = [&](VecD length, VecD value, MaskD is_clear) HWY_ATTR {
      const VecD on_major = hn::Mul(length, speed), rise = hn::Mul(hn::Add(on_major, least), steepest);
      const MaskD is_low = hn::And(has_data, hn::Lt(hn::Add(value, rise), best));
      const MaskD is_own = hn::And(is_clear, hn::Le(hn::Mul(length, speeds), hn::Set(doubles, most_beyond)));
      return hn::AndNot(hn::Or(is_low, is_own), hn::Gt(length, zero));
    };
    const VecD ways = hn::PromoteTo(doubles, hn::LoadU(half_ints, looks.way + first));
    const MaskD before =
        hn::And(goes_on(hn::Sub(t_in, from), at_entry, hn::And(is_clear_in, hn::Gt(from, begin))), hn::Le(ways, zero));
    const MaskD behind =
        hn::And(goes_on(hn::Sub(to, t_out), at_exit, hn::And(is_clear_out, hn::Lt(to, end))), hn::Ge(ways, zero));
    const std::uint64_t lanes = first_rays(count) & ~bits_of(doubles, is_stray);
    follow(first, bits_of(doubles, before) & lanes, bits_of(doubles, behind) & lanes, through_in, through_out);
  }

  /// Evaluates these candidates by walking like the scalar kernel.
  HWY_NOINLINE void walk_strays(std::size_t first, std::uint64_t lanes) {
    const CandidateList& looks = scratch_.looks_left;
    for (std::uint64_t bits = lanes; bits != 0; bits &= bits - 1) {
      const std::size_t i = first + static_cast<std::size_t>(std::countr_zero(bits));
      const auto ray = static_cast<std::size_t>(looks.ray[i]);
      const std::uint32_t place = scratch_.rays.index[ray];
      field_.look_closely(field_.context, state_.rays, place, looks.from[i], looks.to[i], scratch_.found[place]);
      state_.knows(ray, scratch_.found[place]);
    }
  }

  /// @param wanted  lanes that are, or may be, better than what their rays knew before these
  ///                candidates
  HWY_INLINE void take_answers(std::size_t first, std::size_t count, MaskD wanted, VecD value, VecD t, VecD entered) {
    const CandidateList& looks = scratch_.looks_left;
    const int w = state_.frustum.major;
    const VecD origin = of_rays(scratch_.rays.origin[w], looks.ray + first);
    const VecD speed = hn::Abs(of_rays(scratch_.rays.direction[w], looks.ray + first));
    const VecD from =
        state_.lattice.is_mirrored(w) ? hn::Sub(hn::Set(doubles, state_.lattice.plane(w, 0)), origin) : origin;
    const auto place = hn::DemoteTo(half_floats, hn::MulAdd(t, speed, from));
    HWY_ALIGN double values[8], times[8], times_entered[8];
    HWY_ALIGN float values_below[8], places[8];
    hn::Store(value, doubles, values);
    hn::Store(t, doubles, times);
    hn::Store(entered, doubles, times_entered);
    hn::Store(SearchState::floats_not_above(value), half_floats, values_below);
    hn::Store(
        hn::Add(hn::MulAdd(hn::Abs(place), hn::Set(half_floats, 0x1p-23F), place), hn::Set(half_floats, state_.margin)),
        half_floats, places);
    for (std::uint64_t bits = bits_of(doubles, wanted) & first_rays(count); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      const std::size_t i = first + static_cast<std::size_t>(lane);
      const auto ray = static_cast<std::size_t>(looks.ray[i]);
      FoundMaximum& found = scratch_.found[scratch_.rays.index[ray]];
      const auto id = static_cast<std::uint64_t>(
          (static_cast<std::int64_t>(looks.cell[2][i]) * field_.leaf_count[1] + looks.cell[1][i]) *
              field_.leaf_count[0] +
          looks.cell[0][i]);
      const FoundMaximum here{values[lane], times[lane], times_entered[lane], id};
      if (!is_better(here, found)) continue;
      found = here;
      scratch_.known_value[ray] = here.value, scratch_.known_t[ray] = here.t;
      state_.set_reached(ray, here.value, values_below[lane], places[lane]);
    }
  }

  /// Continues to the cells before and behind.
  HWY_INLINE void follow(std::size_t first, std::uint64_t before, std::uint64_t behind, const MaskD* through_in,
                         const MaskD* through_out) {
    if ((before | behind) == 0) return;
    for (int a = 0; a < 3; ++a) {
      const int step = (scratch_.rays.octant >> a & 1) != 0 ? -1 : 1;
      for (std::uint64_t bits = bits_of(doubles, through_in[a]) & before; bits != 0; bits &= bits - 1)
        put_neighbour(first + static_cast<std::size_t>(std::countr_zero(bits)), a, -step, -1);
      for (std::uint64_t bits = bits_of(doubles, through_out[a]) & behind; bits != 0; bits &= bits - 1)
        put_neighbour(first + static_cast<std::size_t>(std::countr_zero(bits)), a, step, 1);
    }
  }

  HWY_INLINE void read_corners_of(std::size_t first, std::size_t end) const {
    using formats::ElementType;
    const CandidateList& looks = scratch_.looks_left;
    LookCorners& corners = scratch_.corners;
    switch (field_.type) {
      case ElementType::U8:
        return read_corners<std::uint8_t>(field_.source, looks, first, end, corners);
      case ElementType::I8:
        return read_corners<std::int8_t>(field_.source, looks, first, end, corners);
      case ElementType::U16:
        return read_corners<std::uint16_t>(field_.source, looks, first, end, corners);
      case ElementType::I16:
        return read_corners<std::int16_t>(field_.source, looks, first, end, corners);
      case ElementType::U32:
        return read_corners<std::uint32_t>(field_.source, looks, first, end, corners);
      case ElementType::I32:
        return read_corners<std::int32_t>(field_.source, looks, first, end, corners);
      case ElementType::F32:
        return read_corners<float>(field_.source, looks, first, end, corners);
      default:
        return read_corners<double>(field_.source, looks, first, end, corners);
    }
  }

  HWY_INLINE VecD corner(int c, std::size_t first) const {
    if (field_.sample_bytes <= 2)
      return hn::PromoteTo(doubles, hn::LoadU(half_ints, scratch_.corners.small[c] + first));
    return hn::LoadU(doubles, scratch_.corners.other[c] + first);
  }

  SearchState& state_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
