#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "formats/tet_mesh.h"
#include "preprocess/export/grid_samples.h"

namespace rhoray::preprocess {

/// The facts about a packed file, beside positions and values, that we write into a foreign format.
struct StoredFacts {
  std::string_view extension;  ///< for messages
  bool length_unit = false;
  bool space = false;
  bool fields = true;  ///< false: only positions
  bool several_fields = false;
  bool field_unit = false;
  bool label_names = false;
};

// NIfTI has codes for some units of length, which its writer checks. OpenVDB files have metadata,
// NanoVDB files have none.
inline constexpr StoredFacts vti_facts{.extension = ".vti", .several_fields = true};
inline constexpr StoredFacts vtu_facts{.extension = ".vtu", .several_fields = true};
inline constexpr StoredFacts stl_facts{.extension = ".stl", .fields = false};
inline constexpr StoredFacts npy_facts{.extension = ".npy"};
inline constexpr StoredFacts nii_facts{.extension = ".nii", .length_unit = true, .space = true};
inline constexpr StoredFacts vdb_facts{.extension = ".vdb", .length_unit = true, .field_unit = true};
inline constexpr StoredFacts nvdb_facts{.extension = ".nvdb"};

/// Adds a note on each fact of a grid that is not written.
/// @param field  the selected field as in ExportOptions; a format of several fields writes all
///               fields if it is empty
void note_lost_facts(const OpenedGrid& opened, const std::string& field, const StoredFacts& stored,
                     std::vector<std::string>& notes);

/// As above, of a mesh.
void note_lost_facts(const formats::TetMeshDescription& mesh, const StoredFacts& stored,
                     std::vector<std::string>& notes);

}  // namespace rhoray::preprocess
