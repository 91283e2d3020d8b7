#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "formats/base/vector.h"
#include "formats/brick_grid.h"
#include "formats/packed_file.h"

namespace rhoray::formats {

/// A triangle mesh, shown as a landmark together with volumes. It need not be closed or
/// consistently oriented.
struct TriangleMeshDescription {
  std::string length_unit;
  ElementType point_type = ElementType::F32;  ///< F32 or F64
  std::uint64_t point_count = 0;
  std::uint64_t triangle_count = 0;
  Box3 bounds;  ///< of all points

  /// True: the triangles are the source's facets, one for one. False: array "triangle_ids" gives
  /// the source facets.
  bool has_source_order = true;

  // Counts of what packing found.
  /// without area; kept, because they close gaps between their neighbours
  std::uint64_t flat_triangle_count = 0;
  std::uint64_t dropped_facet_count = 0;  ///< with a repeated corner or a non-finite coordinate
  std::uint64_t unused_point_count = 0;   ///< in no triangle; dropped
  Provenance provenance;
};

/// A packed surface, checked and ready for reading. Arrays: "points" F32 or F64 [points, 3] in
/// world axes, "triangles" U32 [triangles, 3], optional "triangle_ids" U32 [triangles]. Corners
/// keep the source's order: facets that are counter-clockwise seen from outside stay so.
class TriangleMesh {
 public:
  static constexpr const char* kind = "surface";

  /// Refuses a file of another kind, shapes that differ from the description, a corner not below
  /// point_count, and a point that is not finite. Reads all corners and points once.
  explicit TriangleMesh(PackedFile file, const Watch& watch = {});

  const TriangleMeshDescription& description() const { return description_; }
  const PackedFile& file() const { return file_; }

  std::array<double, 3> point(std::uint64_t position) const {
    if (floats_.empty()) return doubles_[position];
    const std::array<float, 3>& p = floats_[position];
    return {p[0], p[1], p[2]};
  }
  std::span<const std::array<std::uint32_t, 3>> triangles() const { return triangles_; }

  /// Index in the source file of the facet that this triangle is, or was cut from.
  std::uint64_t triangle_id(std::uint64_t triangle) const {
    return triangle_ids_.empty() ? triangle : triangle_ids_[triangle];
  }

 private:
  PackedFile file_;
  TriangleMeshDescription description_;
  std::span<const std::array<float, 3>> floats_;  ///< one of these two is empty
  std::span<const std::array<double, 3>> doubles_;
  std::span<const std::array<std::uint32_t, 3>> triangles_;
  std::span<const std::uint32_t> triangle_ids_;
};

std::vector<ArraySpec> triangle_mesh_arrays(const TriangleMeshDescription& description);
FileDescription describe(const TriangleMeshDescription& description);

/// Reports wrong bounds, a point in no triangle, a repeated corner in a triangle, and decreasing
/// ids.
std::vector<std::string> deep_findings(const TriangleMesh& surface);

}  // namespace rhoray::formats
