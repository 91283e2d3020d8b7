#include "preprocess/import/reading/zip_archive.h"

#include <minizip/unzip.h>

#include <cstring>
#include <memory>

#include "formats/base/text.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

/// The archive's current file, decompressed; its checksum is verified.
std::string unpacked(unzFile archive, const std::string& name, std::uint64_t size, const std::filesystem::path& path) {
  std::string bytes(size, '\0');
  const auto damaged = [&] { refuse_input(path, name, "damaged data", "a file that can be unpacked"); };
  if (unzOpenCurrentFile(archive) != UNZ_OK) damaged();
  for (std::uint64_t at = 0; at < size;) {
    constexpr std::uint64_t most = 1U << 30;
    const int read = unzReadCurrentFile(archive, bytes.data() + at, static_cast<unsigned>(std::min(size - at, most)));
    if (read <= 0) damaged();
    at += static_cast<std::uint64_t>(read);
  }
  if (unzCloseCurrentFile(archive) != UNZ_OK) damaged();
  return bytes;
}

}  // namespace

void read_zip(const std::filesystem::path& path,
              const std::function<void(const std::string& name, std::string_view bytes)>& take) {
  const std::uint64_t archive_bytes = ForeignFile(path).bytes().size();
  const std::unique_ptr<void, int (*)(unzFile)> archive(unzOpen64(path.c_str()), unzClose);
  if (!archive) refuse_input(path, "end of the file", "no table of contents", "a zip archive");
  int status = unzGoToFirstFile(archive.get());
  for (; status == UNZ_OK; status = unzGoToNextFile(archive.get())) {
    unz_file_info64 info;
    char name[4096];
    if (unzGetCurrentFileInfo64(archive.get(), &info, name, sizeof name, nullptr, 0, nullptr, 0) != UNZ_OK)
      refuse_input(path, "table of contents", "a damaged entry", "a zip archive");
    // minizip fills the array and writes no terminating zero for such a long name
    if (info.size_filename > sizeof name)
      refuse_input(path, "table of contents", concat("a name of ", info.size_filename, " bytes"),
                   concat("at most ", sizeof name));
    const std::string entry(name, ::strnlen(name, info.size_filename));
    if (entry.empty() || entry.back() == '/') continue;
    check_packed_size(path, info.uncompressed_size, archive_bytes);
    take(entry, unpacked(archive.get(), entry, info.uncompressed_size, path));
  }
  if (status != UNZ_END_OF_LIST_OF_FILE) refuse_input(path, "table of contents", "a damaged entry", "a zip archive");
}

}  // namespace rhoray::preprocess
