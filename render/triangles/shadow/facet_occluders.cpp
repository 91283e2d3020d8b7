#include "render/triangles/shadow/facet_occluders.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "formats/base/stopping.h"
#include "render/query/compiled_for.h"
#include "render/triangles/facet_levels.h"
#include "render/triangles/shadow/front_facing.h"
#include "render/triangles/shadow/occluder_sheets.h"

namespace rhoray::render::wide {

namespace {

constexpr std::uint32_t block_size = FacetBlock::size;

/// A generous upper bound of the error in single precision with which the kernel decides a facet's
/// side.
constexpr double side_margin = 0x1p-16;

/// The paths to a light for rays of one start side.
struct Ways {
  double x, y, z;   ///< one path: from the facets' anchor when the light is at a position
  double off;       ///< how far from it other paths may end, plus rounding
  double of_value;  ///< 1 for a light at a position, else 0
  double sign;      ///< sign of the field's change where such a ray leaves its side
  /// Otherwise no facet ends the side of all rays: it is unknown which rays start before it, and
  /// which behind.
  bool is_direction;
};

/// Determines for each facet of a block, one byte each, whether the field may change through it
/// along rays to the light in the direction that ends the side: rise from below, or fall from
/// above. Also determines whether it certainly does.
RHORAY_INLINE void tell_block(const FacetField* fields, const Ways& ways, std::uint8_t* is_kept,
                              std::uint8_t* is_sure) {
  double x[block_size], y[block_size], z[block_size], value[block_size], doubt[block_size];
  for (std::size_t i = 0; i < block_size; ++i) {
    x[i] = fields[i].gradient[0], y[i] = fields[i].gradient[1], z[i] = fields[i].gradient[2];
    value[i] = fields[i].value, doubt[i] = static_cast<double>(fields[i].doubt);
  }
  for (std::size_t i = 0; i < block_size; ++i) {
    const double steepness = std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
    // Beyond the facet's plane, on which the field is the isovalue, there is a point where it is
    // more or less.
    const double rise = ways.sign * (x[i] * ways.x + y[i] * ways.y + z[i] * ways.z + ways.of_value * value[i]);
    const double of_value = side_margin * value[i],
                 about = steepness * ways.off + (of_value < 0 ? -of_value : of_value);
    const bool is_told = doubt[i] - doubt[i] == 0;  // otherwise the cell is flat
    is_kept[i] = !(is_told & (rise < -about));      // a NaN is kept
    is_sure[i] = is_told & (rise > about) & ways.is_direction;
  }
}

/// The same for all facets, one bit each.
RHORAY_INLINE void tell_all(const FacetField* fields, std::size_t count, const Ways& ways, std::uint16_t* kept,
                            std::uint16_t* sure) {
  std::uint8_t is_kept[block_size], is_sure[block_size];
  const std::size_t whole = count / block_size, left = count % block_size;
  for (std::size_t b = 0; b < whole; ++b) {
    tell_block(fields + b * block_size, ways, is_kept, is_sure);
    kept[b] = bits_of_block(is_kept), sure[b] = bits_of_block(is_sure);
  }
  if (left == 0) return;
  FacetField last[block_size];
  for (std::size_t i = 0; i < block_size; ++i) last[i] = fields[whole * block_size + (i < left ? i : 0)];
  tell_block(last, ways, is_kept, is_sure);
  const unsigned in_block = (1U << left) - 1;
  kept[whole] = static_cast<std::uint16_t>(bits_of_block(is_kept) & in_block);
  sure[whole] = static_cast<std::uint16_t>(bits_of_block(is_sure) & in_block);
}

Ways ways_to(const LightPlace& light, const Vec3& anchor, StartSide side) {
  const Vec3 way = light.is_place ? light.at - anchor : light.at;
  return {.x = way.x,
          .y = way.y,
          .z = way.z,
          .off = light.reach + side_margin * std::sqrt(way.dot(way)),
          .of_value = light.is_place ? 1.0 : 0.0,
          .sign = side == StartSide::outside ? 1.0 : -1.0,
          .is_direction = !light.is_place};
}

class OccludingFacets final : public OccludingSurface {
 public:
  explicit OccludingFacets(std::shared_ptr<const Facets> facets) : facets_(std::move(facets)) {}

  std::shared_ptr<const LightOccluders> of_light(Machine machine, const LightPlace& light,
                                                 Shadows shadows) const override {
    return facet_occluders_of(machine, facets_, light, shadows);
  }
  std::shared_ptr<const LightOccluders> with_shadows(Machine machine, std::shared_ptr<const LightOccluders> before,
                                                     const LightPlace& light) const override {
    return wide::with_shadows(machine, std::move(before), light);
  }

 private:
  std::shared_ptr<const Facets> facets_;
};

}  // namespace

FacetOccluders::FacetOccluders(Machine machine, std::shared_ptr<const Facets> facets, const LightPlace& light,
                               StartSide side, const std::stop_token& stop)
    : facets_(std::move(facets)), side_(side) {
  const std::size_t block_count = (std::size_t{facets_->count()} + block_size - 1) / block_size;
  std::vector<std::uint16_t> kept(block_count), sure(block_count);
  compiled_for<tell_all>(machine)(facets_->fields(), facets_->count(), ways_to(light, facets_->anchor(), side),
                                  kept.data(), sure.data());
  std::size_t count = 0;
  for (const std::uint16_t bits : kept) count += static_cast<std::size_t>(std::popcount(bits));
  const std::size_t kept_blocks = (count + block_size - 1) / block_size;
  sources_.resize(count), sure_.resize(kept_blocks);
  blocks_ = std::make_unique_for_overwrite<FacetBlock[]>(kept_blocks);
  std::size_t place = 0;
  for_each_until_stopped(0, block_count, 1 << 9, stop, [&](std::uint64_t b) {
    std::uint32_t from[block_size], here = 0;
    for (unsigned bits = kept[b]; bits != 0; bits &= bits - 1) {
      const auto f = static_cast<std::uint32_t>(std::countr_zero(bits));
      from[here] = f;
      const std::size_t to = place + here++;
      sources_[to] = static_cast<std::uint32_t>(b * block_size) + f;
      sure_[to / block_size] =
          static_cast<std::uint16_t>(sure_[to / block_size] | (sure[b] >> f & 1U) << to % block_size);
    }
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t a = 0; a < 3; ++a) {
        const float* numbers = facets_->blocks()[b].corner[c][a];
        for (std::uint32_t i = 0; i < here; ++i)
          blocks_[(place + i) / block_size].corner[c][a][(place + i) % block_size] = numbers[from[i]];
      }
    place += here;
  });
  if (const std::size_t left = count % block_size; left != 0)
    for (auto& corner : blocks_[kept_blocks - 1].corner)
      for (auto& numbers : corner) std::fill(numbers + left, numbers + block_size, numbers[left - 1]);
  levels_ = levels_above(blocks_.get(), kept_blocks);
}

OccluderHeights FacetOccluders::heights(Machine machine, const LightPlace& light, Shadows shadows,
                                        const std::stop_token& stop) const {
  end_if_stopped(stop);
  const SeenFromLight from_light(light.at);
  const OccluderHeights::Frame frame{.anchor = facets_->anchor(), .scale = facets_->scale(), .margin = facet_margin};
  const FrontFacing seen(machine, from_light, facet_margin, blocks_.get(), sources_.size());
  const Squares& squares = seen.squares();
  if (shadows == Shadows::unknown || facets_->count() > FacetNeighbours::most_facets)
    return {from_light, frame, squares, heights_of_facets(machine, squares, facet_margin, seen), {}};
  FacetHeights heights = heights_of_sheets(
      machine, squares, facet_margin,
      {.seen = seen, .sources = sources_.data(), .sure = sure_.data(), .rises = side_ == StartSide::outside},
      facets_->neighbours(stop), stop);
  return {from_light, frame, squares, std::move(heights.above), std::move(heights.below)};
}

std::shared_ptr<const LightOccluders> facet_occluders_of(Machine machine, std::shared_ptr<const Facets> facets,
                                                         const LightPlace& light, Shadows shadows) {
  return std::make_shared<const LightOccluders>(
      [machine, facets = std::move(facets), light, shadows](StartSide side, const std::stop_token& stop) {
        Occluders occluders;
        const auto parts = std::make_shared<const FacetOccluders>(machine, facets, light, side, stop);
        if (light.is_one_direction()) occluders.heights = parts->heights(machine, light, shadows, stop);
        occluders.parts = parts;
        return occluders;
      });
}

std::shared_ptr<const LightOccluders> with_shadows(Machine machine, std::shared_ptr<const LightOccluders> before,
                                                   const LightPlace& light) {
  return std::make_shared<const LightOccluders>(
      [machine, before = std::move(before), light](StartSide side, const std::stop_token& stop) {
        Occluders occluders = before->of(side, stop);
        if (light.is_one_direction())
          occluders.heights = facets_of(occluders).heights(machine, light, Shadows::known, stop);
        return occluders;
      });
}

std::shared_ptr<const OccludingSurface> occluding_facets(const LoadedDataset&, const RayQuery&,
                                                         std::shared_ptr<const void> facets, unsigned,
                                                         const std::stop_token&) {
  return std::make_shared<const OccludingFacets>(std::static_pointer_cast<const Facets>(std::move(facets)));
}

}  // namespace rhoray::render::wide
