#include "formats/base/pending_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <iterator>
#include <mutex>
#include <optional>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/mapped_file.h"
#include "formats/base/write_failure.h"

namespace rhoray {
namespace {

namespace fs = std::filesystem;

constexpr mode_t new_file_mode = 0666;  // minus the bits of the user's umask
constexpr std::string_view temporary_begin = ".rhoray-", temporary_end = ".partial";

/// A temporary name that this process has not used before.
std::string next_temporary_name() {
  static std::atomic<unsigned> counter{0};
  return concat(temporary_begin, ::getpid(), "-", counter++, temporary_end);
}

/// The file at the end of a chain of symbolic links, whether it exists or not.
fs::path follow_links(fs::path path) {
  constexpr int longest_chain = 40;  // same as the kernel's limit
  for (int step = 0; step < longest_chain; ++step) {
    std::error_code none;
    if (!fs::is_symlink(fs::symlink_status(path, none))) return path;
    path = path.parent_path() / fs::read_symlink(path, none);
  }
  return path;
}

std::optional<struct stat> status_in(int folder, const std::string& name) {
  struct stat status {};
  if (::fstatat(folder, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return std::nullopt;
  return status;
}

bool is_same_file(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/// Removes a temporary name whose process has ended: nobody holds the lock.
void remove_if_stale(int folder, const std::string& name) {
  constexpr int flags = O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  int file = ::openat(folder, name.c_str(), O_RDWR | flags);
  // The name may belong to a replaced file that does not allow writing.
  if (file < 0 && errno == EACCES) file = ::openat(folder, name.c_str(), O_RDONLY | flags);
  if (file < 0) return;
  struct stat opened {};
  if (::fstat(file, &opened) == 0 && S_ISREG(opened.st_mode) && ::flock(file, LOCK_EX | LOCK_NB) == 0) {
    const std::optional<struct stat> named = status_in(folder, name);
    if (named && is_same_file(*named, opened)) ::unlinkat(folder, name.c_str(), 0);
  }
  ::close(file);
}

/// Looks for stale temporary names, once per folder and process.
void remove_stale_names(int folder, const fs::path& name_of_folder) {
  static std::mutex guard;
  // the path is part of the key: inode numbers are reused when folders are removed
  static std::set<std::tuple<dev_t, ino_t, fs::path>> seen;
  struct stat status {};
  if (::fstat(folder, &status) != 0) return;
  {
    const std::lock_guard lock(guard);
    if (!seen.insert({status.st_dev, status.st_ino, name_of_folder}).second) return;
  }
  const int again = ::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR* const list = again < 0 ? nullptr : ::fdopendir(again);
  if (list == nullptr) {
    if (again >= 0) ::close(again);
    return;  // a folder may allow writing but not reading
  }
  while (const dirent* const entry = ::readdir(list)) {
    const std::string name = entry->d_name;
    if (name.starts_with(temporary_begin) && name.ends_with(temporary_end)) remove_if_stale(folder, name);
  }
  ::closedir(list);
}

}  // namespace

/// The files of this process that have a temporary name, and the mutex for all naming.
struct PendingFile::Unfinished {
  std::recursive_mutex guard;
  std::set<PendingFile*> files;

  static Unfinished& all() {
    // never destroyed: an interrupt may come while the process ends
    static Unfinished* const all = new Unfinished;
    return *all;
  }
};

PendingFile::PendingFile(const fs::path& target, Options options) : name_(target.string()), options_(options) {
  try {
    open_target(target);
    remove_stale_names(folder_, folder_name_);
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
  withdraw();
  remove_temporary();
  if (!borrowed_ && descriptor_ >= 0) ::close(descriptor_);
  if (folder_ >= 0) ::close(folder_);
  if (old_ >= 0) ::close(old_);
}

void PendingFile::remove_temporary() {
  const std::lock_guard lock(Unfinished::all().guard);
  // An error here is ignored: the next run removes a leftover file.
  if (!temporary_name_.empty()) ::unlinkat(folder_, temporary_name_.c_str(), 0);
  temporary_name_.clear();
  Unfinished::all().files.erase(this);
}

void PendingFile::fail(const std::string& act, int error, std::uint64_t needed_bytes) const {
  throw write_failure(name_, act, error, descriptor_ >= 0 ? descriptor_ : folder_, needed_bytes);
}

void PendingFile::refuse_existing() const {
  throw Error(ErrorCode::usage, concat(name_, " already exists"),
              "use --force to overwrite it, or choose another name");
}

void PendingFile::open_target(const fs::path& target) {
  const fs::path real = follow_links(target);
  file_name_ = real.filename().string();
  if (file_name_.empty() || file_name_ == "." || file_name_ == "..")
    throw Error(ErrorCode::usage, concat(name_, ": found a folder; expected the name of a file"));
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
    throw Error(ErrorCode::usage, concat(name_, ": found ", S_ISDIR(status.st_mode) ? "a folder" : "a special file",
                                         "; expected a file or nothing"));
  if (!options_.replace_existing) refuse_existing();
}

void PendingFile::create() {
  // An anonymous file is named through /proc. Without /proc or O_TMPFILE, use a named temporary
  // file.
  if (options_.anonymous && ::access("/proc/self/fd", X_OK) == 0) {
    descriptor_ = ::openat(folder_, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, new_file_mode);
    if (descriptor_ >= 0) {
      // for the short time in which it has a temporary name
      ::flock(descriptor_, LOCK_EX | LOCK_NB);
      return;
    }
    if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL && errno != ENOENT) fail("create it", errno);
  }
  options_.anonymous = false;
  create_named();
}

void PendingFile::create_named() {
  Unfinished& all = Unfinished::all();
  const std::lock_guard lock(all.guard);
  all.files.insert(this);  // before the name exists: this may run out of memory
  for (;;) {
    std::string name = next_temporary_name();
    descriptor_ = ::openat(folder_, name.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, new_file_mode);
    if (descriptor_ < 0 && errno == EEXIST) continue;
    if (descriptor_ < 0) fail("create it", errno);
    temporary_name_ = std::move(name);
    // Another process may have considered it stale before it was locked.
    ::flock(descriptor_, LOCK_EX);
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0 || status.st_nlink > 0) break;
    ::close(descriptor_);
  }
  keep_permissions();  // other users can see this name: a private file is private from the start
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
  // Some file systems cannot reserve space; there a full disk is noticed while writing.
  if (error == EOPNOTSUPP || error == ENOSYS) error = ::ftruncate(descriptor_, size) == 0 ? 0 : errno;
  if (error != 0) fail(concat("reserve ", bytes, " bytes"), error, bytes);
}

void PendingFile::write(std::uint64_t first_byte, std::span<const std::byte> bytes) {
  const std::uint64_t end = first_byte + bytes.size();
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(first_byte));
    if (put < 0 && errno == EINTR) continue;
    // If an input being copied has lost bytes, the system call reports EFAULT instead of a signal.
    if (put < 0 && errno == EFAULT && replace_lost_bytes(bytes.data())) require_no_lost_bytes();
    if (put <= 0) fail(concat("write ", bytes.size(), " bytes at byte ", first_byte), put < 0 ? errno : ENOSPC, end);
    bytes = bytes.subspan(static_cast<std::size_t>(put));
    first_byte += static_cast<std::uint64_t>(put);
  }
}

void PendingFile::append(std::span<const std::byte> bytes) {
  write(appended_bytes_, bytes);
  appended_bytes_ += bytes.size();
}

void PendingFile::publish() {
  PendingFile* const self = this;
  publish_each({&self, 1});
}

void publish_all(std::span<const std::unique_ptr<PendingFile>> files) {
  std::vector<PendingFile*> all;
  for (const auto& file : files) all.push_back(file.get());
  PendingFile::publish_each(all);
}

void PendingFile::publish_each(std::span<PendingFile* const> files) {
  require_no_lost_bytes();
  std::vector<PendingFile*> own;
  std::copy_if(files.begin(), files.end(), std::back_inserter(own), [](PendingFile* file) { return !file->borrowed_; });
  for (PendingFile* const file : own) file->flush();
  const std::lock_guard lock(Unfinished::all().guard);
  try {
    for (PendingFile* const file : own) file->take_name();
    for (PendingFile* const file : own) file->flush_folder();
  } catch (...) {
    for (PendingFile* const file : own) file->withdraw();
    throw;
  }
  for (PendingFile* const file : own) file->settle();
}

/// Gives the new file the owner, group and permissions of the file it replaces.
void PendingFile::keep_permissions() {
  const std::optional<struct stat> old = status_in(folder_, file_name_);
  if (!old || !S_ISREG(old->st_mode)) return;
  struct stat own {};
  if (::fstat(descriptor_, &own) != 0) fail("look at it", errno);
  mode_t mode = old->st_mode & 0777;
  // A user may not give files away. In a user namespace, or on some file systems, other users do
  // not even exist.
  const auto may_not = [](int error) {
    return error == EPERM || error == EINVAL || error == ENOSYS || error == ENOTSUP;
  };
  if (old->st_uid != own.st_uid && ::fchown(descriptor_, old->st_uid, static_cast<gid_t>(-1)) != 0 && !may_not(errno))
    fail("keep its owner", errno);
  if (old->st_gid != own.st_gid && ::fchown(descriptor_, static_cast<uid_t>(-1), old->st_gid) != 0) {
    if (!may_not(errno)) fail("keep its group", errno);
    // The group has changed: it gets the permissions of all others.
    mode = (mode & 0707) | ((mode & 07) << 3);
  }
  if (::fchmod(descriptor_, mode) != 0) fail("keep its permissions", errno);
}

void PendingFile::flush() {
  keep_permissions();
  if (::fsync(descriptor_) != 0) fail("flush it to disk", errno);
  // Some file servers report a failed write only on close. The descriptor itself is still needed to
  // name the file, so close a copy.
  const int copy = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
  if (copy < 0) fail("flush it to disk", errno);
  if (::close(copy) != 0) fail("close it", errno);
}

void PendingFile::flush_folder() const {
  if (::fsync(folder_) != 0 && errno != EINVAL) fail("flush its folder to disk", errno);
}

void PendingFile::take_name() {
  if (options_.anonymous) {
    if (link_to(file_name_)) {
      has_name_ = true;
      return;
    }
    if (!options_.replace_existing) refuse_existing();
    link_temporary();  // no call replaces a name by an anonymous file
  }
  if (options_.replace_existing)
    replace_by_temporary();
  else
    rename_temporary();
}

/// Gives an anonymous file a name in the folder; false when the name is taken.
bool PendingFile::link_to(const std::string& name) const {
  const std::string self = concat("/proc/self/fd/", descriptor_);
  if (::linkat(AT_FDCWD, self.c_str(), folder_, name.c_str(), AT_SYMLINK_FOLLOW) == 0) return true;
  if (errno != EEXIST) fail("give it its name", errno);
  return false;
}

void PendingFile::link_temporary() {
  Unfinished::all().files.insert(this);  // before the name exists: this may run out of memory
  std::string second = next_temporary_name();
  while (!link_to(second)) second = next_temporary_name();
  temporary_name_ = std::move(second);
}

/// Locks the old file, so that other processes do not consider it stale.
void PendingFile::hold_old() {
  const std::optional<struct stat> status = status_in(folder_, file_name_);
  if (!status) return;
  if (!S_ISREG(status->st_mode))
    throw Error(ErrorCode::usage, concat(name_, ": found something else than a file, which came meanwhile"));
  old_ = ::openat(folder_, file_name_.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (old_ >= 0) ::flock(old_, LOCK_SH | LOCK_NB);
}

/// Gives the old file, if there is one, the temporary name until everything is settled.
void PendingFile::replace_by_temporary() {
  hold_old();
  const char *from = temporary_name_.c_str(), *to = file_name_.c_str();
  if (::renameat2(folder_, from, folder_, to, RENAME_EXCHANGE) == 0) {
    has_name_ = has_old_ = true;
    return;
  }
  if (errno != ENOENT && errno != EINVAL && errno != ENOSYS) fail("give it its name", errno);
  const bool is_new = errno == ENOENT;
  if (::renameat(folder_, from, folder_, to) != 0) fail("give it its name", errno);
  has_name_ = is_new;  // without an exchange, the replaced file cannot come back
  temporary_name_.clear();
  Unfinished::all().files.erase(this);
}

void PendingFile::rename_temporary() {
  const char *from = temporary_name_.c_str(), *to = file_name_.c_str();
  int error = ::renameat2(folder_, from, folder_, to, RENAME_NOREPLACE) == 0 ? 0 : errno;
  // If renaming cannot guarantee that it replaces nothing, linking can.
  if (error == EINVAL || error == ENOSYS) {
    error = ::linkat(folder_, from, folder_, to, 0) == 0 ? 0 : errno;
    if (error == 0) ::unlinkat(folder_, from, 0);
  }
  if (error == EEXIST) refuse_existing();
  if (error != 0) fail("give it its name", error);
  has_name_ = true;
  temporary_name_.clear();
  Unfinished::all().files.erase(this);
}

/// Makes the name final.
void PendingFile::settle() {
  has_name_ = has_old_ = false;
  remove_temporary();
}

/// Takes the name back: the old file has it again, or no file has it.
void PendingFile::withdraw() {
  if (!std::exchange(has_name_, false)) return;
  const std::lock_guard lock(Unfinished::all().guard);
  if (!std::exchange(has_old_, false)) {
    ::unlinkat(folder_, file_name_.c_str(), 0);
  } else if (::renameat(folder_, temporary_name_.c_str(), folder_, file_name_.c_str()) == 0) {
    temporary_name_.clear();
    Unfinished::all().files.erase(this);
  }
}

void end_pending_files() {
  PendingFile::Unfinished& all = PendingFile::Unfinished::all();
  all.guard.lock();  // never unlocked
  for (const PendingFile* const file : all.files) ::unlinkat(file->folder_, file->temporary_name_.c_str(), 0);
}

void write_whole_file(const fs::path& path, std::span<const std::byte> bytes, bool replace_existing) {
  PendingFile file(path, {.replace_existing = replace_existing});
  if (!bytes.empty()) file.reserve(bytes.size());
  file.append(bytes);
  file.publish();
}

void write_whole_file(const fs::path& path, std::string_view text, bool replace_existing) {
  write_whole_file(path, std::as_bytes(std::span(text)), replace_existing);
}

void PendingFiles::add(const fs::path& path, std::span<const std::byte> bytes) {
  auto file = std::make_unique<PendingFile>(path, PendingFile::Options{.replace_existing = replace_existing_});
  if (!bytes.empty()) file->reserve(bytes.size());
  file->append(bytes);
  files_.push_back(std::move(file));
}

void PendingFiles::publish() {
  publish_all(files_);
  files_.clear();
}

}  // namespace rhoray
