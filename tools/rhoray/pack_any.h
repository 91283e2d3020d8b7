#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/progress.h"
#include "tools/rhoray/option_values.h"
#include "tools/rhoray/report.h"

namespace rhoray::tools {

/// Options of packing.
struct PackOptions {
  std::filesystem::path input;
  std::vector<std::string> fields;
  std::string structure;  ///< empty = not said
  std::string cells = "auto";
  std::optional<double> leaf_ratio;
  int levels = 3;
  std::int64_t factor = 4;
  std::optional<formats::ElementType> type;
  std::string layout;  ///< empty = not said
  std::optional<std::int64_t> brick_edge;
  std::string raw;
  bool color = false;  ///< colours for a texture
  std::optional<Vec3> spacing, origin;
  bool cell_data = false;
  std::optional<double> max_error;
  std::string time;                      ///< empty = not said
  std::uint64_t memory_limit_bytes = 0;  ///< cap on anonymous memory (preprocess/memory_cap.h); 0 = none
  bool replace_existing = false;
  std::string command;
};

/// What packing did.
struct PackResult {
  std::string kind;  ///< "grid", "colors", "tets" or "surface"
  Json description;
  std::string content;  ///< "72,089,600 samples U16", "51,419 tetrahedra, 8,278 points"
  std::vector<std::string> notes;
  std::uint64_t raw_bytes = 0;  ///< samples; or points, cells (triangles) and fields as the packed file holds them
  std::uint64_t file_bytes = 0;
  std::uint64_t cell_count = 0;
};

/// Checks what can be checked before reading: that the input is there, of a kind that is packed,
/// and that the options belong to that kind.
void check_pack(const PackOptions& options);

/// Reads a volume, a mesh or a surface and packs it. Under a memory cap large arrays lie in the
/// output's folder, without names.
PackResult pack_any(const PackOptions& options, const std::filesystem::path& output,
                    const preprocess::Progress& progress);

}  // namespace rhoray::tools
