#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/faults/recorded_calls.h"

namespace rhoray::tests {

struct RecordedCall {
  CallHeader header;
  std::string name, second_name, bytes;
  std::uint64_t record_end = 0;  ///< size of the record including this call
};

std::vector<RecordedCall> read_calls(const std::filesystem::path& record);

/// The files of a folder with their contents.
using FolderContents = std::map<std::string, std::string>;

/// The files of a folder with their contents and inode numbers.
struct NumberedFile {
  std::uint64_t number = 0;
  std::string content;
};
using NumberedFolder = std::map<std::string, NumberedFile>;

NumberedFolder read_folder(const std::filesystem::path& folder);

/// The states of a folder that a crash can leave behind, relying on nothing but what fsync
/// promises.
///
/// A call changes the pages of a file, its size, or names. Each change reaches the disk at any time
/// after its call, in any order with the others. It is certainly on the disk when a flush that
/// began after the call has ended: a flush of the file for pages and size, of the folder for names.
/// A page that has not arrived holds its previous content, or zeros. A rename is there completely
/// or not at all.
class CrashModel {
 public:
  /// @param before  the folder before the calls, all of it on the disk
  CrashModel(const NumberedFolder& before, const std::vector<RecordedCall>& calls);

  /// The folder after all calls, without a crash.
  FolderContents outcome() const;

  /// Draws a possible state after the given number of ended calls. In half of the states, changes
  /// of names are there as a journal leaves them: all changes up to one of them, and none after it.
  FolderContents draw(std::size_t calls_ended, std::mt19937_64& random) const;

 private:
  static constexpr std::size_t never = std::numeric_limits<std::size_t>::max();

  struct Change {
    enum class What { bytes, size, names };
    What what = What::bytes;
    std::size_t call = 0;          ///< call that makes the change
    std::size_t flush = never;     ///< call that makes the change durable
    std::uint64_t record_end = 0;  ///< of the call that makes the change
    std::size_t file = 0;          ///< index in files_; for bytes and size
    std::uint64_t at = 0;          ///< first byte, or the size
    std::string bytes = {};
    /// Names with their files, or none.
    std::vector<std::pair<std::string, std::optional<std::size_t>>> names = {};
  };
  class Reader;

  template <class IsThere>
  FolderContents state(const IsThere& is_there) const;

  std::vector<std::string> files_;  ///< contents before the calls
  std::map<std::string, std::size_t> names_;
  std::vector<Change> changes_;
};

}  // namespace rhoray::tests
