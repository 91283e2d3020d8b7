#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
/// Supports text, base64 and appended data, plain or compressed by zlib, in both byte orders. VTK's
/// own reader would first hold the whole data set in its own memory. Reports progress like a
/// worker.
class VtkXmlStream {
 public:
  /// Returns nothing for a file with unknown features or that is not well-formed; VTK's reader then
  /// decides. Views refer to the file, which must outlive them.
  static std::optional<VtkXmlStream> open(const ForeignFile& file);

  /// The element that the file's type names: UnstructuredGrid or ImageData.
  const XmlElement& data_set() const { return *root_.child(root_.attribute("type")); }

  /// The description in a DataArray element. Nothing for arrays that are not numeric, belong to
  /// time steps, or lack a required name.
  std::optional<VtkXmlArray> array(const XmlElement& element) const;

  /// All arrays of PointData or CellData, which may be missing (null). Nothing if one of them has no
  /// name or no description as above.
  std::optional<std::vector<VtkXmlArray>> arrays_in(const XmlElement* data) const;

  /// Reads all of `numbers`. Refuses arrays that hold fewer, and damaged ones. Number is double, or
  /// an unsigned integer, to which negative numbers are cast.
  template <class Number>
  void read(const VtkXmlArray& array, std::span<Number> numbers) const;

  /// Reads the array's bytes in native byte order.
  void read_bytes(const VtkXmlArray& array, std::span<std::byte> bytes) const;

  /// Refuses more numbers than the file's bytes can hold. Call it before allocating memory for
  /// them.
  void check_count(const VtkXmlArray& array, std::uint64_t count) const;

 private:
  struct Source;
  class Blocks;

  VtkXmlStream(const ForeignFile& file, XmlElement root) : file_(&file), root_(std::move(root)) {}
  bool take_encoding();
  void count_progress(std::uint64_t bytes) const;
  template <class Act>
  void for_each_piece(const VtkXmlArray& array, std::uint64_t wanted_bytes, const Act& act) const;
  template <class Act>
  void for_each_plain_piece(const VtkXmlArray& array, Source source, std::uint64_t wanted_bytes, const Act& act) const;
  template <class Act>
  void for_each_packed_piece(const VtkXmlArray& array, Source source, std::uint64_t wanted_bytes, const Act& act) const;
  Source source_of(const VtkXmlArray& array) const;
  std::uint64_t header_number(const VtkXmlArray& array, Source& source) const;
  [[noreturn]] void refuse(const VtkXmlArray& array, std::string_view found, std::string_view expected) const;

  const ForeignFile* file_;
  XmlElement root_;
  bool big_endian_ = false;
  bool is_packed_ = false;
  bool appended_base64_ = false;
  std::size_t header_bytes_ = 4;  ///< size of each number before the data
  std::string_view appended_;     ///< after its underscore
  std::shared_ptr<std::atomic<std::uint64_t>> bytes_done_ = std::make_shared<std::atomic<std::uint64_t>>(0);
};

}  // namespace rhoray::preprocess
