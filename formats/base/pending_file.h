#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray {

/// A file that gets its name when it is complete. Until then it has no name (an anonymous file in
/// the target's folder). Where the file system does not support such files, it has a temporary
/// name.
///
/// Temporary names look like ".rhoray-PID-N.partial" and are locked (flock) while their process
/// lives. A process that is killed may leave one behind. The first PendingFile that another process
/// makes in that folder removes it.
class PendingFile {
 public:
  struct Options {
    bool replace_existing = false;
    /// false: use a named temporary file, as on file systems without anonymous files
    bool anonymous = true;
  };

  /// If the target is a symbolic link, the file it points to is written. Refuses (ErrorCode::usage)
  /// a folder, a special file, a missing folder, and an existing file unless it may be replaced.
  /// Refuses (ErrorCode::resource) a folder in which no file can be created.
  PendingFile(const std::filesystem::path& target, Options options);

  /// Writes into a descriptor that the caller owns; `publish` then gives no name. Previous content
  /// is discarded.
  explicit PendingFile(int borrowed_descriptor);

  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile();

  const std::string& name() const { return name_; }
  int descriptor() const { return descriptor_; }

  /// A path by which a library or another process can open the file for writing while this object
  /// lives.
  std::filesystem::path open_name() const;

  /// Sets the file's size, with all bytes 0, and allocates the space on disk now.
  /// ErrorCode::resource when there is not enough.
  void reserve(std::uint64_t bytes);

  /// Writes all bytes or throws. Several threads may write at once.
  void write(std::uint64_t first_byte, std::span<const std::byte> bytes);

  /// Writes after the bytes of previous calls of `append`.
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text) { append(std::as_bytes(std::span(text))); }

  /// Flushes the file, gives it its name, and flushes the folder. A file with that name that
  /// appeared meanwhile is refused (ErrorCode::usage) unless it may be replaced. Then it is
  /// replaced in one step, and its permissions, owner and group are kept (the last two where the
  /// user may set them).
  ///
  /// If anything fails, the old file has its name again, or no file has it. There is one exception:
  /// on a file system that cannot exchange two names, the new file stays if flushing the folder
  /// fails.
  ///
  /// Refuses (ErrorCode::invalid) when an input lost bytes while it was mapped and no error has
  /// reported it yet (mapped_file.h). The output may depend on those bytes.
  void publish();

 private:
  friend void publish_all(std::span<const std::unique_ptr<PendingFile>> files);
  friend void end_pending_files();
  struct Unfinished;

  static void publish_each(std::span<PendingFile* const> files);
  void open_target(const std::filesystem::path& target);
  void create();
  void create_named();
  void keep_permissions();
  void flush();
  void take_name();
  void flush_folder() const;
  void hold_old();
  void settle();
  void withdraw();
  bool link_to(const std::string& name) const;
  void link_temporary();
  void rename_temporary();
  void replace_by_temporary();
  void remove_temporary();
  void release();
  [[noreturn]] void fail(const std::string& act, int error, std::uint64_t needed_bytes = 0) const;
  [[noreturn]] void refuse_existing() const;

  std::string name_;  ///< as given, for messages
  std::filesystem::path folder_name_;
  Options options_;
  bool borrowed_ = false;
  bool has_name_ = false;  ///< named, but not final: the name can be taken back
  bool has_old_ = false;   ///< the temporary name holds the file being replaced
  int descriptor_ = -1;
  int folder_ = -1;
  int old_ = -1;  ///< the file being replaced, locked while it has the temporary name
  std::uint64_t appended_bytes_ = 0;
  std::string file_name_;       ///< in folder_
  std::string temporary_name_;  ///< in folder_; empty: none
};

/// Publishes files that belong together. All are flushed before the first gets its name. If one
/// cannot be named, the files before it lose their names again.
void publish_all(std::span<const std::unique_ptr<PendingFile>> files);

/// Writes a whole file in one call, for a few bytes.
void write_whole_file(const std::filesystem::path& path, std::span<const std::byte> bytes, bool replace_existing);
void write_whole_file(const std::filesystem::path& path, std::string_view text, bool replace_existing);

/// Several files that appear together or not at all.
class PendingFiles {
 public:
  explicit PendingFiles(bool replace_existing) : replace_existing_(replace_existing) {}

  void add(const std::filesystem::path& path, std::span<const std::byte> bytes);
  void add(const std::filesystem::path& path, std::string_view text) { add(path, std::as_bytes(std::span(text))); }
  void publish();

 private:
  bool replace_existing_;
  std::vector<std::unique_ptr<PendingFile>> files_;
};

/// Removes the temporary names of all incomplete files of this process, after waiting for files
/// that are being named right now. Call it once, before the process ends without destructors.
/// Afterwards this process names no file any more; a thread that tries waits for ever.
void end_pending_files();

}  // namespace rhoray
