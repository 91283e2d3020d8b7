#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "rhoray/array_view.h"
#include "rhoray/dataset.h"
#include "rhoray/progress.h"

/// Packed data as arrays again. Everything is copied.
namespace rhoray::RHORAY_ABI {

/// Samples of a grid, [nz, ny, nx], x fastest.
struct GridCopy {
  std::array<std::int64_t, 3> shape{};  ///< nz, ny, nx
  ElementType type = ElementType::F32;
  std::vector<std::byte> samples{};  ///< NaN where a sparse grid stores none
};

/// A scalar field of a mesh.
struct FieldCopy {
  std::string name{}, unit{};
  bool is_of_cells = false;
  bool is_single_precision = false;  ///< a 32-bit float holds each value exactly
  std::vector<double> values{};      ///< one per point, or per tetrahedron
};

/// A mesh in the order of its source. Tetrahedra that were cut from one cell follow each other.
struct MeshCopy {
  std::vector<std::array<double, 3>> points{};             ///< world axes
  std::vector<std::array<std::uint64_t, 4>> tetrahedra{};  ///< corners in an order of positive volume
  std::vector<FieldCopy> fields{};
};

/// Copies a field of a grid. Empty: that of Dataset::field().
/// Throws ErrorCode::usage for data of another kind and for an unknown field,
/// ErrorCode::interrupted if stopped.
RHORAY_API GridCopy unpack_grid(const Dataset& grid, std::string_view field = {}, const Watch& watch = {});

/// Copies a mesh with all its fields.
/// Throws ErrorCode::usage for data of another kind, ErrorCode::interrupted if stopped.
RHORAY_API MeshCopy unpack_mesh(const Dataset& mesh, const Watch& watch = {});

}  // namespace rhoray::RHORAY_ABI
