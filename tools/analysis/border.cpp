#include "tools/analysis/border.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace rhoray::tools {

namespace {

/// In barycentric coordinates: above the error of hits in single precision.
constexpr double slack = 1e-4;

double volume_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

Vec3 point_of(const formats::TetMesh& mesh, std::uint32_t point) {
  const std::array<double, 3>& p = mesh.points()[point];
  return {p[0], p[1], p[2]};
}

}  // namespace

MeshPlaces::MeshPlaces(formats::TetMesh mesh) : mesh_(std::move(mesh)) {
  for (const auto& p : mesh_.points()) box_.extendBy(Vec3(p[0], p[1], p[2]));
  const std::uint64_t cell_count = mesh_.description().cell_count;
  const double bins = std::clamp(std::cbrt(static_cast<double>(cell_count)), 1.0, 256.0);
  const Vec3 size = box_.size();
  const double longest = std::max({size.x, size.y, size.z});
  for (int a = 0; a < 3; ++a)
    bin_count_[a] = std::max<std::int64_t>(1, static_cast<std::int64_t>(bins * size[a] / longest));
  // Count, sum up, fill.
  offsets_.assign(static_cast<std::size_t>(volume(bin_count_)) + 1, 0);
  for (std::uint64_t c = 0; c < cell_count; ++c) for_each_bin(c, [&](std::size_t bin) { ++offsets_[bin + 1]; });
  std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
  cells_.resize(offsets_.back());
  std::vector<std::uint64_t> next(offsets_.begin(), offsets_.end() - 1);
  for (std::uint64_t c = 0; c < cell_count; ++c)
    for_each_bin(c, [&](std::size_t bin) { cells_[next[bin]++] = static_cast<std::uint32_t>(c); });
}

Index3 MeshPlaces::bin_of(const Vec3& p) const {
  Index3 bin;
  for (int a = 0; a < 3; ++a) {
    const double share = (p[a] - box_.min[a]) / (box_.max[a] - box_.min[a]);
    bin[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(share * static_cast<double>(bin_count_[a])), 0,
                                      bin_count_[a] - 1);
  }
  return bin;
}

/// For the cell's box, slightly enlarged.
template <class Act>
void MeshPlaces::for_each_bin(std::uint64_t cell, Act&& act) const {
  Box3 box;
  for (const std::uint32_t point : mesh_.cell(cell)) box.extendBy(point_of(mesh_, point));
  const Vec3 margin = 2 * slack * box.size();
  const Index3 low = bin_of(box.min - margin), high = bin_of(box.max + margin);
  for (std::int64_t k = low.z; k <= high.z; ++k)
    for (std::int64_t j = low.y; j <= high.y; ++j)
      for (std::int64_t i = low.x; i <= high.x; ++i) act(number({i, j, k}));
}

bool MeshPlaces::holds(const Vec3& p) const {
  for (int a = 0; a < 3; ++a) {
    const double margin = 2 * slack * (box_.max[a] - box_.min[a]);
    if (!(p[a] >= box_.min[a] - margin && p[a] <= box_.max[a] + margin)) return false;
  }
  const std::size_t bin = number(bin_of(p));
  for (std::uint64_t at = offsets_[bin]; at < offsets_[bin + 1]; ++at) {
    std::array<Vec3, 4> corners;
    for (std::size_t v = 0; v < 4; ++v) corners[v] = point_of(mesh_, mesh_.cell(cells_[at])[v]);
    const double whole = volume_of(corners[0], corners[1], corners[2], corners[3]);
    bool is_inside = whole > 0;
    for (std::size_t v = 0; v < 4 && is_inside; ++v) {
      std::array<Vec3, 4> moved = corners;
      moved[v] = p;
      is_inside = volume_of(moved[0], moved[1], moved[2], moved[3]) >= -slack * whole;
    }
    if (is_inside) return true;
  }
  return false;
}

ResampledBorder::ResampledBorder(const render::Dataset& mesh, const render::Dataset& grid)
    : places_(formats::TetMesh(mesh.file())),
      grid_(formats::BrickGrid(grid.file()), grid.field().name),
      world_from_mesh_(render::world_from_ray_frame(mesh)),
      grid_from_world_(render::world_from_ray_frame(grid).inverse()) {}

bool ResampledBorder::separates(const render::Ray& ray_of_mesh, const render::Hit& truth,
                                const render::Hit& said) const {
  if (!said.is_miss() && !places_.holds(ray_of_mesh.at(said.t))) return true;
  if (truth.is_miss()) return false;
  const Vec3 p_grid = grid_from_world_.point(world_from_mesh_.point(ray_of_mesh.at(truth.t)));
  return !grid_.value(grid_.index_from_frame(p_grid));
}

}  // namespace rhoray::tools
