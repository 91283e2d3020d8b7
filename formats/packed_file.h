#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rhoray::formats {

/// Element types of arrays, named as in safetensors. Everything is little-endian.
enum class ElementType : std::uint8_t { U8, I8, U16, I16, U32, I32, U64, I64, F32, F64 };

std::size_t element_bytes(ElementType type);
std::string_view element_name(ElementType type);  ///< "U8", "F64", ...

template <class T>
constexpr ElementType element_type_of();  // below

/// Calls act(T{}) with the C++ type that `type` stands for; returns what act returns.
template <class Act>
decltype(auto) with_element_type(ElementType type, Act&& act);  // below

/// One named array: what a writer declares.
struct ArraySpec {
  std::string name;
  ElementType type = ElementType::U8;
  std::vector<std::uint64_t> shape;  ///< slowest axis first; at most 8 axes
  std::uint64_t alignment = 64;      ///< of its first byte in the file: 64, or 4096 for bricks
};

/// One named array: what a reader finds.
struct ArrayEntry {
  std::string name;
  ElementType type = ElementType::U8;
  std::vector<std::uint64_t> shape;
  std::uint64_t first_byte = 0;  ///< counted from the start of the file
  std::uint64_t byte_count = 0;

  std::uint64_t element_count() const;
};

/// What the header says of the file as a whole.
struct FileDescription {
  std::string kind;                        ///< "grid", "tets", or a neutral kind that workers hand over
  std::vector<std::string> required = {};  ///< features that a reader must know; an unknown one is refused by name
  std::string details = "{}";              ///< one JSON text; its meaning belongs to the kind
  int minor_version = 0;                   ///< of the format 1.x: the first that has all that the file uses
};

/// 64 KiB of the data area whose checksum does not match.
struct DamagedBlock {
  std::uint64_t first_byte = 0;  ///< counted from the start of the file
  std::uint64_t byte_count = 0;
};

/// A packed file (SPEC.md), memory-mapped. Opening checks the seal, the header, the table of checksums and the layout
/// of the arrays, and reads nothing else: its cost does not depend on the file's size beyond 8 bytes per 64 KiB.
/// Checking the data itself is `damaged_blocks`, apart, so that a caller may do it beside its work.
///
/// Copies share the mapping; spans and views stay valid while any copy lives.
class PackedFile {
 public:
  /// Refuses with Trouble::unreadable (missing, not a file), invalid (damaged, not a packed file) or unsupported
  /// (newer version, unknown requirement). Nothing is allocated because a number in the file asks for it.
  static PackedFile open(const std::filesystem::path& path);

  /// As `open`, on a descriptor (not closed, position not used); `name` stands for the file in messages.
  static PackedFile from_descriptor(int descriptor, std::string name);

  /// True when the file starts like a packed file; false also when it cannot be read.
  static bool looks_packed(const std::filesystem::path& path);

  const std::string& name() const;  ///< path as given, for messages
  const std::string& version() const;
  const FileDescription& description() const;
  const std::vector<ArrayEntry>& arrays() const;  ///< without padding, checksums and seal; sorted by position
  std::uint64_t file_bytes() const;

  bool has(std::string_view array) const;
  const ArrayEntry& entry(std::string_view array) const;  ///< refuses when there is no such array
  std::span<const std::byte> bytes(std::string_view array) const;

  /// The array's elements; refuses when it is missing, or has another type or shape. In `shape`, 0 takes any size.
  template <class T>
  std::span<const T> array(std::string_view name, std::span<const std::uint64_t> shape) const {
    const std::span<const std::byte> raw = checked_bytes(name, element_type_of<T>(), shape);
    return {reinterpret_cast<const T*>(raw.data()), raw.size() / sizeof(T)};
  }
  template <class T>
  std::span<const T> array(std::string_view name, std::initializer_list<std::uint64_t> shape) const {
    return array<T>(name, std::span(shape.begin(), shape.size()));
  }

  /// Reads every byte of the data area once, on `threads` threads (0 = all cores), and names each damaged block.
  std::vector<DamagedBlock> damaged_blocks(unsigned threads = 0) const;

 private:
  struct Mapping;
  explicit PackedFile(std::shared_ptr<const Mapping> mapping) : mapping_(std::move(mapping)) {}
  std::span<const std::byte> checked_bytes(std::string_view name, ElementType type,
                                           std::span<const std::uint64_t> shape) const;
  std::shared_ptr<const Mapping> mapping_;
};

/// Writes a packed file. The whole layout is declared first and its space reserved, so that a full disk fails early;
/// arrays are filled in any order and from any thread; `commit` adds checksums and seal and gives the file its name.
/// Without `commit` (an error, an interrupt, a kill) nothing appears under that name, and a file that was there stays.
class PackedFileWriter {
 public:
  struct Options {
    bool replace_existing = false;  ///< otherwise an existing file is refused (Trouble::usage)
  };
  PackedFileWriter(std::filesystem::path path, FileDescription description, std::vector<ArraySpec> arrays,
                   Options options);
  PackedFileWriter(std::filesystem::path path, FileDescription description, std::vector<ArraySpec> arrays)
      : PackedFileWriter(std::move(path), std::move(description), std::move(arrays), Options{}) {}

  /// Writes into an open descriptor (an anonymous file that is handed to another process) instead of a named file.
  PackedFileWriter(int descriptor, FileDescription description, std::vector<ArraySpec> arrays);

  PackedFileWriter(PackedFileWriter&&) noexcept;
  PackedFileWriter& operator=(PackedFileWriter&&) noexcept;
  ~PackedFileWriter();

  /// Fills part of an array. Every byte of every array is written exactly once; `commit` refuses otherwise.
  /// May be called from several threads.
  void write(std::string_view array, std::uint64_t byte_offset, std::span<const std::byte> bytes);

  template <class T>
  void write_all(std::string_view array, std::span<const T> values) {
    write(array, 0, std::as_bytes(values));
  }

  /// Checksums what is on disk, seals, flushes, and renames into place. Returns the size of the file.
  std::uint64_t commit(unsigned threads = 0);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// ------------------------------------------------------------------------------------------------------------------

template <class T>
constexpr ElementType element_type_of() {
  if constexpr (std::is_same_v<T, std::uint8_t>)
    return ElementType::U8;
  else if constexpr (std::is_same_v<T, std::int8_t>)
    return ElementType::I8;
  else if constexpr (std::is_same_v<T, std::uint16_t>)
    return ElementType::U16;
  else if constexpr (std::is_same_v<T, std::int16_t>)
    return ElementType::I16;
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return ElementType::U32;
  else if constexpr (std::is_same_v<T, std::int32_t>)
    return ElementType::I32;
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return ElementType::U64;
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return ElementType::I64;
  else if constexpr (std::is_same_v<T, float>)
    return ElementType::F32;
  else {
    static_assert(std::is_same_v<T, double>, "not an element type");
    return ElementType::F64;
  }
}

template <class Act>
decltype(auto) with_element_type(ElementType type, Act&& act) {
  switch (type) {
    case ElementType::U8:
      return act(std::uint8_t{});
    case ElementType::I8:
      return act(std::int8_t{});
    case ElementType::U16:
      return act(std::uint16_t{});
    case ElementType::I16:
      return act(std::int16_t{});
    case ElementType::U32:
      return act(std::uint32_t{});
    case ElementType::I32:
      return act(std::int32_t{});
    case ElementType::U64:
      return act(std::uint64_t{});
    case ElementType::I64:
      return act(std::int64_t{});
    case ElementType::F32:
      return act(float{});
    case ElementType::F64:
      break;
  }
  return act(double{});
}

}  // namespace rhoray::formats
