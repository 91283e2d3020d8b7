#include "preprocess/import/reading/foreign_names.h"

#include <algorithm>
#include <cctype>

#include "formats/base/regular_file.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

namespace fs = std::filesystem;

bool is_digit(char letter) {
  return letter >= '0' && letter <= '9';
}

/// Compares runs of digits as numbers and everything else character by character.
bool numbered_before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const auto run = [](const std::string& text, std::size_t& at) {
        while (at < text.size() && text[at] == '0') ++at;
        const std::size_t begin = at;
        while (at < text.size() && is_digit(text[at])) ++at;
        return text.substr(begin, at - begin);
      };
      const std::string left = run(a, i), right = run(b, j);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  if ((i < a.size()) != (j < b.size())) return j < b.size();
  return a < b;  // for example 1 and 01
}

bool looks_like_dicom(const fs::path& path) {
  const std::string head = first_bytes(path, 132);
  return head.size() == 132 && head.ends_with("DICM");
}

/// Decides by the first files with a known type: a folder of slices may hold thousands.
std::string family_of_folder(const fs::path& folder) {
  constexpr std::size_t looked_at = 16;
  std::size_t seen = 0;
  for (const fs::path& file : files_in(folder)) {
    if (is_picture_name(file)) return "images/";
    if (looks_like_dicom(file)) return "dicom/";
    if (++seen == looked_at) break;
  }
  return {};
}

/// A .g file is an Exodus file without results (netCDF), or a PLOT3D grid.
std::string family_of_grid(const fs::path& path) {
  const std::string begin = first_bytes(path, 4);
  return begin.starts_with("CDF") || begin == "\x89HDF" ? ".gen" : ".p3d";
}

}  // namespace

std::vector<fs::path> files_in(const fs::path& folder) {
  note_source(folder);
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (const std::string name = entry.path().filename().string(); name[0] != '.' && entry.is_regular_file(ignored))
      names.push_back(name);
  std::sort(names.begin(), names.end(), numbered_before);
  std::vector<fs::path> files;
  for (const std::string& name : names) files.push_back(folder / name);
  return files;
}

bool is_picture_name(const fs::path& path) {
  constexpr std::string_view extensions[] = {".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm"};
  return std::find(std::begin(extensions), std::end(extensions), extension_of(path)) != std::end(extensions);
}

std::string family_of(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return family_of_folder(path);
  const std::string extension = extension_of(path);
  return extension == ".g" && fs::exists(path, ignored) ? family_of_grid(path) : extension;
}

}  // namespace rhoray::preprocess
