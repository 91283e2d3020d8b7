#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "preprocess/import/readers.h"

namespace rhoray::preprocess {

/// Commands that the verbs send to the import worker:
///
///     volume PATH FIELD [NX NY NZ TYPE BIG_ENDIAN SKIPPED_BYTES]
///         sends a neutral volume
///     volume-or-length PATH FIELD [...]
///         the same, with VolumeRequest::length_of_vectors
///     cells PATH TIME
///         sends a cell mesh; TIME may be empty
///     surface PATH SIZES
///         sends a neutral surface; SIZES may be empty
///     write-vtu PATH
///         receives a neutral mesh and sends what it reads again
///     write-stl PACKED FIELD ISOVALUE PATH
///         writes the isosurface of a packed grid; sends the number of triangles
///         (export/counts.h)
inline constexpr const char* import_worker = "rhoray-import-worker";

/// Accepts only `volume`, for pictures.
inline constexpr const char* slices_worker = "rhoray-slices-worker";

std::vector<std::string> volume_arguments(const std::filesystem::path& path, const VolumeRequest& request);
VolumeRequest volume_request(const std::vector<std::string>& arguments);

}  // namespace rhoray::preprocess
