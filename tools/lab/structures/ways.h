#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/base/number_text.h"
#include "preprocess/neutral.h"
#include "render/load.h"
#include "render/mesh_search.h"
#include "tools/lab/structures/rounded_points.h"

namespace rhoray::study {

/// One method by which rays find the cells of a mesh, built and ready.
struct Way {
  std::string name;
  double bytes_per_cell = 0;  ///< without points and field
  double named_per_cell = 0;  ///< number of lists that contain a cell
  /// For packing, or for building alone; nothing where neither was timed.
  std::optional<double> cells_per_cpu_s{};
  /// Finds first crossings of rays in the mesh's frame by the scalar search, TetMethod::edges in
  /// double precision.
  std::function<void(std::span<const render::Ray>, std::span<render::Hit>, render::KernelCounters&)> ask{};
};

/// The source of all ways for one mesh: files packed with each structure, by name.
class MeshForWays {
 public:
  /// Packs the mesh into `folder` and opens the files. Values are rounded to floats.
  MeshForWays(preprocess::NeutralMesh mesh, const std::filesystem::path& folder);
  ~MeshForWays();
  MeshForWays(const MeshForWays&) = delete;
  MeshForWays& operator=(const MeshForWays&) = delete;

  const render::Dataset& dataset() const;  ///< of clusters of 64
  const formats::TetMesh& packed() const;  ///< the same

  /// The packed structures, and two-level grids and octrees.
  std::vector<Way> structures(double isovalue) const;
  /// Clusters and leaf lists with their cells, or the lists' items, in other orders and forms.
  std::vector<Way> orders(double isovalue) const;
  /// Clusters of 64 whose points take fewer bytes; the bytes are those of points.
  struct RoundedWay {
    Way way;
    RoundedShape shape;
  };
  std::vector<RoundedWay> rounded(double isovalue) const;

 private:
  struct File;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace rhoray::study
