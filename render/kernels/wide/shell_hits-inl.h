// Crossings of clear surfaces as they are found, refined side by side and written down, each at its place in its ray's
// list.
#if defined(RHORAY_WIDE_SHELL_HITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_SHELL_HITS_INL_H
#undef RHORAY_WIDE_SHELL_HITS_INL_H
#else
#define RHORAY_WIDE_SHELL_HITS_INL_H
#endif

#include <bit>
#include <cstdint>

#include <hwy/highway.h>

#include "render/kernels/wide/cell_walk-inl.h"
#include "render/kernels/wide/cubic-inl.h"
#include "render/kernels/wide/lanes-inl.h"
#include "render/kernels/wide/shells_parts.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// What a look into cells has found, but for the piece of the way on which a change lies.
struct FoundIn {
  const Corners& corners;
  const NextCell& next;
  const VecF* in;
  const VecF* out;
  const VecF* block_corner;
  VecI root_count;
  std::size_t ray;  ///< of the first lane
  std::uint8_t surface;
};

/// Keeps changes of side, and makes them crossings, many at a time.
class ShellHits {
 public:
  HWY_INLINE ShellHits(const Shells& shells, const MirroredLattice& lattice, const CrossingArrays* lists,
                       std::size_t first_ray, ShellScratch& scratch)
      : shells_(shells),
        lattice_(lattice),
        lists_(lists),
        first_ray_(first_ray),
        scratch_(scratch),
        found_(scratch.found) {
    found_.count = 0;
  }

  /// @param place  of each, among the crossings of its ray
  HWY_INLINE void keep(const FoundIn& at, MaskF lanes, VecF low, VecF high, VecI place) {
    const std::size_t n = found_.count;
    const auto put = [&](VecF numbers, float* to)
                         HWY_ATTR { hn::StoreU(hn::Compress(numbers, lanes), floats, to + n); };
    const auto lanes_i = hn::RebindMask(ints, lanes);
    const auto put_whole = [&](VecI numbers, std::int32_t* to)
                               HWY_ATTR { hn::StoreU(hn::Compress(numbers, lanes_i), ints, to + n); };
    for (int c = 0; c < 8; ++c) put(at.corners.f[c], found_.corner[c]);
    for (int a = 0; a < 3; ++a) {
      put(at.in[a], found_.in[a]), put(at.out[a], found_.out[a]);
      put(hn::Add(at.block_corner[a], at.next.cell[a]), found_.cell[a]);
    }
    put(at.next.way_in, found_.way_in), put(at.next.way_out, found_.way_out);
    put(low, found_.low), put(high, found_.high);
    put_whole(place, found_.place), put_whole(at.root_count, found_.root_count);
    std::size_t count = n;
    for (std::uint64_t bits = bits_of(floats, lanes); bits != 0; bits &= bits - 1, ++count) {
      const std::size_t ray = at.ray + static_cast<std::size_t>(std::countr_zero(bits));
      found_.ray[count] = static_cast<std::int32_t>(ray);
      found_.t_block[count] = scratch_.ways.t_block[ray];
      found_.surface[count] = at.surface;
    }
    found_.count = count;
    if (count + float_lanes > FoundCrossings::capacity) write();
  }

  /// Refines and writes down all that are kept.
  HWY_NOINLINE void write() {
    for (std::size_t first = 0; first < found_.count; first += 2 * float_lanes) {
      RootSearch a = search_from(first), b = search_from(first + float_lanes);
      refine(a, b);
      write(a, first), write(b, first + float_lanes);
    }
    found_.count = 0;
  }

 private:
  /// Arrays are read beyond what is kept, not beyond their ends; these numbers are not used.
  HWY_INLINE static std::size_t readable(std::size_t first) {
    return first + float_lanes <= FoundCrossings::capacity ? first : FoundCrossings::capacity - float_lanes;
  }
  HWY_INLINE VecF load(const float* from, std::size_t first) const { return hn::LoadU(floats, from + readable(first)); }

  HWY_INLINE Corners corners_at(std::size_t first) const {
    Corners corners;
    for (int c = 0; c < 8; ++c) corners.f[c] = load(found_.corner[c], first);
    return corners;
  }

  HWY_INLINE RootSearch search_from(std::size_t first) const {
    VecF in[3], out[3];
    for (int a = 0; a < 3; ++a) in[a] = load(found_.in[a], first), out[a] = load(found_.out[a], first);
    const MaskF used = hn::FirstN(floats, found_.count > first ? found_.count - first : 0);
    return RootSearch(along(corners_at(first), in, out), hn::IfThenElseZero(used, load(found_.low, first)),
                      hn::IfThenElseZero(used, load(found_.high, first)));
  }

  HWY_INLINE void write(const RootSearch& searched, std::size_t first) {
    if (first >= found_.count) return;
    const Roots& roots = searched.roots();
    VecF p[3], gradient[3];
    const VecF rest = hn::Sub(hn::Set(floats, 1.0f), roots.s);
    for (int a = 0; a < 3; ++a) p[a] = between(load(found_.in[a], first), load(found_.out[a], first), roots.s, rest);
    gradient_at(corners_at(first), p, gradient);
    const VecF way_in = load(found_.way_in, first);
    const VecF way = hn::MulAdd(roots.s, hn::Sub(load(found_.way_out, first), way_in), way_in);
    HWY_ALIGN float ways[float_lanes], gradients[3][float_lanes];
    HWY_ALIGN std::int32_t iterations[float_lanes];
    hn::Store(way, floats, ways);
    for (int a = 0; a < 3; ++a)
      hn::Store(lattice_.is_mirrored(a) ? hn::Neg(gradient[a]) : gradient[a], floats, gradients[a]);
    hn::Store(roots.iterations, ints, iterations);
    const std::size_t count = found_.count - first < float_lanes ? found_.count - first : float_lanes;
    for (std::size_t i = 0; i < count; ++i)
      write_one(first + i, static_cast<double>(ways[i]), {gradients[0][i], gradients[1][i], gradients[2][i]},
                iterations[i]);
  }

  HWY_INLINE void write_one(std::size_t i, double way, const float (&gradient)[3], std::int32_t iterations) {
    const IsosurfaceScratch& ways = scratch_.ways;
    const auto ray = static_cast<std::size_t>(found_.ray[i]);
    const std::size_t r = first_ray_ + ways.group.index[ray];
    const std::uint8_t surface = found_.surface[i];
    const HitArrays& to = lists_[surface].hits[found_.place[i]];
    const double t = found_.t_block[i] + way * ways.t_per_way[ray];
    to.t[r] = t < ways.group.t_out[ray] ? t : ways.group.t_out[ray];
    to.value[r] = shells_.surface[surface].isovalue;
    std::uint64_t cell = 0;
    for (int a = 2; a >= 0; --a) {
      to.gradient[a][r] = static_cast<double>(gradient[a]);
      const auto mirrored = static_cast<std::int64_t>(found_.cell[a][i]);
      const std::int64_t at = lattice_.is_mirrored(a) ? 16 * lattice_.node_count[a] - 1 - mirrored : mirrored;
      cell = cell * static_cast<std::uint64_t>(shells_.surface[0].leaf_count[a]) + static_cast<std::uint64_t>(at);
    }
    to.cell[r] = cell;
    to.root_count[r] = static_cast<std::uint32_t>(found_.root_count[i]);
    to.iteration_count[r] = static_cast<std::uint32_t>(iterations);
  }

  const Shells& shells_;
  const MirroredLattice& lattice_;
  const CrossingArrays* lists_;
  const std::size_t first_ray_;
  ShellScratch& scratch_;
  FoundCrossings& found_;
};

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
