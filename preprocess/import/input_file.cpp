#include "preprocess/input_file.h"

#include <algorithm>

#include "formats/base/error.h"
#include "formats/base/regular_file.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

namespace {

struct Beginning {
  std::size_t at;
  std::string_view bytes, format;
};

using namespace std::string_view_literals;

// Long enough that samples do not begin like this by chance.
constexpr Beginning beginnings[] = {
    {0, "NRRD000"sv, "NRRD"},
    {0, "ObjectType ="sv, "MetaImage"},
    {0, "NDims ="sv, "MetaImage"},
    {344, "n+1\0"sv, "NIfTI"},
    {344, "ni1\0"sv, "NIfTI"},
    {0, "\x93NUMPY"sv, "NumPy"},
    {0, "MATLAB 5.0 MAT-file"sv, "MATLAB"},
    {0, "MATLAB 7.3 MAT-file"sv, "MATLAB"},
    {0, "# vtk DataFile"sv, "VTK"},
    {0, "<?xml"sv, "XML"},
    {0, "<VTKFile"sv, "VTK XML"},
    {0, "<Xdmf"sv, "XDMF"},
    {128, "DICM"sv, "DICOM"},
    {0, "PK\3\4"sv, "zip"},
    {0, "\x1f\x8b\x08"sv, "gzip"},
    {0, "\x89HDF\r\n"sv, "HDF5"},
    {0, "CDF\1"sv, "netCDF"},
    {0, "CDF\2"sv, "netCDF"},
    {0, " BDV\0\0\0\0"sv, "OpenVDB"},
    {0, "\x89PNG"sv, "PNG"},
    {0, "\xff\xd8\xff"sv, "JPEG"},
    {0, "II*\0"sv, "TIFF"},
    {0, "MM\0*"sv, "TIFF"},
};

}  // namespace

std::string_view known_header(const std::filesystem::path& path) {
  const std::string head = first_bytes(path, 348);
  for (const auto& [at, bytes, format] : beginnings)
    if (std::string_view(head).substr(std::min(at, head.size())).starts_with(bytes)) return format;
  return {};
}

void require_input(const std::filesystem::path& path) {
  require_readable(path);
  if (std::filesystem::is_directory(path) && foreign_kind(path) == ForeignKind::unknown)
    throw Error(ErrorCode::unreadable,
                concat(path.string(), ": is a folder; expected a file, or a folder of DICOM images or pictures"));
}

std::string unsupported_type(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension.empty()) return concat(path.string(), ": unknown file type");
  for (const ForeignFormat& format : foreign_formats())
    if (std::find(format.families.begin(), format.families.end(), extension_of(path)) != format.families.end())
      return concat(path.string(), ": the content does not fit the file type \"", extension, "\"");
  return concat(path.string(), ": unsupported file type \"", extension, "\"");
}

std::uintmax_t input_bytes(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return std::filesystem::file_size(path);
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(path))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

}  // namespace rhoray::preprocess
