#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "render/dataset/volume.h"
#include "render/load.h"
#include "render/query/intersectors.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/methods.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// A volume or mesh packed into a folder of its own, loaded again, and queried one ray at a time.
/// Rays are in world coordinates, and so are hits, except for their gradient.
class TracedVolume {
 public:
  explicit TracedVolume(const preprocess::NeutralVolume& volume, const preprocess::PackVolumeOptions& options = {})
      : volume_(packed(volume, options)) {}
  explicit TracedVolume(const preprocess::NeutralMesh& mesh, const preprocess::PackMeshOptions& options = {})
      : volume_(packed(mesh, options)) {}

  /// From the bytes of a packed file.
  explicit TracedVolume(const std::string& packed_file, const std::string& field = {})
      : volume_(loaded(packed_file, field)) {}

  const render::Volume& volume() const { return volume_; }

  render::Hit first_crossing(const render::Ray& ray, double isovalue, bool use_hierarchy = true) {
    return first_crossing(ray, isovalue, render::Method{}, use_hierarchy);
  }
  render::Hit first_crossing(const render::Ray& ray, double isovalue, const render::Method& method,
                             bool use_hierarchy = true) {
    return ask(&render::Intersectors::first_hit, ray,
               {.isovalue = isovalue, .method = method, .use_hierarchy = use_hierarchy});
  }
  /// The bound given by the last ray's t is kept from call to call, as in a tile.
  render::Hit largest_value(const render::Ray& ray, const render::Method& method = {}, bool use_hierarchy = true,
                            bool use_last_t = true) {
    return ask(&render::Intersectors::largest, ray,
               {.field_range = volume_.field().range,
                .method = method,
                .use_hierarchy = use_hierarchy,
                .use_last_t = use_last_t});
  }

  render::Ray ray_volume(const render::Ray& ray_world) const {
    const Affine volume_from_world = volume_.implementation().world_from_volume.inverse();
    return {volume_from_world.point(ray_world.origin), volume_from_world.vector(ray_world.direction), ray_world.t_min,
            ray_world.t_max};
  }

  render::KernelScratch scratch;

 private:
  render::Volume packed(const preprocess::NeutralVolume& volume, const preprocess::PackVolumeOptions& options) {
    preprocess::pack_volume(volume, folder_ / "packed.rho", options);
    return render::Volume::load(folder_ / "packed.rho");
  }
  render::Volume packed(const preprocess::NeutralMesh& mesh, const preprocess::PackMeshOptions& options) {
    preprocess::pack_mesh(mesh, folder_ / "packed.rho", options);
    return render::Volume::load(folder_ / "packed.rho");
  }

  render::Volume loaded(const std::string& packed_file, const std::string& field) {
    write_file(folder_ / "packed.rho", packed_file);
    return render::Volume::load(folder_ / "packed.rho", field);
  }

  render::Hit ask(render::Kernel render::Intersectors::*kernel, const render::Ray& ray, const render::RayQuery& query) {
    const render::Intersectors kernels =
        render::choose_intersectors(volume_.implementation(), {.method = query.method});
    scratch.queue.reserve(kernels.queue_entries);
    const render::Ray in_volume = ray_volume(ray);
    render::Hit hit;
    tests::ask(kernels.*kernel, volume_.implementation(), query, std::span(&in_volume, 1), std::span(&hit, 1), scratch);
    return hit;
  }

  TemporaryFolder folder_;
  render::Volume volume_;
};

/// Compares two hits bit by bit.
inline bool same_bits(const render::Hit& a, const render::Hit& b) {
  return a.t == b.t && a.value == b.value && a.cell == b.cell && a.gradient == b.gradient;
}

}  // namespace rhoray::tests
