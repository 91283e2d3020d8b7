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

/// A file that gets its name when it is complete. Until then it has none (an anonymous file in the
/// target's folder) or, where the file system knows no such files, a temporary one.
///
/// Temporary names look like ".rhoray-PID-N.partial" and are locked (flock) while their process
/// lives. A process that is killed may leave one behind; the first PendingFile that another process
/// makes in that folder removes it.
class PendingFile {
 public:
  struct Options {
    bool replace_existing = false;
    /// false: a named temporary, as on file systems without anonymous files
    bool anonymous = true;
  };

  /// A symbolic link as target stands for the file that it points to. Refuses (ErrorCode::usage) a
  /// folder, a special file, a missing folder, and a file that exists unless it may be replaced;
  /// and (ErrorCode::resource) a folder in which no file can be made.
  PendingFile(const std::filesystem::path& target, Options options);

  /// Writes into a descriptor that stays the caller's; `publish` then names nothing. What it held
  /// is discarded.
  explicit PendingFile(int borrowed_descriptor);

  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile();

  const std::string& name() const { return name_; }
  int descriptor() const { return descriptor_; }

  /// A path by which a library or another process can open the file for writing while this one
  /// lives.
  std::filesystem::path open_name() const;

  /// Gives the file its size, all bytes 0, and takes the space on disk now. ErrorCode::resource
  /// when there is not enough.
  void reserve(std::uint64_t bytes);

  /// All bytes, or an exception. Several threads may write at once.
  void write(std::uint64_t first_byte, std::span<const std::byte> bytes);

  /// Writes behind what `append` wrote before.
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text) { append(std::as_bytes(std::span(text))); }

  /// Flushes, gives the file its name, flushes the folder. A file of that name that came meanwhile
  /// is refused (ErrorCode::usage) unless it may be replaced; then it is replaced in one step, and
  /// its permissions, owner and group are kept (the last two where the user may set them). When
  /// anything fails, the old file has its name again, or there is none. (Only a file system that
  /// cannot exchange two names keeps the new file if the folder's flush fails.) Refuses
  /// (ErrorCode::invalid) when an input lost bytes while it was mapped and nobody was told yet
  /// (mapped_file.h): what was written may come from it.
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
  bool has_name_ = false;  ///< and is not settled: the name can be taken back
  bool has_old_ = false;   ///< the temporary name holds the file that is replaced
  int descriptor_ = -1;
  int folder_ = -1;
  int old_ = -1;  ///< the file that is replaced, locked while it has the temporary name
  std::uint64_t appended_bytes_ = 0;
  std::string file_name_;       ///< in folder_
  std::string temporary_name_;  ///< in folder_; empty while there is none
};

/// Publishes files that belong together: all are flushed before the first gets its name, and when
/// one cannot be named, those before it lose theirs again.
void publish_all(std::span<const std::unique_ptr<PendingFile>> files);

/// The whole act for a few bytes.
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

/// Removes the temporary names of all files of this process that are not complete, after waiting
/// for those that are just getting their names. To be called once, before the process ends without
/// destructors: afterwards no file of it is named any more, and who tries waits for ever.
void end_pending_files();

}  // namespace rhoray
