#include "tools/rhoray/new_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "formats/base/trouble.h"

namespace rhoray::tools {

namespace {

[[noreturn]] void refuse(const std::filesystem::path& path, std::string_view doing) {
  throw Error(Trouble::resource, concat(path.string(), ": ", doing, " failed (", std::strerror(errno), ")"));
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

}  // namespace

NewFile::NewFile(std::filesystem::path path) : path_(std::move(path)) {
  descriptor_ = ::open(folder_of(path_).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
  if (descriptor_ >= 0) return;
  if (errno != EOPNOTSUPP && errno != EISDIR) refuse(path_, "making a file in its folder");

  // A file system without nameless files: a passing name that is removed again.
  const std::filesystem::path passing = passing_name();
  descriptor_ = ::open(passing.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666);
  if (descriptor_ < 0) refuse(path_, "making a file in its folder");
  passing_ = passing;
}

NewFile::~NewFile() {
  if (!passing_.empty()) ::unlink(passing_.c_str());
  ::close(descriptor_);
}

std::filesystem::path NewFile::open_name() const {
  return concat("/proc/self/fd/", descriptor_);
}

std::filesystem::path NewFile::passing_name() const {
  return folder_of(path_) / concat(".", path_.filename().string(), ".", static_cast<long>(::getpid()));
}

void NewFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) refuse(path_, "writing");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void NewFile::link_as(const std::filesystem::path& name) {
  const std::filesystem::path source = passing_.empty() ? open_name() : passing_;
  if (::linkat(AT_FDCWD, source.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) return;
  if (errno == EEXIST) throw Error(Trouble::usage, concat(name.string(), ": is there already"), "--force replaces it");
  refuse(path_, "naming the file");
}

void NewFile::commit(bool replace_existing) {
  if (::fsync(descriptor_) != 0) refuse(path_, "writing");
  if (!replace_existing) return link_as(path_);

  // A link does not replace, a rename does: it needs a name to start from.
  if (passing_.empty()) {
    const std::filesystem::path passing = passing_name();
    link_as(passing);
    passing_ = passing;
  }
  if (::rename(passing_.c_str(), path_.c_str()) != 0) refuse(path_, "replacing the file");
  passing_.clear();
}

void write_new_file(const std::filesystem::path& path, std::string_view text, bool replace_existing) {
  NewFile file(path);
  file.write(text);
  file.commit(replace_existing);
}

}  // namespace rhoray::tools
