#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/base/progress.h"
#include "formats/file_description.h"

namespace rhoray::formats {

/// A block of 64 KiB of the data area whose checksum does not match.
struct DamagedBlock {
  std::uint64_t first_byte = 0;  ///< counted from the start of the file
  std::uint64_t byte_count = 0;
};

/// An array that is not in a packed file: the caller has it in memory.
struct OutsideArray {
  ArraySpec spec;
  std::span<const std::byte> bytes;  ///< as many as the shape says, aligned for their type
};

/// A packed file (SPEC.md), memory-mapped. Opening checks the seal, the header, the checksum table
/// and the layout of the arrays, and reads nothing else. Its cost does not depend on the file's
/// size, except for 8 bytes per 64 KiB. `damaged_blocks` checks the data separately, so a caller
/// can run it in parallel with other work.
///
/// Copies share the mapping; spans and views stay valid while any copy lives.
class PackedFile {
 public:
  /// Refuses with ErrorCode::unreadable (missing, not a file), invalid (damaged, not a packed file)
  /// or unsupported (newer version, unknown requirement). A number in the file alone never makes it
  /// allocate memory.
  static PackedFile open(const std::filesystem::path& path);

  /// Like `open`, but reads from a descriptor, which is not closed; its file position is not used.
  /// `name` identifies the file in messages.
  static PackedFile from_descriptor(int descriptor, std::string name) {
    return from_descriptor(descriptor, std::move(name), {}, nullptr);
  }
  /// As above, with further arrays at the end of arrays(). Their bytes are not checked and must not
  /// change.
  /// @param owner  of the arrays' memory; released with the last copy
  static PackedFile from_descriptor(int descriptor, std::string name, std::span<const OutsideArray> outside,
                                    std::shared_ptr<const void> owner);

  /// True when the file starts like a packed file; false also when it cannot be read.
  static bool looks_packed(const std::filesystem::path& path);

  const std::string& name() const;  ///< path as given, for messages
  const std::string& version() const;
  const FileDescription& description() const;
  /// without padding, checksums and seal; sorted by offset
  const std::vector<ArrayEntry>& arrays() const;
  std::uint64_t file_bytes() const;

  bool has(std::string_view array) const;
  const ArrayEntry& entry(std::string_view array) const;  ///< refuses when there is no such array
  std::span<const std::byte> bytes(std::string_view array) const;

  /// The array's elements. Refuses when the array is missing, or has another type or shape. A 0 in
  /// `shape` accepts any size.
  template <class T>
  std::span<const T> array(std::string_view name, std::span<const std::uint64_t> shape) const {
    const std::span<const std::byte> raw = checked_bytes(name, element_type_of<T>(), shape);
    return {reinterpret_cast<const T*>(raw.data()), raw.size() / sizeof(T)};
  }
  template <class T>
  std::span<const T> array(std::string_view name, std::initializer_list<std::uint64_t> shape) const {
    return array<T>(name, std::span(shape.begin(), shape.size()));
  }

  /// Reads every byte of the data area once, on `threads` threads (0 = all cores), and returns each
  /// damaged block. Arrays outside the file are not read.
  std::vector<DamagedBlock> damaged_blocks(unsigned threads = 0, const Watch& watch = {}) const;

 private:
  struct Mapping;
  explicit PackedFile(std::shared_ptr<const Mapping> mapping) : mapping_(std::move(mapping)) {}
  std::span<const std::byte> checked_bytes(std::string_view name, ElementType type,
                                           std::span<const std::uint64_t> shape) const;
  std::shared_ptr<const Mapping> mapping_;
};

/// The target of a packed file: a path, or an open descriptor, such as that of a file in memory or
/// of a file that is sent to another process.
struct Destination {
  std::filesystem::path path{};
  int descriptor = -1;  ///< when not -1, nothing gets a name

  Destination(std::filesystem::path name) : path(std::move(name)) {}
  explicit Destination(int open_descriptor) : descriptor(open_descriptor) {}
};

/// Writes a packed file. The whole layout is declared first and its space reserved, so that a full
/// disk fails early. Arrays are filled in any order and from any thread. `commit` adds checksums
/// and seal and gives the file its name. Without `commit` (an error, an interrupt, a kill) nothing
/// appears under that name, and an existing file stays.
class PackedFileWriter {
 public:
  struct Options {
    bool replace_existing = false;  ///< false: an existing file is refused (ErrorCode::usage)
  };
  PackedFileWriter(const Destination& destination, const FileDescription& description,
                   const std::vector<ArraySpec>& arrays, Options options);
  PackedFileWriter(const Destination& destination, const FileDescription& description,
                   const std::vector<ArraySpec>& arrays)
      : PackedFileWriter(destination, description, arrays, Options{}) {}
  PackedFileWriter(int descriptor, const FileDescription& description, const std::vector<ArraySpec>& arrays)
      : PackedFileWriter(Destination(descriptor), description, arrays) {}

  PackedFileWriter(PackedFileWriter&&) noexcept;
  PackedFileWriter& operator=(PackedFileWriter&&) noexcept;
  ~PackedFileWriter();

  /// Fills part of an array. Every byte of every array must be written exactly once; otherwise
  /// `commit` refuses. May be called from several threads.
  void write(std::string_view array, std::uint64_t byte_offset, std::span<const std::byte> bytes);

  template <class T>
  void write_all(std::string_view array, std::span<const T> values) {
    write(array, 0, std::as_bytes(values));
  }

  /// Computes checksums of what is on disk, adds the seal, flushes, and renames the file into
  /// place. Returns the size of the file.
  std::uint64_t commit(unsigned threads = 0);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rhoray::formats
