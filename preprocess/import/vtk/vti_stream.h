#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "preprocess/import/reading/samples.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Reads only the requested array of a VTI file (vtk_xml_stream.h), with no more of it in memory
/// than the volume itself. Returns nothing for files that need VTK's reader: several pieces, text
/// arrays, and unknown encodings. It reads other files as VTK's reader does, and refuses damage.
/// @param take  volume_of_field, or colors_of_field
std::optional<NeutralVolume> stream_vti(const std::filesystem::path& path, const std::string& field,
                                        TakeField* take = volume_of_field);

}  // namespace rhoray::preprocess
