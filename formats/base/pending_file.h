#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace rhoray {

/// A file that gets its name when it is complete. Until then it has none (an anonymous file in the target's folder) or,
/// where the file system knows no such files, a temporary one that is removed unless the process is killed.
class PendingFile {
 public:
  struct Options {
    bool replace_existing = false;
    bool anonymous = true;  ///< false: a named temporary, as on file systems without anonymous files
  };

  /// A symbolic link as target stands for the file that it points to. Refuses (Trouble::usage) a folder, a special
  /// file, a missing or closed folder, and a file that exists unless it may be replaced.
  PendingFile(const std::filesystem::path& target, Options options);

  /// Writes into a descriptor that stays the caller's; `publish` then names nothing. What it held is discarded.
  explicit PendingFile(int borrowed_descriptor);

  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;
  ~PendingFile();

  const std::string& name() const { return name_; }
  int descriptor() const { return descriptor_; }

  /// A path by which a library or another process can open the file for writing while this one lives.
  std::filesystem::path open_name() const;

  /// Gives the file its size, all bytes 0, and takes the space on disk now. Trouble::resource when there is not enough.
  void reserve(std::uint64_t bytes);

  /// All bytes, or an exception.
  void write(std::uint64_t first_byte, std::span<const std::byte> bytes);

  /// Flushes, gives the file its name, flushes the folder. A file of that name that came meanwhile is refused
  /// (Trouble::usage) unless it may be replaced; then it is replaced in one step.
  void publish();

 private:
  void open_target(const std::filesystem::path& target);
  void create();
  void create_named();
  bool link_to(const std::string& name) const;
  void name_anonymous();
  void name_temporary();
  void release();
  [[noreturn]] void fail(const std::string& act, int error) const;
  [[noreturn]] void refuse_existing() const;

  std::string name_;  ///< as given, for messages
  std::filesystem::path folder_name_;
  Options options_;
  bool borrowed_ = false;
  int descriptor_ = -1;
  int folder_ = -1;
  std::string file_name_;       ///< in folder_
  std::string temporary_name_;  ///< in folder_; empty while there is none
};

}  // namespace rhoray
