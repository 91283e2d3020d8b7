#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/file_description.h"

namespace rhoray::formats {

/// 64 KiB of the data area whose checksum does not match.
struct DamagedBlock {
  std::uint64_t first_byte = 0;  ///< counted from the start of the file
  std::uint64_t byte_count = 0;
};

/// A packed file (SPEC.md), memory-mapped. Opening checks the seal, the header, the table of
/// checksums and the layout of the arrays, and reads nothing else: its cost does not depend on the
/// file's size beyond 8 bytes per 64 KiB. Checking the data itself is `damaged_blocks`, apart, so
/// that a caller may do it beside its work.
///
/// Copies share the mapping; spans and views stay valid while any copy lives.
class PackedFile {
 public:
  /// Refuses with ErrorCode::unreadable (missing, not a file), invalid (damaged, not a packed file)
  /// or unsupported (newer version, unknown requirement). Nothing is allocated because a number in
  /// the file asks for it.
  static PackedFile open(const std::filesystem::path& path);

  /// As `open`, on a descriptor (not closed, position not used); `name` stands for the file in
  /// messages.
  static PackedFile from_descriptor(int descriptor, std::string name);

  /// True when the file starts like a packed file; false also when it cannot be read.
  static bool looks_packed(const std::filesystem::path& path);

  const std::string& name() const;  ///< path as given, for messages
  const std::string& version() const;
  const FileDescription& description() const;
  /// without padding, checksums and seal; sorted by position
  const std::vector<ArrayEntry>& arrays() const;
  std::uint64_t file_bytes() const;

  bool has(std::string_view array) const;
  const ArrayEntry& entry(std::string_view array) const;  ///< refuses when there is no such array
  std::span<const std::byte> bytes(std::string_view array) const;

  /// The array's elements; refuses when it is missing, or has another type or shape. In `shape`, 0
  /// takes any size.
  template <class T>
  std::span<const T> array(std::string_view name, std::span<const std::uint64_t> shape) const {
    const std::span<const std::byte> raw = checked_bytes(name, element_type_of<T>(), shape);
    return {reinterpret_cast<const T*>(raw.data()), raw.size() / sizeof(T)};
  }
  template <class T>
  std::span<const T> array(std::string_view name, std::initializer_list<std::uint64_t> shape) const {
    return array<T>(name, std::span(shape.begin(), shape.size()));
  }

  /// Reads every byte of the data area once, on `threads` threads (0 = all cores), and names each
  /// damaged block.
  std::vector<DamagedBlock> damaged_blocks(unsigned threads = 0) const;

 private:
  struct Mapping;
  explicit PackedFile(std::shared_ptr<const Mapping> mapping) : mapping_(std::move(mapping)) {}
  std::span<const std::byte> checked_bytes(std::string_view name, ElementType type,
                                           std::span<const std::uint64_t> shape) const;
  std::shared_ptr<const Mapping> mapping_;
};

/// Writes a packed file. The whole layout is declared first and its space reserved, so that a full
/// disk fails early; arrays are filled in any order and from any thread; `commit` adds checksums
/// and seal and gives the file its name. Without `commit` (an error, an interrupt, a kill) nothing
/// appears under that name, and a file that was there stays.
class PackedFileWriter {
 public:
  struct Options {
    bool replace_existing = false;  ///< otherwise an existing file is refused (ErrorCode::usage)
  };
  PackedFileWriter(std::filesystem::path path, FileDescription description, std::vector<ArraySpec> arrays,
                   Options options);
  PackedFileWriter(std::filesystem::path path, FileDescription description, std::vector<ArraySpec> arrays)
      : PackedFileWriter(std::move(path), std::move(description), std::move(arrays), Options{}) {}

  /// Writes into an open descriptor (an anonymous file that is handed to another process) instead
  /// of a named file.
  PackedFileWriter(int descriptor, FileDescription description, std::vector<ArraySpec> arrays);

  PackedFileWriter(PackedFileWriter&&) noexcept;
  PackedFileWriter& operator=(PackedFileWriter&&) noexcept;
  ~PackedFileWriter();

  /// Fills part of an array. Every byte of every array is written exactly once; `commit` refuses
  /// otherwise.
  /// May be called from several threads.
  void write(std::string_view array, std::uint64_t byte_offset, std::span<const std::byte> bytes);

  template <class T>
  void write_all(std::string_view array, std::span<const T> values) {
    write(array, 0, std::as_bytes(values));
  }

  /// Checksums what is on disk, seals, flushes, and renames into place. Returns the size of the
  /// file.
  std::uint64_t commit(unsigned threads = 0);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rhoray::formats
