#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/import/readers.h"

namespace rhoray::preprocess {

/// What the verbs say to the import worker, and how it understands them:
///
///     volume PATH FIELD [NX NY NZ TYPE BIG_ENDIAN SKIPPED_BYTES]     hands over a neutral volume
///     volume-or-length PATH FIELD [...]                              the same, with VolumeRequest::length_of_vectors
///     cells PATH TIME                                                hands over a cell mesh; TIME may be empty
///     surface PATH SIZES                                             hands over a neutral surface; SIZES may be empty
///     write-vtu PATH                                                 takes a neutral mesh and hands back what it reads
///     again
///     write-stl PACKED FIELD ISOVALUE PATH                          writes the isosurface of a packed grid; hands over
///                                                                    the number of triangles (export/counts.h)
inline constexpr const char* import_worker = "rhoray-import-worker";

/// Understands `volume` alone, for pictures.
inline constexpr const char* slices_worker = "rhoray-slices-worker";

std::vector<std::string> volume_arguments(const std::filesystem::path& path, const VolumeRequest& request);
VolumeRequest volume_request(const std::vector<std::string>& arguments);

}  // namespace rhoray::preprocess
