#include "preprocess/import/foreign_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>

#include "formats/format_error.h"

namespace rhoray::preprocess {

ForeignFile::ForeignFile(const std::filesystem::path& path) : path_(path) {
  const auto unreadable = [&](const char* reason) -> Error {
    return {Trouble::unreadable, concat(path.string(), ": cannot be read: ", reason)};
  };
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) throw unreadable(std::strerror(errno));
  struct Closing {
    int descriptor;
    ~Closing() { ::close(descriptor); }
  } closing{descriptor};
  struct stat facts {};
  if (::fstat(descriptor, &facts) != 0) throw unreadable(std::strerror(errno));
  if (S_ISDIR(facts.st_mode)) throw unreadable("it is a folder");
  if (!S_ISREG(facts.st_mode)) throw unreadable("it is not a regular file");
  if (facts.st_size == 0) refuse_input(path, "byte 0", "an empty file", "a header");
  size_ = static_cast<std::size_t>(facts.st_size);
  void* start = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (start == MAP_FAILED) throw unreadable(std::strerror(errno));
  start_ = std::shared_ptr<const void>(start, [size = size_](void* begin) { ::munmap(begin, size); });
}

void refuse_input(const std::filesystem::path& path, std::string_view place, std::string_view found,
                  std::string_view expected, Trouble trouble) {
  formats::refuse(path.string(), place, found, expected, trouble);
}

std::string extension_of(const std::filesystem::path& path) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char letter) { return static_cast<char>(std::tolower(static_cast<unsigned char>(letter))); });
  if (name.ends_with(".nii.gz")) return ".nii.gz";
  return std::filesystem::path(name).extension().string();
}

std::string stem_of(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  return name.substr(0, name.size() - extension_of(path).size());
}

}  // namespace rhoray::preprocess
