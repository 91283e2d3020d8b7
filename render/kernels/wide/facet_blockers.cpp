#include "render/kernels/wide/facet_blockers.h"

#include <algorithm>
#include <cmath>

#include "formats/base/parallel.h"

namespace rhoray::render::wide {

namespace {

/// Whether the field may change along a ray to the light in the way that ends the side: rise from below, fall from
/// above. Single precision, by which the kernel tells a facet's side, is off by far less than the margin.
bool may_block(const FacetField& field, const Vec3& anchor, const LightPlace& light, double sign) {
  constexpr double margin = 0x1p-16;
  const Vec3 gradient(field.gradient[0], field.gradient[1], field.gradient[2]);
  const double steepness = std::sqrt(gradient.dot(gradient));
  // Past the facet's plane, on which the field is the isovalue, lies a place where it is more or less.
  const Vec3 way = light.is_place ? light.at - anchor : light.at;
  const double rise = sign * (gradient.dot(way) + (light.is_place ? field.value : 0));
  const double doubt = steepness * (light.reach + margin * std::sqrt(way.dot(way))) + std::abs(margin * field.value);
  // Written so that what is no number counts.
  return !(rise < -doubt) || !std::isfinite(static_cast<double>(field.doubt));
}

}  // namespace

FacetBlockers::FacetBlockers(std::shared_ptr<const Facets> facets, const LightPlace& light, StartSide side,
                             unsigned threads)
    : facets_(std::move(facets)) {
  if (facets_->levels().empty()) return;
  const double sign = side == StartSide::outside ? 1 : -1;
  levels_.push_back(facets_->levels().front());
  std::vector<BoxNode>& nodes = levels_.front();
  constexpr std::uint64_t block_size = FacetBlock::size, nodes_each = 64;
  for_each_range(nodes.size(), nodes_each, threads, [&](std::uint64_t first_node, std::uint64_t end_node) {
    for (std::uint64_t n = first_node; n < end_node; ++n)
      for (std::uint64_t c = 0; c < BoxNode::size; ++c) {
        const std::uint64_t first = (n * BoxNode::size + c) * block_size,
                            end = std::min<std::uint64_t>(first + block_size, facets_->count());
        bool is_kept = false;
        for (std::uint64_t f = first; f < end && !is_kept; ++f)
          is_kept = may_block(facets_->fields()[f], facets_->anchor(), light, sign);
        if (is_kept) continue;
        for (int a = 0; a < 3; ++a) nodes[n].low[a][c] = BoxNode::nowhere, nodes[n].high[a][c] = -BoxNode::nowhere;
      }
  });
  add_upper_levels(levels_);
}

}  // namespace rhoray::render::wide
