#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>

#include "formats/base/text.h"
#include "tests/support/resealed.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// The released mesh with clusters; its last table has `added` more vertices, all equal to the
/// first point.
/// @param added  a multiple of 16, so that no byte of padding changes
inline std::string with_longer_table(const std::filesystem::path& released_files, std::uint64_t added) {
  std::string file = read_file(released_files / "1.2-clustered-tets.rho");
  file = with_header_change(file, R"(\"vertex_count\":24)", concat(R"(\"vertex_count\":)", 24 + added));
  file =
      with_header_change(file, R"("dtype":"U32","shape":[24])", concat(R"("dtype":"U32","shape":[)", 24 + added, "]"));
  Envelope parts = open_envelope(file);
  const std::uint64_t last_end = 24 + added;
  std::memcpy(parts.data.data() + place_of(parts, "cluster.offsets").end - 8, &last_end, 8);
  append_to_array(parts, "cluster.vertices", std::string(4 * added, '\0'));
  return seal_again(parts);
}

}  // namespace rhoray::tests
