#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formats/color_grid.h"
#include "formats/triangle_mesh.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"

namespace rhoray::preprocess {

/// Options of packing a file. They have the names of the command line's options, and refusals name
/// them as the command line does: "--brick-edge: ...".
struct PackOptions {
  /// Fields to keep (--field); the first is shown by default. Empty: the first field of a volume;
  /// of a mesh, those of PackMeshOptions::fields.
  std::vector<std::string> fields{};
  std::string time{};       ///< as ImportMeshOptions::time, ImportVolumeOptions::time
  int levels = 3;           ///< of macrocells
  std::int64_t factor = 4;  ///< cells per axis of a macrocell

  // volumes
  std::string raw{};                           ///< as for parse_raw_volume; empty = has a header
  bool color = false;                          ///< keep colours, for use as a texture
  std::optional<Vec3> spacing{}, origin{};     ///< replace the file's
  std::optional<formats::ElementType> type{};  ///< as PackVolumeOptions::type
  std::optional<SampleOrder> layout{};         ///< not given: bricks
  std::optional<std::int64_t> brick_edge{};    ///< not given: 4; sparse and colours 8

  // meshes
  bool cell_data = false;                    ///< as PackMeshOptions::cells_to_points
  std::optional<double> max_error{};         ///< as ImportMeshOptions::max_error
  std::optional<MeshStructure> structure{};  ///< not given: clusters
  std::optional<std::int64_t> cells{};       ///< about this many leaf cells; only for leaf lists
  std::optional<double> leaf_ratio{};        ///< leaf cells per tetrahedron; only for leaf lists

  /// Cap on anonymous memory in this process and in the reading process; 0 = none. Larger data use
  /// nameless files in the output's folder, or that of temporary files. Only one call at a time may
  /// have a cap.
  std::uint64_t memory_limit_bytes = 0;
  std::string command{};  ///< stored in the file
  bool replace_existing = false;
};

/// The options of the command line that say the same as these, beyond what they are by default.
std::vector<std::string> option_words(const PackOptions& options);

struct PackReport {
  std::variant<formats::GridDescription, formats::ColorGridDescription, formats::TetMeshDescription,
               formats::TriangleMeshDescription>
      description;
  std::vector<std::string> notes;   ///< of reading and of packing, one sentence each
  std::vector<SourceFile> sources;  ///< the files that were read or looked for; may hold a file twice
  /// samples; or points, cells (triangles) and fields, as the packed file holds them
  std::uint64_t raw_bytes = 0;
  std::uint64_t file_bytes = 0;
};

/// Checks what can be checked before reading: that the input is there, of a kind that is packed,
/// and that the options belong to that kind.
void check_pack(const std::filesystem::path& input, const PackOptions& options);

/// Reads a volume, colours, a mesh or a surface, and packs it. A mesh that has only cell fields
/// gets these averaged to its points; one without a varying field gets fields of its positions. The
/// file does not depend on the number of threads or on the cap. Refuses what check_pack refuses.
PackReport pack(const std::filesystem::path& input, const formats::Destination& output, const PackOptions& options = {},
                const Progress& progress = {});

}  // namespace rhoray::preprocess
