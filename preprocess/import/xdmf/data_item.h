#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "preprocess/import/reading/hdf5_file.h"
#include "preprocess/import/xdmf/xdmf_document.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The numbers of a DataItem: text, binary, or a data set of an HDF5 file, or a part of one of
/// these. Checked against the real bytes, but not read yet.
class XdmfNumbers {
 public:
  std::uint64_t count() const { return count_; }
  /// In an HDF5 file, the file decides the type.
  formats::ElementType type() const { return type_; }

  /// Reads all numbers. T is double, std::int64_t (floats are refused), or std::byte for numbers of
  /// type() in native byte order. Doubles in text without a Precision keep every digit.
  template <class T>
  Array<T> read() const;

  /// Names the line of the DataItem.
  [[noreturn]] void refuse(std::string_view found, std::string_view expected,
                           ErrorCode error_code = ErrorCode::invalid) const {
    document_->refuse(*item_, found, expected, error_code);
  }

 private:
  friend class XdmfData;
  template <class Stored>
  Array<Stored> numbers_in_text() const;

  const XdmfDocument* document_ = nullptr;
  const XmlElement* item_ = nullptr;
  formats::ElementType type_ = formats::ElementType::F32;
  std::uint64_t count_ = 0;                 ///< of the part, if there is one
  std::vector<std::uint64_t> whole_shape_;  ///< of the source
  std::optional<Hyperslab> part_;
  bool keeps_digits_ = false;  ///< text without a Precision: doubles are not rounded to type()
  std::string_view text_;      ///< either this, or binary, or an HDF5 data set
  std::shared_ptr<const ForeignFile> binary_;
  std::uint64_t first_byte_ = 0;
  bool big_endian_ = false;
  std::optional<Hdf5DataSet> data_set_;
};

/// Opens the DataItems of a document, and the files that they name.
class XdmfData {
 public:
  explicit XdmfData(const XdmfDocument& document) : document_(document) {}

  /// Refuses sizes that the bytes cannot hold, other types of numbers, compressed binary data, and
  /// items of other kinds than Uniform and HyperSlab.
  XdmfNumbers open(const XmlElement& item);

  /// The only DataItem of an element; refuses none, and several.
  XdmfNumbers open_only(const XmlElement& parent);

 private:
  XdmfNumbers open_whole(const XmlElement& item, const std::vector<std::uint64_t>* shape);
  XdmfNumbers open_part(const XmlElement& item);
  void open_text(XdmfNumbers& numbers) const;
  void open_binary(XdmfNumbers& numbers);
  void open_hdf(XdmfNumbers& numbers, bool has_shape);

  const XdmfDocument& document_;
  std::map<std::filesystem::path, Hdf5File> hdf5_files_;
  std::map<std::filesystem::path, std::shared_ptr<const ForeignFile>> binary_files_;
};

}  // namespace rhoray::preprocess
