#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "formats/base/pending_file.h"
#include "formats/base/vector.h"

namespace rhoray::recipes {

/// Header of a detached NRRD file with samples in x-fastest order, little-endian.
struct NrrdHeader {
  std::string type;         ///< NRRD's name: "int16", "uint8", "float"
  int component_count = 1;  ///< per sample; 3: colours
  Index3 sample_count;
  Vec3 first_sample;  ///< position of the centre of the first sample
  Vec3 spacing;
  bool in_patient_mm = false;  ///< x to the left, y to the back, z up, in millimetres
  std::string content;         ///< one line of text
};

/// Writes NAME.raw through `write_samples`, and NAME.nhdr in the same folder; either both appear or
/// neither. The path must end in .nhdr.
void write_nrrd(const std::filesystem::path& path, bool replace_existing, const NrrdHeader& header,
                const std::function<void(PendingFile& raw)>& write_samples);

}  // namespace rhoray::recipes
