#include "render/frame/pixel_rays.h"

#include <limits>

#include "render/query/compiled_for.h"

namespace rhoray::render {

namespace {

/// Destination of block_edge numbers for each axis.
struct Triple {
  double *x, *y, *z;
};

Triple at(LaneArray<double> (&arrays)[3], std::size_t first) {
  return {arrays[0].data() + first, arrays[1].data() + first, arrays[2].data() + first};
}

/// Writes block_edge vectors computed from neighbours in a row.
template <class VectorOf>
RHORAY_INLINE void fill_run(const double* across, const Triple& out, const VectorOf& vector_of) {
  // Computed in local arrays first, so that the compiler sees that no store changes what the next
  // lane reads.
  double x[block_edge], y[block_edge], z[block_edge];
  for (int i = 0; i < block_edge; ++i) {
    const Vec3 v = vector_of(across[i]);
    x[i] = v.x, y[i] = v.y, z[i] = v.z;
  }
  for (int i = 0; i < block_edge; ++i) out.x[i] = x[i];
  for (int i = 0; i < block_edge; ++i) out.y[i] = y[i];
  for (int i = 0; i < block_edge; ++i) out.z[i] = z[i];
}

void fill_all(LaneArray<double> (&arrays)[3], const Vec3& vector) {
  for (int axis = 0; axis < 3; ++axis) std::fill_n(arrays[axis].data(), tile_capacity, vector[axis]);
}

}  // namespace

PixelRays::PixelRays(const CameraRays& camera, const Affine& data_from_world, const PixelLattice& lattice,
                     Machine machine)
    : camera_(camera),
      data_from_world_(data_from_world),
      machine_(machine),
      across_(static_cast<std::size_t>(lattice.columns() + block_edge - 1)),
      down_(static_cast<std::size_t>(lattice.rows())) {
  for (std::size_t i = 0; i < across_.size(); ++i)
    across_[i] = camera.across_of(lattice.x_first + static_cast<int>(i) * lattice.spacing);
  for (std::size_t j = 0; j < down_.size(); ++j)
    down_[j] = camera.down_of(lattice.y_first + static_cast<int>(j) * lattice.spacing);
}

PixelRays::PixelRays(const CameraRays& camera, const Affine& data_from_world, std::span<const double> across,
                     std::span<const double> down)
    : camera_(camera),
      data_from_world_(data_from_world),
      machine_(Machine::scalar),
      across_places_(across),
      down_places_(down) {}

void PixelRays::begin(RayBatch& rays) const {
  std::fill_n(rays.t_min.data(), tile_capacity, 0.0);
  std::fill_n(rays.t_max.data(), tile_capacity, std::numeric_limits<double>::infinity());
  if (camera_.is_orthographic())
    fill_all(rays.direction, data_from_world_.vector(camera_.direction(0, 0)));
  else
    fill_all(rays.origin, data_from_world_.point(camera_.origin(0, 0)));
}

RHORAY_INLINE void PixelRays::fill_inline(const PixelRays& pixels, const Tile& tile, RayBatch& rays) {
  const CameraRays camera = pixels.camera_;
  const Affine data_from_world = pixels.data_from_world_;
  std::size_t count = 0;
  // A run writes block_edge rays; the next run overwrites those beyond its own.
  for_each_run(
      tile, [&](const Run& run) __attribute__((always_inline)) {
        const double* across = pixels.across_.data() + run.x;
        const double down = pixels.down_[static_cast<std::size_t>(run.y)];
        count = run.first + static_cast<std::size_t>(run.count);
        if (camera.is_orthographic())
          fill_run(across, at(rays.origin, run.first),
                   [&](double a) { return data_from_world.point(camera.origin(a, down)); });
        else
          fill_run(across, at(rays.direction, run.first),
                   [&](double a) { return data_from_world.vector(camera.direction(a, down)); });
      });
  rays.count = count;
}

void PixelRays::fill_places(RayBatch& rays) const {
  for (std::size_t r = 0; r < across_places_.size(); ++r) {
    const double across = across_places_[r], down = down_places_[r];
    const Vec3 vector = camera_.is_orthographic() ? data_from_world_.point(camera_.origin(across, down))
                                                  : data_from_world_.vector(camera_.direction(across, down));
    LaneArray<double>(&arrays)[3] = camera_.is_orthographic() ? rays.origin : rays.direction;
    for (int axis = 0; axis < 3; ++axis) arrays[axis][r] = vector[axis];
  }
  rays.count = across_places_.size();
}

void PixelRays::fill(const Tile& tile, RayBatch& rays) const {
  if (!across_places_.empty()) return fill_places(rays);
  compiled_for<fill_inline>(machine_)(*this, tile, rays);
}

}  // namespace rhoray::render
