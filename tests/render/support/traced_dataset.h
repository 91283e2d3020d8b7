#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "render/dataset/loaded_dataset.h"
#include "render/load.h"
#include "render/query/intersectors.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/methods.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// A volume or mesh packed into a folder of its own, loaded again, and queried one ray at a time.
/// Rays are in world coordinates, and so are hits, except for their gradient.
class TracedDataset {
 public:
  explicit TracedDataset(const preprocess::NeutralVolume& volume, const preprocess::PackVolumeOptions& options = {})
      : dataset_(packed(volume, options)) {}
  explicit TracedDataset(const preprocess::NeutralMesh& mesh, const preprocess::PackMeshOptions& options = {})
      : dataset_(packed(mesh, options)) {}

  /// From the bytes of a packed file.
  explicit TracedDataset(const std::string& packed_file, const std::string& field = {})
      : dataset_(loaded(packed_file, field)) {}

  const render::Dataset& dataset() const { return dataset_; }

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
               {.field_range = dataset_.field().range,
                .method = method,
                .use_hierarchy = use_hierarchy,
                .use_last_t = use_last_t});
  }

  render::Ray ray_data(const render::Ray& ray_world) const {
    const Affine data_from_world = dataset_.implementation().world_from_data.inverse();
    return {data_from_world.point(ray_world.origin), data_from_world.vector(ray_world.direction), ray_world.t_min,
            ray_world.t_max};
  }

  render::KernelScratch scratch;

 private:
  render::Dataset packed(const preprocess::NeutralVolume& volume, const preprocess::PackVolumeOptions& options) {
    preprocess::pack_volume(volume, folder_ / "packed.rho", options);
    return render::Dataset::load(folder_ / "packed.rho");
  }
  render::Dataset packed(const preprocess::NeutralMesh& mesh, const preprocess::PackMeshOptions& options) {
    preprocess::pack_mesh(mesh, folder_ / "packed.rho", options);
    return render::Dataset::load(folder_ / "packed.rho");
  }

  render::Dataset loaded(const std::string& packed_file, const std::string& field) {
    write_file(folder_ / "packed.rho", packed_file);
    return render::Dataset::load(folder_ / "packed.rho", field);
  }

  render::Hit ask(render::Kernel render::Intersectors::*kernel, const render::Ray& ray, const render::RayQuery& query) {
    const render::Intersectors kernels =
        render::choose_intersectors(dataset_.implementation(), {.method = query.method});
    scratch.queue.reserve(kernels.queue_entries);
    const render::Ray in_data = ray_data(ray);
    render::Hit hit;
    tests::ask(kernels.*kernel, dataset_.implementation(), query, std::span(&in_data, 1), std::span(&hit, 1), scratch);
    return hit;
  }

  TemporaryFolder folder_;
  render::Dataset dataset_;
};

/// Compares two hits bit by bit.
inline bool same_bits(const render::Hit& a, const render::Hit& b) {
  return a.t == b.t && a.value == b.value && a.cell == b.cell && a.gradient == b.gradient;
}

}  // namespace rhoray::tests
