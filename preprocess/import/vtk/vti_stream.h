#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "preprocess/import/samples.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Reads the wanted array of a VTI file, and only that (vtk_xml_stream.h): no more of it is in
/// memory than the volume itself. Nothing for files that VTK's reader is needed for: several
/// pieces, arrays of texts, and encodings that are not known. What it does take, it reads as VTK's
/// reader does; damage is refused.
/// @param take  volume_of_field, or colors_of_field
std::optional<NeutralVolume> stream_vti(const std::filesystem::path& path, const std::string& field,
                                        TakeField* take = volume_of_field);

}  // namespace rhoray::preprocess
