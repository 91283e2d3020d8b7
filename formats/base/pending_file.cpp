#include "formats/base/pending_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "formats/base/trouble.h"

namespace rhoray {
namespace {

namespace fs = std::filesystem;

constexpr mode_t new_file_mode = 0666;  // less what the user's mask takes away

/// A name for a short time, not used by this process before.
std::string next_temporary_name() {
  static std::atomic<unsigned> counter{0};
  return concat(".rhoray-", ::getpid(), "-", counter++, ".partial");
}

/// The file that a chain of symbolic links leads to, whether it exists or not.
fs::path follow_links(fs::path path) {
  constexpr int longest_chain = 40;  // as the kernel's own limit
  for (int step = 0; step < longest_chain; ++step) {
    std::error_code none;
    if (!fs::is_symlink(fs::symlink_status(path, none))) return path;
    path = path.parent_path() / fs::read_symlink(path, none);
  }
  return path;
}

Trouble trouble_of(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
    case EISDIR:
    case EACCES:
    case EPERM:
    case EROFS:
    case ELOOP:
    case ENAMETOOLONG:
      return Trouble::usage;
    default:
      return Trouble::resource;
  }
}

}  // namespace

PendingFile::PendingFile(const fs::path& target, Options options) : name_(target.string()), options_(options) {
  try {
    open_target(target);
    create();
  } catch (...) {
    release();
    throw;
  }
}

PendingFile::PendingFile(int borrowed_descriptor)
    : name_(concat("descriptor ", borrowed_descriptor)), borrowed_(true), descriptor_(borrowed_descriptor) {
  if (::ftruncate(descriptor_, 0) != 0) fail("empty it", errno);
}

PendingFile::~PendingFile() {
  release();
}

void PendingFile::release() {
  if (!temporary_name_.empty()) ::unlinkat(folder_, temporary_name_.c_str(), 0);
  if (!borrowed_ && descriptor_ >= 0) ::close(descriptor_);
  if (folder_ >= 0) ::close(folder_);
}

void PendingFile::fail(const std::string& act, int error) const {
  throw Error(trouble_of(error), concat(name_, ": cannot ", act, ": ", std::system_category().message(error)));
}

void PendingFile::refuse_existing() const {
  throw Error(Trouble::usage, concat(name_, ": found a file of that name; expected none"),
              "choose another name, or allow it to be replaced (--force)");
}

void PendingFile::open_target(const fs::path& target) {
  const fs::path real = follow_links(target);
  file_name_ = real.filename().string();
  if (file_name_.empty() || file_name_ == "." || file_name_ == "..")
    throw Error(Trouble::usage, concat(name_, ": found a folder; expected the name of a file"));
  const fs::path folder = real.has_parent_path() ? real.parent_path() : fs::path(".");
  folder_name_ = folder;
  folder_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_ < 0) fail(concat("write into the folder ", folder.string()), errno);

  struct stat status {};
  if (::fstatat(folder_, file_name_.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) {
    if (errno != ENOENT) fail("look at it", errno);
    return;
  }
  if (!S_ISREG(status.st_mode))
    throw Error(Trouble::usage, concat(name_, ": found ", S_ISDIR(status.st_mode) ? "a folder" : "a special file",
                                       "; expected a file or nothing"));
  if (!options_.replace_existing) refuse_existing();
}

void PendingFile::create() {
  // An anonymous file is named through /proc; without it, as without O_TMPFILE, a named temporary does.
  if (options_.anonymous && ::access("/proc/self/fd", X_OK) == 0) {
    descriptor_ = ::openat(folder_, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, new_file_mode);
    if (descriptor_ >= 0) return;
    if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL && errno != ENOENT) fail("create it", errno);
  }
  options_.anonymous = false;
  create_named();
}

void PendingFile::create_named() {
  do {
    temporary_name_ = next_temporary_name();
    descriptor_ = ::openat(folder_, temporary_name_.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, new_file_mode);
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ >= 0) return;
  temporary_name_.clear();
  fail("create it", errno);
}

fs::path PendingFile::open_name() const {
  if (!temporary_name_.empty()) return folder_name_ / temporary_name_;
  return concat("/proc/", ::getpid(), "/fd/", descriptor_);
}

void PendingFile::reserve(std::uint64_t bytes) {
  const auto size = static_cast<off_t>(bytes);
  int error = 0;
  do {
    error = ::fallocate(descriptor_, 0, 0, size) == 0 ? 0 : errno;
  } while (error == EINTR);
  // Some file systems cannot promise space; there a full disk is met while writing.
  if (error == EOPNOTSUPP || error == ENOSYS) error = ::ftruncate(descriptor_, size) == 0 ? 0 : errno;
  if (error == 0) return;

  struct statvfs disk {};
  const bool known = ::fstatvfs(descriptor_, &disk) == 0;
  throw Error(trouble_of(error),
              concat(name_, ": cannot reserve ", bytes, " bytes: ", std::system_category().message(error),
                     known ? concat(" (free there: ", disk.f_bavail * disk.f_frsize, " bytes)") : std::string()));
}

void PendingFile::write(std::uint64_t first_byte, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(first_byte));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) fail(concat("write ", bytes.size(), " bytes at byte ", first_byte), put < 0 ? errno : ENOSPC);
    bytes = bytes.subspan(static_cast<std::size_t>(put));
    first_byte += static_cast<std::uint64_t>(put);
  }
}

void PendingFile::publish() {
  if (borrowed_) return;
  // A file that is replaced keeps its permissions: what was private stays private.
  struct stat status {};
  if (::fstatat(folder_, file_name_.c_str(), &status, 0) == 0 && ::fchmod(descriptor_, status.st_mode & 0777) != 0)
    fail("set its permissions", errno);
  if (::fsync(descriptor_) != 0) fail("flush it to disk", errno);
  if (options_.anonymous)
    name_anonymous();
  else
    name_temporary();
  if (::fsync(folder_) != 0 && errno != EINVAL) fail("flush its folder to disk", errno);
}

/// Gives an anonymous file a name in the folder; false when that name is taken.
bool PendingFile::link_to(const std::string& name) const {
  const std::string self = concat("/proc/self/fd/", descriptor_);
  if (::linkat(AT_FDCWD, self.c_str(), folder_, name.c_str(), AT_SYMLINK_FOLLOW) == 0) return true;
  if (errno != EEXIST) fail("give it its name", errno);
  return false;
}

void PendingFile::name_anonymous() {
  if (link_to(file_name_)) return;
  if (!options_.replace_existing) refuse_existing();
  // No call replaces a name by an anonymous file, so the complete file gets a second name for a moment.
  std::string second = next_temporary_name();
  while (!link_to(second)) second = next_temporary_name();
  temporary_name_ = second;
  if (::renameat(folder_, temporary_name_.c_str(), folder_, file_name_.c_str()) != 0) fail("replace it", errno);
  temporary_name_.clear();
}

void PendingFile::name_temporary() {
  const char* from = temporary_name_.c_str();
  const char* to = file_name_.c_str();
  int error = 0;
  if (options_.replace_existing) {
    if (::renameat(folder_, from, folder_, to) != 0) error = errno;
  } else if (::renameat2(folder_, from, folder_, to, RENAME_NOREPLACE) != 0) {
    error = errno;
    // Where renaming cannot promise to replace nothing, linking can.
    if (error == EINVAL || error == ENOSYS) {
      error = ::linkat(folder_, from, folder_, to, 0) == 0 ? 0 : errno;
      if (error == 0) ::unlinkat(folder_, from, 0);
    }
  }
  if (error == EEXIST) refuse_existing();
  if (error != 0) fail("give it its name", error);
  temporary_name_.clear();
}

}  // namespace rhoray
