#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "preprocess/import/vtk/xml_outline.h"

namespace rhoray::preprocess {

/// The elements that a path selects, in the order of the document. Understands the parts of XPath
/// and XPointer that programs write into XDMF files:
///
///     /Xdmf/Domain/Grid[2]/Geometry              by names and positions, counted from 1
///     //Grid[@Name="mesh"]/*[self::Topology or self::Geometry]
///     xpointer(PATH)
///     element(/1/2/3)                            by positions alone
///
/// Nothing for a path that is not understood, or when more elements must be visited than
/// `visits_left`, which this lowers.
std::optional<std::vector<const XmlElement*>> select_elements(const XmlElement& root, std::string_view path,
                                                              std::uint64_t& visits_left);

}  // namespace rhoray::preprocess
