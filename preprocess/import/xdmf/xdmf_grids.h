#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "preprocess/import/xdmf/data_item.h"
#include "preprocess/import/xdmf/xdmf_document.h"

namespace rhoray::preprocess {

/// A Grid with a mesh of its own, and its attributes: also those of other Grids on the same mesh.
struct XdmfGrid {
  const XmlElement* element = nullptr;
  const XmlElement* topology = nullptr;
  const XmlElement* geometry = nullptr;
  std::vector<const XmlElement*> attributes;
};

/// The Grids of one time: one, or the parts of a spatial collection or a tree.
struct XdmfGrids {
  std::vector<XdmfGrid> grids;
  std::vector<std::string> notes;
};

struct XdmfGridRequest {
  std::string time{};             ///< as in ImportMeshOptions
  bool first_by_default = false;  ///< without a time: the first step, not the last
  /// True for the kinds of topology that the reader takes.
  bool (*is_wanted)(std::string_view topology) = nullptr;
};

/// Chooses among the Grids of the first Domain: a wanted one before others, a collection over time
/// before others, else the first. Attributes of the others are added where they have the same mesh;
/// notes tell which Grids are left out. Refuses collections over time inside other Grids.
XdmfGrids select_grids(const XdmfDocument& document, XdmfData& data, const XdmfGridRequest& request);

/// The word for the kind of a topology, in lower case: "tetrahedron".
std::string topology_word(const XmlElement& topology);

/// Numbers at points or in cells.
struct XdmfAttribute {
  std::string name;
  bool in_cells = false;
  bool is_symmetric_tensor = false;  ///< of 6 numbers: xx, xy, xz, yy, yz, zz
  std::string declared;              ///< in lower case: "scalar", "vector"; empty when nothing is
  XdmfNumbers numbers;

  /// Numbers for each of so many points or cells. Refuses a count that is no multiple, and one that
  /// the declared type does not have.
  int component_count(std::uint64_t owners) const;
};

/// The attributes of a grid at points and in cells. Others, those that functions compute, and
/// second ones of the same name are left out with a note.
std::vector<XdmfAttribute> attributes_of(const XdmfDocument& document, XdmfData& data, const XdmfGrid& grid,
                                         std::vector<std::string>& notes);

/// The points of a grid: XYZ, XY (z = 0), X_Y_Z or X_Y.
Array<std::array<double, 3>> points_of(const XdmfDocument& document, XdmfData& data, const XmlElement& geometry);

}  // namespace rhoray::preprocess
