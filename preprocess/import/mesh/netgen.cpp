// Netgen's neutral mesh files (.vol): lists, each after a keyword.
// Source: Netgen, libsrc/meshing/meshclass.cpp (Mesh::Save), and meshtype.cpp for the order of
// corners.

#include <algorithm>
#include <array>
#include <cctype>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/label_names.h"
#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {
namespace {

/// Index of VTK's node i in a record; Netgen's cells are mirror images of VTK's.
struct VolumeElement {
  std::uint64_t node_count;
  CellKind kind;
  std::array<std::uint8_t, 10> order;
};
constexpr VolumeElement volume_elements[] = {
    {4, CellKind::tetrahedron, {0, 2, 1, 3}},
    {5, CellKind::pyramid, {0, 3, 2, 1, 4}},
    {6, CellKind::wedge, {0, 2, 1, 3, 5, 4}},
    {8, CellKind::hexahedron, {0, 3, 2, 1, 4, 7, 6, 5}},
    // After the corners: midpoints of 0-1, 0-2, 0-3, 1-2, 1-3, 2-3.
    {10, CellKind::quadratic_tetrahedron, {0, 2, 1, 3, 5, 7, 4, 6, 9, 8}},
};

class NetgenReader {
 public:
  explicit NetgenReader(const std::filesystem::path& path)
      : path_(path), file_(path), lines_(file_, WordEnds::at_spaces) {}

  CellMesh read() {
    lines_.need("mesh3d");
    if (lines_.words().front() != "mesh3d") lines_.refuse(lines_.words().front(), "mesh3d");
    while (read_section()) {
    }
    mesh_.cell_fields.push_back(field_of("material", std::move(materials_)));
    mesh_.cell_fields.back().label_names = label_names_from(names_, mesh_.notes);
    take_cells(mesh_, std::move(cells_), path_);
    return std::move(mesh_);
  }

 private:
  /// Reads the list after the next keyword; false after the last one. Unknown lists are lines of
  /// numbers and contain no keywords.
  bool read_section() {
    lines_.need("endmesh");
    const std::string_view word = lines_.words().front();
    if (std::isalpha(static_cast<unsigned char>(word.front())) == 0) {
      ++rest_;
      return true;
    }
    note_rest();
    if (word == "endmesh") return false;
    list_ = word;
    if (word == "dimension") {
      lines_.need("3");
      if (lines_.words().front() != "3") lines_.refuse(lines_.words().front(), "3", ErrorCode::unsupported);
    } else if (word == "points") {
      read_points();
    } else if (word == "volumeelements") {
      read_volume_elements();
    } else if (word.starts_with("surfaceelements")) {
      pass_over("surface elements");
    } else if (word == "curvedelements") {
      mesh_.notes.push_back("section curvedelements left out: cells are taken as straight");
      list_.clear();
    } else if (word == "materials") {
      read_material_names();
    } else {
      list_.clear();
    }
    return true;
  }

  /// Notes the lines after the last record of a known list.
  void note_rest() {
    if (rest_ > 0 && !list_.empty())
      mesh_.notes.push_back(concat("list '", list_, "': ", count_text(rest_, "line", "lines"), " after its records ",
                                   rest_ == 1 ? "was" : "were", " left out"));
    rest_ = 0;
  }

  std::uint64_t count(std::string_view expected) {
    lines_.need(expected);
    return lines_.number<std::uint64_t>(0, expected);
  }

  void pass_over(std::string_view what) {
    const std::uint64_t total = count(concat("a number of ", what));
    for (std::uint64_t i = 0; i < total; ++i) lines_.need(concat(total, " ", what));
    if (total > 0) mesh_.notes.push_back(concat(total, " ", what, " left out: only cells that fill space are kept"));
  }

  void read_points() {
    const std::uint64_t total = count("a number of points");
    for (std::uint64_t i = 0; i < total; ++i) {
      lines_.need(concat(total, " points"));
      mesh_.points.push_back(lines_.point(0));
    }
  }

  void read_volume_elements() {
    const std::uint64_t total = count("a number of volume elements");
    for (std::uint64_t i = 0; i < total; ++i) {
      lines_.need(concat(total, " volume elements"));
      materials_.push_back(lines_.number<double>(0, "a material"));
      const auto node_count = lines_.number<std::uint64_t>(1, "a number of corners");
      const auto* type = std::find_if(std::begin(volume_elements), std::end(volume_elements),
                                      [&](const VolumeElement& row) { return row.node_count == node_count; });
      if (type == std::end(volume_elements))
        lines_.refuse(concat("a volume element with ", node_count, " nodes"), "4, 5, 6, 8 or 10 nodes",
                      ErrorCode::unsupported);
      // counts from 1; a 0 wraps to a huge number and is refused
      for (std::uint64_t k = 0; k < node_count; ++k)
        cells_.nodes.push_back(lines_.number<std::uint64_t>(2 + type->order[k], "a point") - 1);
      cells_.offsets.push_back(cells_.nodes.size());
      cells_.kinds.push_back(static_cast<std::uint8_t>(type->kind));
    }
  }

  void read_material_names() {
    for (std::uint64_t left = count("a number of materials"); left > 0; --left) {
      lines_.need("a material's number and name");
      if (lines_.words().size() < 2) continue;
      names_.emplace_back(lines_.number<int>(0, "a material"), lines_.text_from(1));
    }
  }

  std::filesystem::path path_;
  ForeignFile file_;
  LineReader lines_;
  CellMesh mesh_;
  ForeignCells cells_{.kinds = {}, .offsets = {0}, .nodes = {}};
  Array<double> materials_;
  GivenNames names_;        ///< of materials
  std::string list_;        ///< keyword of the list that was read last; empty for one that is passed over
  std::uint64_t rest_ = 0;  ///< lines since then
};

}  // namespace

CellMesh read_netgen(const std::filesystem::path& path) {
  return NetgenReader(path).read();
}

}  // namespace rhoray::preprocess
