#pragma once

#include <cstdint>
#include <optional>

#include "preprocess/import/mesh/mesh_cells.h"
#include "preprocess/import/xdmf/data_item.h"
#include "preprocess/import/xdmf/xdmf_document.h"

namespace rhoray::preprocess {

/// The cells of a topology without structure, in VTK's node order. Of cells that do not fill space,
/// only the count may be kept. Refuses kinds that are not known here, and counts that do not fit
/// the numbers. Nodes are not checked.
ForeignCells cells_of_topology(const XdmfDocument& document, XdmfData& data, const XmlElement& topology,
                               std::uint64_t point_count);

/// True for a topology whose cells may fill space.
bool may_fill_space(std::string_view topology_word);

/// The numbers of points along x, y and z of a structured topology, which stores them as z, y, x.
/// Refuses other counts than three.
Index3 point_counts_of(const XdmfDocument& document, const XmlElement& topology);

}  // namespace rhoray::preprocess
