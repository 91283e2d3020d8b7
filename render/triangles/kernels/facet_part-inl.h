// The rays of a batch before tracing: their lines, and the part of the surface that they may hit.
#if defined(RHORAY_WIDE_FACET_PART_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_FACET_PART_INL_H
#undef RHORAY_WIDE_FACET_PART_INL_H
#else
#define RHORAY_WIDE_FACET_PART_INL_H
#endif

#include <bit>
#include <cstdint>
#include <optional>
#include <utility>

#include <hwy/highway.h>

#include "render/triangles/kernels/facet_beam-inl.h"
#include "render/triangles/kernels/facet_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

/// Stores per-ray numbers from ray r on.
HWY_INLINE void store_line_numbers(VecD v, float* of_lanes, std::size_t r) {
  store_in_lanes(half_floats, hn::DemoteTo(half_floats, v), of_lanes, r);
}

/// Computes the lines of all rays of a chunk, as if all had this major axis. Those that do not, get
/// no hits.
HWY_INLINE void describe_rays(const FacetSurface& surface, const RayArrays& rays, std::size_t count,
                              const FacetBeam& beam, FacetLines& lines) {
  const VecD scale = hn::Set(doubles, surface.scale);
  const VecD towards = hn::Set(doubles, static_cast<double>(beam.sign));
  const VecD largest = hn::Set(doubles, static_cast<double>(beyond));
  // Clamp numbers that are too large for the facets' frame.
  const auto at_most = [&](VecD v) HWY_ATTR { return hn::Max(hn::Min(v, largest), hn::Neg(largest)); };
  const int minor[2] = {beam.axis_u, beam.axis_v};
  for (std::size_t r = 0; r < count; r += double_lanes) {
    const VecD d = hn::Load(doubles, rays.direction[beam.axis_w] + r);
    const VecD inverse = hn::Div(hn::Set(doubles, 1.0), d);
    const auto start = [&](int axis) HWY_ATTR {
      return hn::Mul(hn::Sub(hn::Load(doubles, rays.origin[axis] + r), hn::Set(doubles, surface.anchor[axis])), scale);
    };
    const VecD w = start(beam.axis_w);
    for (int m = 0; m < 2; ++m) {
      const VecD s = hn::Mul(hn::Load(doubles, rays.direction[minor[m]] + r), inverse);
      store_line_numbers(s, lines.slope[m], r);
      store_line_numbers(hn::Sub(start(minor[m]), hn::Mul(s, w)), lines.shift[m], r);
    }
    const VecD speed = hn::Mul(d, scale);
    const auto depth_at = [&](const double* t) HWY_ATTR {
      return at_most(hn::Mul(towards, hn::MulAdd(hn::Load(doubles, t + r), speed, w)));
    };
    store_line_numbers(depth_at(rays.t_min), lines.begin, r);
    store_line_numbers(depth_at(rays.t_max), lines.end, r);
  }
  if (rays.start_side != nullptr)
    for (std::size_t r = 0; r < count; ++r) lines.start_side[lane_of(r)] = static_cast<float>(rays.start_side[r]);
}

/// Finds the facets that any ray of a batch may hit.
class PartSearch {
 public:
  /// @param chunks  which all have this major axis and direction, with lines computed for it
  HWY_INLINE PartSearch(const FacetSurface& whole, const FacetChunk* chunks, std::size_t chunk_count, int axis,
                        bool down)
      : whole_(whole), chunks_(chunks), chunk_count_(chunk_count), beam_(axis, down) {}

  /// @return  false when there are, or are expected to be, more facets than a part holds
  bool gather(FacetPart& part, float most_expected) {
    part.begin(whole_);
    if (!bound_lines()) return true;
    float at_low[4], at_high[4];
    bound_places(at_low, at_high);
    const float expected = beam_.share_of(whole_, at_low, at_high) * static_cast<float>(whole_.facet_count);
    if (!(expected <= most_expected)) return false;
    beam_.set_lines(at_low, at_high);
    FacetStack stack(whole_);
    while (stack.count != 0) {
      const FacetEntry entry = stack.entries[--stack.count];
      if (level_of(entry) > 0) {
        stack.open(whole_, beam_, entry);
        ++part.node_count;
      } else {
        if (++part.looked_into_count > FacetPart::most_looked_into || !take_from(place_of(entry), part)) return false;
      }
    }
    finish(part);
    return true;
  }

 private:
  /// @return  false when no facet is between the depths at which rays begin and end
  HWY_INLINE bool bound_lines() {
    VecF first = hn::Set(floats, beyond), last = hn::Set(floats, -beyond);
    for_each_vector([&](const FacetLines& lines, std::size_t r, MaskF alive) HWY_ATTR {
      first = hn::Min(first, hn::IfThenElse(alive, hn::Load(floats, lines.begin + r), first));
      last = hn::Max(last, hn::IfThenElse(alive, hn::Load(floats, lines.end + r), last));
    });
    beam_.far = largest_of(last);
    beam_.cut(whole_, least_of(first), beam_.far);
    beam_.far += bound_margin;
    return whole_.facet_count != 0 && beam_.w_from <= beam_.w_to;
  }

  /// @param at_low, at_high  as in FacetBeam::set_lines
  HWY_INLINE void bound_places(float* at_low, float* at_high) const {
    const VecF end_of_box[2] = {hn::Set(floats, beam_.w_from), hn::Set(floats, beam_.w_to)};
    VecF least[2][2], most[2][2];
    for (int e = 0; e < 2; ++e)
      for (int m = 0; m < 2; ++m) least[e][m] = hn::Set(floats, beyond), most[e][m] = hn::Set(floats, -beyond);
    for_each_vector([&](const FacetLines& lines, std::size_t r, MaskF alive) HWY_ATTR {
      for (int m = 0; m < 2; ++m) {
        const VecF slope = hn::Load(floats, lines.slope[m] + r), shift = hn::Load(floats, lines.shift[m] + r);
        for (int e = 0; e < 2; ++e) {
          const VecF place = hn::MulAdd(slope, end_of_box[e], shift);
          least[e][m] = hn::Min(least[e][m], hn::IfThenElse(alive, place, least[e][m]));
          most[e][m] = hn::Max(most[e][m], hn::IfThenElse(alive, place, most[e][m]));
        }
      }
    });
    float* const at[2] = {at_low, at_high};
    for (int e = 0; e < 2; ++e)
      for (int m = 0; m < 2; ++m) {
        at[e][2 * m] = bound_margin - least_of(least[e][m]);
        at[e][2 * m + 1] = bound_margin + largest_of(most[e][m]);
      }
  }

  template <class Act>
  HWY_INLINE void for_each_vector(const Act& act) const {
    for (std::size_t c = 0; c < chunk_count_; ++c) {
      const std::uint64_t alive = lanes_of(chunks_[c].directions.along[beam_.axis_w]);
      for (std::size_t r = 0; r < lanes; r += float_lanes) act(chunks_[c].lines, r, mask_of(floats, alive >> r));
    }
  }

  HWY_INLINE bool take_from(std::uint32_t block_index, FacetPart& part) const {
    const FacetBlock& block = whole_.blocks[block_index];
    const std::uint32_t first = block_index * FacetBlock::size, left = whole_.facet_count - first;
    std::uint64_t met = 0;
    for (std::size_t i = 0; i < FacetBlock::size; i += float_lanes)
      met |= bits_of(floats, meet_facets(block, beam_, i).in) << i;
    if (left < FacetBlock::size) met &= (std::uint64_t{1} << left) - 1;
    if (part.count + static_cast<std::uint32_t>(std::popcount(met)) > FacetPart::capacity) return false;
    std::uint32_t end = part.count;
    for (std::size_t i = 0; i < FacetBlock::size; i += float_lanes) {
      const std::uint64_t here = met >> i & ((std::uint64_t{1} << float_lanes) - 1);
      for (int c = 0; c < 4; ++c)
        for (int a = 0; a < 3; ++a)
          hn::StoreU(hn::Compress(hn::Load(floats, block.corner[c][a] + i), mask_of(floats, here)), floats,
                     part.corner[c][a] + end);
      end += static_cast<std::uint32_t>(std::popcount(here));
    }
    for (; met != 0; met &= met - 1) {
      const std::uint32_t place = first + static_cast<std::uint32_t>(std::countr_zero(met)), to = part.count++;
      part.sources[to] = whole_.sources != nullptr ? whole_.sources[place] : place;
      if (whole_.sure != nullptr && (whole_.sure[block_index] >> place % FacetBlock::size & 1) != 0)
        part.sure[to / FacetBlock::size] |= static_cast<std::uint16_t>(1U << to % FacetBlock::size);
    }
    return true;
  }

  /// Puts the facets found into blocks under one node.
  HWY_INLINE void finish(FacetPart& part) const {
    if (part.count == 0) return;
    for (std::uint32_t f = part.count; f % FacetBlock::size != 0; ++f)
      for (auto& corner : part.corner)
        for (float* numbers : corner) numbers[f] = numbers[part.count - 1];
    const std::uint32_t block_count = (part.count + FacetBlock::size - 1) / FacetBlock::size;
    for (int a = 0; a < 3; ++a) {
      float low = beyond, high = -beyond;
      for (std::uint32_t b = 0; b < FacetNode::size; ++b) {
        VecF least = hn::Set(floats, FacetNode::nowhere), most = hn::Neg(least);
        if (b < block_count)
          for (int c = 0; c < 4; ++c)
            for (std::size_t i = 0; i < FacetBlock::size; i += float_lanes) {
              const VecF place = hn::Load(floats, part.corner[c][a] + b * FacetBlock::size + i);
              hn::Store(place, floats, part.blocks[b].corner[c][a] + i);
              least = hn::Min(least, place), most = hn::Max(most, place);
            }
        part.node.low[a][b] = least_of(least), part.node.high[a][b] = largest_of(most);
        low = part.node.low[a][b] < low ? part.node.low[a][b] : low;
        high = part.node.high[a][b] > high ? part.node.high[a][b] : high;
      }
      part.surface.low[a] = low, part.surface.high[a] = high;
    }
    part.surface.facet_count = part.count;
  }

  const FacetSurface& whole_;
  const FacetChunk* chunks_;
  const std::size_t chunk_count_;
  FacetBeam beam_;
};

/// Returns the major axis and the direction of all rays of a chunk, if they are the same for all.
HWY_INLINE std::optional<std::pair<int, bool>> only_direction(const Directions& of) {
  const std::uint64_t all = of.along[0] | of.along[1] | of.along[2];
  for (int axis = 0; axis < 3; ++axis)
    if (of.along[axis] == all && all != 0)
      for (const bool down : {false, true})
        if ((all & (down ? ~of.down[axis] : of.down[axis])) == 0) return std::pair{axis, down};
  return std::nullopt;
}

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
