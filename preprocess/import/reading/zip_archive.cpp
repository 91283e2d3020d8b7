#include "preprocess/import/reading/zip_archive.h"

#include <minizip/unzip.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include "formats/base/text.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

/// Reads the archive's current file, which it opens at the first byte and closes after the last.
class CurrentFile {
 public:
  CurrentFile(unzFile archive, const std::filesystem::path& path, const std::string& name, std::uint64_t size)
      : archive_(archive), path_(path), name_(name), left_(size) {}
  ~CurrentFile() {
    if (is_open_) unzCloseCurrentFile(archive_);
  }
  CurrentFile(const CurrentFile&) = delete;
  CurrentFile& operator=(const CurrentFile&) = delete;

  void read(std::span<std::byte> bytes) {
    if (bytes.size() > left_)
      refuse_input(path_, name_, concat("the end of the data after ", left_, " bytes"), concat(bytes.size(), " bytes"));
    if (!is_open_ && unzOpenCurrentFile(archive_) != UNZ_OK) refuse_damage();
    is_open_ = true;
    left_ -= bytes.size();
    while (!bytes.empty()) {
      constexpr std::size_t most = std::size_t{1} << 30;
      const int count = unzReadCurrentFile(archive_, bytes.data(), static_cast<unsigned>(std::min(bytes.size(), most)));
      if (count <= 0) refuse_damage();
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    if (left_ > 0) return;
    is_open_ = false;
    if (unzCloseCurrentFile(archive_) != UNZ_OK) refuse_damage();
  }

  void finish() {
    std::array<std::byte, 4096> waste;
    while (left_ > 0) read(std::span(waste).first(std::min<std::uint64_t>(waste.size(), left_)));
  }

 private:
  [[noreturn]] void refuse_damage() const { refuse_input(path_, name_, "damaged data", "a file that can be unpacked"); }

  unzFile archive_;
  const std::filesystem::path& path_;
  const std::string& name_;
  std::uint64_t left_;
  bool is_open_ = false;
};

}  // namespace

void visit_zip(const std::filesystem::path& path, const std::function<void(const ZipEntry& entry)>& visit) {
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
    ZipEntry entry{.name = std::string(name, ::strnlen(name, info.size_filename)), .size = info.uncompressed_size};
    if (entry.name.empty() || entry.name.back() == '/') continue;
    check_packed_size(path, entry.size, archive_bytes);
    CurrentFile file(archive.get(), path, entry.name, entry.size);
    entry.read = [&file](std::span<std::byte> bytes) { file.read(bytes); };
    entry.finish = [&file] { file.finish(); };
    visit(entry);
  }
  if (status != UNZ_END_OF_LIST_OF_FILE) refuse_input(path, "table of contents", "a damaged entry", "a zip archive");
}

void read_zip(const std::filesystem::path& path,
              const std::function<void(const std::string& name, std::string_view bytes)>& take) {
  visit_zip(path, [&](const ZipEntry& entry) {
    std::string bytes(entry.size, '\0');
    entry.read(std::as_writable_bytes(std::span(bytes)));
    take(entry.name, bytes);
  });
}

}  // namespace rhoray::preprocess
