#include "render/kernels/wide/facet_blockers.h"

#include <algorithm>
#include <cmath>

#include "render/kernels/wide/blocker_sheets.h"
#include "render/kernels/wide/facets_parts.h"
#include "render/volumes/facet_levels.h"

namespace rhoray::render::wide {

namespace {

enum class Blocks { never, perhaps, always };

/// Whether the field changes along rays to the light in the way that ends the side: rises from below, falls from above.
/// Single precision, by which the kernel tells a facet's side, is off by far less than the margin.
Blocks how_it_blocks(const FacetField& field, const Vec3& anchor, const LightPlace& light, double sign) {
  constexpr double margin = 0x1p-16;
  const Vec3 gradient(field.gradient[0], field.gradient[1], field.gradient[2]);
  const double steepness = std::sqrt(gradient.dot(gradient));
  // Past the facet's plane, on which the field is the isovalue, lies a place where it is more or less.
  const Vec3 way = light.is_place ? light.at - anchor : light.at;
  const double rise = sign * (gradient.dot(way) + (light.is_place ? field.value : 0));
  const double doubt = steepness * (light.reach + margin * std::sqrt(way.dot(way))) + std::abs(margin * field.value);
  if (!std::isfinite(static_cast<double>(field.doubt))) return Blocks::perhaps;
  if (rise < -doubt) return Blocks::never;
  // From a ray's start, which may be anywhere, to a place: the side at the facet is not that of the whole way.
  return rise > doubt && !light.is_place ? Blocks::always : Blocks::perhaps;  // what is no number: perhaps
}

}  // namespace

FacetBlockers::FacetBlockers(std::shared_ptr<const Facets> facets, const LightPlace& light, StartSide side)
    : facets_(std::move(facets)) {
  constexpr std::uint32_t block_size = FacetBlock::size;
  const double sign = side == StartSide::outside ? 1 : -1;
  for (std::uint32_t f = 0; f < facets_->count(); ++f) {
    const Blocks how = how_it_blocks(facets_->fields()[f], facets_->anchor(), light, sign);
    if (how == Blocks::never) continue;
    const std::size_t place = sources_.size();
    if (place % block_size == 0) blocks_.emplace_back(), sure_.push_back(0);
    sources_.push_back(f);
    const FacetBlock& from = facets_->blocks()[f / block_size];
    for (int c = 0; c < 4; ++c)
      for (int a = 0; a < 3; ++a) blocks_.back().corner[c][a][place % block_size] = from.corner[c][a][f % block_size];
    sure_.back() = static_cast<std::uint16_t>(sure_.back() | (how == Blocks::always) << (place % block_size));
  }
  if (const std::size_t left = sources_.size() % block_size; left != 0)
    for (auto& corner : blocks_.back().corner)
      for (auto& numbers : corner) std::fill(numbers + left, numbers + block_size, numbers[left - 1]);
  levels_ = levels_above(blocks_.data(), blocks_.size());
}

BlockerHeights FacetBlockers::heights(const LightPlace& light) const {
  const SeenFromLight seen(light.at);
  std::vector<Footprint> footprints(sources_.size(), Footprint::of_nothing());
  for (std::size_t f = 0; f < footprints.size(); ++f)
    for (const auto& corner : blocks_[f / FacetBlock::size].corner) {
      const std::size_t place = f % FacetBlock::size;
      const float point[3] = {corner[0][place], corner[1][place], corner[2][place]};
      footprints[f].add(seen, point);
    }
  return BlockerHeights(seen, {.anchor = facets_->anchor(), .scale = facets_->scale(), .margin = facet_margin},
                        footprints);
}

void FacetBlockers::add_shadows(const LightPlace& light, BlockerHeights& heights) const {
  std::vector<FacetCorners> sure;
  sure.reserve(sources_.size());
  for (std::size_t f = 0; f < sources_.size(); ++f) {
    const std::size_t block = f / FacetBlock::size, place = f % FacetBlock::size;
    if ((sure_[block] >> place & 1) == 0) continue;
    FacetCorners& corners = sure.emplace_back();
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t a = 0; a < 3; ++a) corners[c][a] = blocks_[block].corner[c][a][place];
  }
  if (sure.empty()) return;
  heights.add_shadows(heights_below_sheets(SeenFromLight(light.at), heights.squares(), facet_margin, sure));
}

}  // namespace rhoray::render::wide
