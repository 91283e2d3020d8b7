#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "formats/base/vector.h"

namespace rhoray::recipes {

/// A file that gets its name only when it is complete; before, and after an error, there is nothing under that name.
class NewFile {
 public:
  /// Refuses a file that exists unless `replace_existing`, and a folder that cannot be written.
  NewFile(std::filesystem::path path, bool replace_existing);
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile();

  void write(std::span<const std::byte> bytes);
  void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
  void commit();

 private:
  void check(bool worked, std::string_view doing) const;

  std::filesystem::path path_;
  std::filesystem::path unfinished_;
  int descriptor_ = -1;
};

/// What stands in the header of a detached NRRD file: samples in x-fastest order, little-endian.
struct NrrdHeader {
  std::string type;         ///< NRRD's name: "int16", "uint8", "float"
  int component_count = 1;  ///< of each sample; 3: colours
  Index3 sample_count;
  Vec3 first_sample;  ///< position of the centre of the first sample
  Vec3 spacing;
  bool in_patient_mm = false;  ///< x to the left, y to the back, z up, in millimetres
  std::string content;         ///< one line of text
};

/// Writes NAME.raw through `write_samples`, then NAME.nhdr beside it. The path must end in .nhdr.
void write_nrrd(const std::filesystem::path& path, bool replace_existing, const NrrdHeader& header,
                const std::function<void(NewFile& raw)>& write_samples);

}  // namespace rhoray::recipes
