#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "preprocess/neutral.h"
#include "render/load.h"
#include "render/mesh_search.h"
#include "tools/lab/structures/rounded_points.h"

namespace rhoray::study {

/// One way in which rays find the cells of a mesh, built and ready.
struct Way {
  std::string name;
  double bytes_per_cell = 0;                ///< beside points and field
  double named_per_cell = 0;                ///< how often a cell stands in its lists
  std::optional<double> cells_per_cpu_s{};  ///< packing, or building alone; nothing where neither was timed
  /// First crossings of rays in the mesh's frame by the scalar search, TetMethod::edges in double precision.
  std::function<void(std::span<const render::Ray>, std::span<render::Hit>, render::KernelCounters&)> ask{};
};

/// What all ways of one mesh are made from: files packed with each structure, by name.
class MeshForWays {
 public:
  /// Packs the mesh into `folder` and opens what was written. Values are rounded to floats.
  MeshForWays(preprocess::NeutralMesh mesh, const std::filesystem::path& folder);
  ~MeshForWays();
  MeshForWays(const MeshForWays&) = delete;
  MeshForWays& operator=(const MeshForWays&) = delete;

  const render::Volume& volume() const;    ///< of clusters of 64
  const formats::TetMesh& packed() const;  ///< the same

  /// The packed structures, and grids of two levels and of levels where they are needed.
  std::vector<Way> structures(double isovalue) const;
  /// Clusters and leaf lists with their cells, or the lists' items, in other orders and forms.
  std::vector<Way> orders(double isovalue) const;
  /// Clusters of 64 whose points take fewer bytes; bytes are those of points.
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
