#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/base/floating_point.h"
#include "formats/base/parallel.h"
#include "formats/base/text.h"
#include "formats/details/cluster_checks.h"
#include "formats/details/deep_checks.h"
#include "formats/details/range_checks.h"
#include "formats/details/scan.h"
#include "formats/mesh_boundary.h"
#include "formats/tet_mesh.h"

namespace rhoray::formats {
namespace {

using details::scan_piece;

Vec3 to_vec(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}

class MeshCheck {
 public:
  MeshCheck(const TetMesh& mesh, details::Findings& findings) : mesh_(mesh), findings_(findings) {}

  void run() {
    check_cells();
    check_ranks();
    if (!mesh_.has_clusters()) check_lists();
    check_boundary();
    const TetMeshDescription& d = mesh_.description();
    for (std::size_t field = 0; field < d.fields.size(); ++field)
      with_element_type(d.fields[field].type,
                        [&]<class T>(T) { check_field(d.fields[field], mesh_.values<T>(field)); });
    for (std::size_t field = 0; field < d.cell_fields.size(); ++field)
      with_element_type(d.cell_fields[field].type,
                        [&]<class T>(T) { check_field(d.cell_fields[field], mesh_.cell_values<T>(field)); });
  }

 private:
  std::array<Vec3, 4> corners(std::uint64_t cell) const {
    std::array<Vec3, 4> p;
    for (std::size_t v = 0; v < 4; ++v) p[v] = to_vec(mesh_.points()[mesh_.cell(cell)[v]]);
    return p;
  }

  /// True when six times the volume is negative by more than rounding can explain.
  static bool is_flipped(const std::array<Vec3, 4>& p) {
    const Vec3 a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0];
    return a.cross(b).dot(c) < -1e-14 * a.length() * b.length() * c.length();
  }

  void check_cells() {
    for_each_range(mesh_.description().cell_count, scan_piece, 0, [&](std::uint64_t first, std::uint64_t last) {
      for (std::uint64_t cell = first; cell < last; ++cell) check_cell(cell);
    });
    std::vector<bool> used(mesh_.points().size());
    for (std::uint64_t cell = 0; cell < mesh_.description().cell_count; ++cell)
      for (const std::uint32_t point : mesh_.cell(cell)) used[point] = true;
    for (std::size_t point = 0; point < used.size(); ++point)
      if (!used[point]) findings_.add("a point that no cell uses", point, [&] { return concat("point ", point); });
  }

  void check_cell(std::uint64_t cell) {
    const auto name = [&] { return concat("cell ", cell); };
    std::array<std::uint32_t, 4> vertices = mesh_.cell(cell);
    std::sort(vertices.begin(), vertices.end());
    if (std::adjacent_find(vertices.begin(), vertices.end()) != vertices.end())
      findings_.add("a cell with a vertex twice", cell, name);
    const std::array<Vec3, 4> p = corners(cell);
    if (mesh_.description().in_source_order && cell > 0 && mesh_.cell_id(cell) <= mesh_.cell_id(cell - 1))
      findings_.add("cell ids that do not rise", cell, name);
    if (is_flipped(p)) findings_.add("a cell of negative orientation", cell, name);
  }

  void check_ranks() {
    std::vector<bool> taken(mesh_.points().size());
    for (std::size_t point = 0; point < taken.size(); ++point) {
      const std::uint64_t rank = mesh_.point_rank(point);
      if (taken[rank]) findings_.add("a point rank given twice", point, [&] { return concat("point ", point); });
      taken[rank] = true;
    }
  }

  void check_lists() {
    const auto leaf_count = static_cast<std::uint64_t>(volume(mesh_.description().lattice.macro.leaf_count));
    for_each_range(leaf_count, scan_piece, 0, [&](std::uint64_t first, std::uint64_t last) {
      for (std::uint64_t leaf = first; leaf < last; ++leaf) {
        const std::span<const std::uint32_t> list = mesh_.leaf_lists().list(leaf);
        if (std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) != list.end())
          findings_.add("a leaf list that does not rise", leaf, [&] { return concat("leaf ", leaf); });
      }
    });
  }

  void check_boundary() {
    if (mesh_.boundary().empty()) return;
    const FaceNumbers computed = computed_boundary_faces(mesh_);
    const std::span<const std::uint64_t> stored = mesh_.boundary();
    const auto differ = std::mismatch(stored.begin(), stored.end(), computed.begin(), computed.end());
    const auto element = static_cast<std::uint64_t>(differ.first - stored.begin());
    if (element != stored.size() || differ.second != computed.end())
      findings_.add("a wrong face of the boundary", element, [&] { return concat("element ", element); });
  }

  template <class T>
  void check_field(const FieldSummary& summary, std::span<const T> values) {
    details::FieldTally tally(summary);
    for (const T value : values) tally.take(value);
    tally.compare(findings_);
  }

  const TetMesh& mesh_;
  details::Findings& findings_;
};

}  // namespace

std::vector<std::string> deep_findings(const TetMesh& mesh) {
  const DefaultFloatingPoint default_floating_point;
  details::Findings findings;
  MeshCheck(mesh, findings).run();
  if (mesh.has_clusters()) {
    details::check_points(mesh, {}, findings);
    details::check_clusters(mesh, findings);
  }
  details::check_boxes_and_lists(mesh, {}, findings);
  for (std::size_t field = 0; field < mesh.description().fields.size(); ++field)
    details::check_ranges(mesh, field, {}, findings);
  return findings.sentences();
}

}  // namespace rhoray::formats
