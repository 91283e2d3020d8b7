#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/vtk/xml_outline.h"
#include "preprocess/neutral.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

/// A numeric array in a VTK XML file, as its tag describes it; not read yet.
struct VtkXmlArray {
  enum class Format { text, base64, appended };
  std::string name;
  std::string unit;
  formats::ElementType type = formats::ElementType::U8;
  int component_count = 1;
  Format format = Format::text;
  std::string_view content;         ///< content of the element: text or base64
  std::uint64_t appended_byte = 0;  ///< offset from the start of the appended data
};

/// A VTK XML file whose arrays are read one at a time, block by block, directly into our arrays.
/// Supports text, base64 and appended data, plain or compressed by zlib, LZ4 or LZMA, in both byte
/// orders. Reports progress like a worker.
class VtkXmlStream {
 public:
  /// Refuses a file whose root is not a VTKFile of this type, one that is not well-formed, and
  /// unknown encodings. Views refer to the file, which must outlive them.
  VtkXmlStream(const ForeignFile& file, std::string_view type);

  /// The element that the file's type names, such as UnstructuredGrid.
  const XmlElement& data_set() const { return *root_.child(root_.attribute("type")); }

  bool is_before_version(int major, int minor) const { return std::pair(major_, minor_) < std::pair(major, minor); }

  /// A count in an attribute. Refuses one that a file this short cannot hold.
  std::uint64_t count_in(const XmlElement& element, std::string_view name) const;
  void check_attribute(std::string_view name, std::uint64_t count) const;

  /// All arrays of an element, which may be missing (null), at the first time step. Arrays that do
  /// not hold numbers are left out.
  /// @param left_out  receives a note about each of these; may be null
  std::vector<VtkXmlArray> arrays_in(const XmlElement* element, std::vector<std::string>* left_out = nullptr) const;

  /// The number of numbers in an array of so many points or cells. Refuses more than the file's
  /// bytes can hold. Call it before allocating memory for them.
  std::uint64_t checked_count(const VtkXmlArray& array, std::uint64_t owners) const;

  /// Reads all of `numbers`. Refuses arrays that hold fewer, and damaged ones. Number is double, or
  /// an unsigned integer, to which negative numbers are cast, or std::byte for the array's bytes in
  /// native byte order.
  template <class Number>
  void read(const VtkXmlArray& array, std::span<Number> numbers) const;

  /// The same, for an array of so many points or cells.
  template <class Number>
  Array<Number> numbers(const VtkXmlArray& array, std::uint64_t owners) const {
    static_assert(!std::is_same_v<Number, std::byte>);
    Array<Number> result(checked_count(array, owners));
    read(array, std::span<Number>(result));
    return result;
  }

  /// Notes of the arrays that were read so far and that hold more than their numbers.
  const std::vector<std::string>& notes() const { return *notes_; }

  [[noreturn]] void refuse(std::string_view place, std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const {
    refuse_input(file_->path(), place, found, expected, error_code);
  }
  [[noreturn]] void refuse_attribute(std::string_view name, std::string_view found, std::string_view expected) const {
    refuse(concat("attribute ", name), found, expected);
  }

 private:
  struct Source;
  class Blocks;

  enum class Packing : std::uint8_t { none, zlib, lz4, lzma };

  void take_version();
  void take_encoding();
  std::optional<VtkXmlArray> array(const XmlElement& element) const;
  void count_progress(std::uint64_t bytes) const;
  template <class Act>
  void for_each_piece(const VtkXmlArray& array, std::uint64_t wanted_bytes, const Act& act) const;
  template <class Act>
  void for_each_plain_piece(const VtkXmlArray& array, Source source, std::uint64_t wanted_bytes, const Act& act) const;
  template <class Act>
  void for_each_packed_piece(const VtkXmlArray& array, Source source, std::uint64_t wanted_bytes, const Act& act) const;
  Source source_of(const VtkXmlArray& array) const;
  std::uint64_t header_number(const VtkXmlArray& array, Source& source) const;
  [[noreturn]] void refuse(const VtkXmlArray& array, std::string_view found, std::string_view expected) const {
    refuse(concat("array '", array.name, "'"), found, expected);
  }

  const ForeignFile* file_;
  XmlElement root_;
  int major_ = 0, minor_ = 0;  ///< of the file's version
  bool big_endian_ = false;
  Packing packing_ = Packing::none;
  bool appended_base64_ = false;
  std::size_t header_bytes_ = 4;  ///< size of each number before the data
  std::string_view appended_;     ///< after its underscore
  std::shared_ptr<std::vector<std::string>> notes_ = std::make_shared<std::vector<std::string>>();
  std::shared_ptr<std::atomic<std::uint64_t>> bytes_done_ = std::make_shared<std::atomic<std::uint64_t>>(0);
};

/// N numbers separated by spaces; nothing for anything else.
template <class T, std::size_t N>
std::optional<std::array<T, N>> numbers_in(std::string_view text) {
  constexpr std::string_view spaces = " \t\r\n";
  std::array<T, N> numbers{};
  std::size_t at = 0;
  for (T& number : numbers) {
    at = std::min(text.find_first_not_of(spaces, at), text.size());
    const std::size_t end = std::min(text.find_first_of(spaces, at), text.size());
    const std::optional<T> found = parse_number<T>(text.substr(at, end - at));
    if (!found) return std::nullopt;
    number = *found;
    at = end;
  }
  return text.find_first_not_of(spaces, at) == text.npos ? std::optional(numbers) : std::nullopt;
}

}  // namespace rhoray::preprocess
