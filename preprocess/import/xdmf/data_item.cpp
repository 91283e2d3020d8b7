#include "preprocess/import/xdmf/data_item.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "formats/base/bytes.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {

using formats::ElementType;

namespace {

using Sizes = std::vector<std::uint64_t>;

/// The product of sizes; the largest number when it does not fit, as sizes of a data set may not.
std::uint64_t product_of(const Sizes& sizes) {
  std::optional<std::uint64_t> product = 1;
  for (const std::uint64_t size : sizes) product = product ? checked_product({*product, size}) : std::nullopt;
  return product.value_or(std::numeric_limits<std::uint64_t>::max());
}

/// Refuses more bytes than a data set stores.
void check_stored_bytes(const XdmfNumbers& numbers, const Hdf5DataSet& data_set) {
  const auto bytes = checked_product({numbers.count(), formats::element_bytes(numbers.type())});
  if (!bytes) numbers.refuse(concat(numbers.count(), " numbers"), "a size that fits in memory");
  data_set.check_bytes(*bytes);
}

/// A word for numbers, how many bytes each has, and our type.
struct NumberWord {
  std::string_view word;
  std::uint64_t bytes;
  ElementType type;
};
constexpr NumberWord number_words[] = {
    {"float", 4, ElementType::F32}, {"float", 8, ElementType::F64}, {"double", 8, ElementType::F64},
    {"int", 4, ElementType::I32},   {"int", 1, ElementType::I8},    {"int", 2, ElementType::I16},
    {"int", 8, ElementType::I64},   {"uint", 4, ElementType::U32},  {"uint", 1, ElementType::U8},
    {"uint", 2, ElementType::U16},  {"uint", 8, ElementType::U64},  {"char", 1, ElementType::I8},
    {"uchar", 1, ElementType::U8},  {"short", 2, ElementType::I16}, {"ushort", 2, ElementType::U16},
};

/// The declared type of numbers; of a word without a Precision, its first row.
ElementType declared_type(const XdmfDocument& document, const XmlElement& item) {
  std::string word = XdmfDocument::word(item, {"NumberType", "DataType"});
  const std::string_view precision = item.attribute("Precision");
  if (word.empty()) word = "float";
  if (word == "double" && precision == "4") word = "float";
  for (const NumberWord& row : number_words)
    if (row.word == word && (precision.empty() || parse_number<std::uint64_t>(precision) == row.bytes)) return row.type;
  document.refuse(item, concat("numbers ", in_quotes(word), " of ", in_quotes(precision), " bytes"),
                  "Float of 4 or 8, Int or UInt of 1, 2, 4 or 8, Char or UChar of 1", ErrorCode::unsupported);
}

/// Refuses a part that leaves an array of this shape.
void check_part(const XdmfDocument& document, const XmlElement& item, const Hyperslab& part, const Sizes& shape) {
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    const std::uint64_t start = part.start[axis], stride = part.stride[axis], count = part.count[axis];
    const bool is_inside =
        stride > 0 && count > 0 && start < shape[axis] && count - 1 <= (shape[axis] - 1 - start) / stride;
    if (!is_inside)
      document.refuse(item, concat(count, " from ", start, " on, ", stride, " apart, along axis ", axis),
                      concat("some of ", shape[axis]));
  }
}

/// Start, stride and count of each axis, one list after the other.
Hyperslab part_of(const XdmfNumbers& numbers) {
  constexpr std::uint64_t most = 3 * 32;  // axes of HDF5
  if (numbers.count() % 3 != 0 || numbers.count() == 0 || numbers.count() > most)
    numbers.refuse(concat(numbers.count(), " numbers"), "a start, a stride and a count for each axis");
  const Array<std::int64_t> all = numbers.read<std::int64_t>();
  const auto axes = static_cast<std::ptrdiff_t>(all.size() / 3);
  const auto take = [&](std::ptrdiff_t row) {
    Sizes sizes;
    for (auto number = all.begin() + row * axes; number != all.begin() + (row + 1) * axes; ++number) {
      if (*number < 0) numbers.refuse(concat(*number), "numbers from 0 on");
      sizes.push_back(static_cast<std::uint64_t>(*number));
    }
    return sizes;
  };
  return {.start = take(0), .stride = take(1), .count = take(2)};
}

/// The part after the name of a data set, as XDMF 3 writes it: START:STRIDE:COUNT:SHAPE.
Hyperslab part_in_text(const XdmfDocument& document, const XmlElement& item, std::string_view text, Sizes& shape) {
  std::array<Sizes, 4> lists;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    const std::size_t end = i + 1 < lists.size() ? text.find(':') : text.size();
    const std::string_view words = text.substr(0, end);
    text.remove_prefix(std::min(end == text.npos ? text.size() : end + 1, text.size()));
    for (std::size_t at = 0; (at = words.find_first_not_of(" \t\r\n", at)) != words.npos;) {
      const std::size_t last = std::min(words.find_first_of(" \t\r\n", at), words.size());
      const auto number = parse_number<std::uint64_t>(words.substr(at, last - at));
      if (!number) document.refuse(item, in_quotes(words.substr(at, last - at)), "a number");
      lists[i].push_back(*number);
      at = last;
    }
  }
  for (const Sizes& list : lists)
    if (list.empty() || list.size() != lists[3].size())
      document.refuse(item, "a part with other lists", "START:STRIDE:COUNT:SHAPE, a number for each axis in each");
  shape = lists[3];
  return {.start = lists[0], .stride = lists[1], .count = lists[2]};
}

/// Calls act(position in the part, position in the whole) for each number of a part.
template <class Act>
void for_each_in_part(const Sizes& shape, const Hyperslab& part, std::uint64_t count, const Act& act) {
  Sizes index(shape.size(), 0);
  for (std::uint64_t to = 0; to < count; ++to) {
    std::uint64_t from = 0;
    for (std::size_t axis = 0; axis < shape.size(); ++axis)
      from = from * shape[axis] + part.start[axis] + part.stride[axis] * index[axis];
    act(to, from);
    for (std::size_t axis = shape.size(); axis-- > 0;) {
      if (++index[axis] < part.count[axis]) break;
      index[axis] = 0;
    }
  }
}

}  // namespace

template <class Stored>
Array<Stored> XdmfNumbers::numbers_in_text() const {
  constexpr std::string_view spaces = " \t\r\n";
  Array<Stored> numbers(product_of(whole_shape_));
  std::size_t at = text_.find_first_not_of(spaces);
  for (std::uint64_t i = 0; i < numbers.size(); ++i) {
    if (at == text_.npos) refuse(concat(i, " numbers"), concat(numbers.size()));
    const std::size_t end = std::min(text_.find_first_of(spaces, at), text_.size());
    const std::optional<Stored> number = parse_number<Stored>(text_.substr(at, end - at));
    if (!number) refuse(in_quotes(text_.substr(at, end - at)), "a number of its type");
    numbers[i] = *number;
    at = text_.find_first_not_of(spaces, end);
  }
  if (at != text_.npos) refuse(concat("more than ", numbers.size(), " numbers"), "as many as Dimensions says");
  return numbers;
}

template <class T>
Array<T> XdmfNumbers::read() const {
  constexpr bool as_bytes = std::is_same_v<T, std::byte>;
  if (std::is_same_v<T, std::int64_t> && (type_ == ElementType::F32 || type_ == ElementType::F64))
    refuse("floating-point numbers", "integers");
  Array<T> result(as_bytes ? count_ * formats::element_bytes(type_) : count_);
  if (data_set_) {
    data_set_->read(std::span<T>(result), part_ ? &*part_ : nullptr);
    return result;
  }
  const auto take = [&](const auto& number_at) {
    const auto put = [&](std::uint64_t to, std::uint64_t from) {
      const auto number = number_at(from);
      if constexpr (as_bytes)
        std::memcpy(result.data() + to * sizeof number, &number, sizeof number);
      else
        result[to] = static_cast<T>(number);
    };
    if (part_) return for_each_in_part(whole_shape_, *part_, count_, put);
    for (std::uint64_t i = 0; i < count_; ++i) put(i, i);
  };
  if constexpr (!as_bytes)
    if (!binary_ && (keeps_digits_ || std::is_same_v<T, std::int64_t>)) {
      const Array<T> numbers = numbers_in_text<T>();
      take([&](std::uint64_t i) { return numbers[i]; });
      return result;
    }
  formats::with_element_type(type_, [&]<class Stored>(Stored) {
    if (!binary_) {
      const Array<Stored> numbers = numbers_in_text<Stored>();
      return take([&](std::uint64_t i) { return numbers[i]; });
    }
    const std::byte* const first = binary_->bytes().data() + first_byte_;
    const bool swaps = !is_native(type_, big_endian_);
    take([&](std::uint64_t i) {
      std::array<std::byte, sizeof(Stored)> raw;
      std::memcpy(raw.data(), first + i * sizeof(Stored), sizeof(Stored));
      if (swaps) std::reverse(raw.begin(), raw.end());
      return std::bit_cast<Stored>(raw);
    });
  });
  return result;
}

template Array<double> XdmfNumbers::read() const;
template Array<std::int64_t> XdmfNumbers::read() const;
template Array<std::byte> XdmfNumbers::read() const;

XdmfNumbers XdmfData::open_only(const XmlElement& parent) {
  const auto items = document_.children(parent, "DataItem");
  if (items.size() != 1) document_.refuse(parent, concat(items.size(), " elements DataItem"), "1");
  return open(*items.front());
}

XdmfNumbers XdmfData::open(const XmlElement& item) {
  const std::string kind = XdmfDocument::word(item, {"ItemType"});
  if (kind == "hyperslab") return open_part(item);
  if (!kind.empty() && kind != "uniform")
    document_.refuse(item, concat("a DataItem of the kind ", in_quotes(kind)), "Uniform or HyperSlab",
                     ErrorCode::unsupported);
  return open_whole(item, nullptr);
}

XdmfNumbers XdmfData::open_part(const XmlElement& item) {
  const auto items = document_.children(item, "DataItem");
  if (items.size() != 2)
    document_.refuse(item, concat(items.size(), " elements DataItem"), "2: the part, and the whole array");
  const Hyperslab part = part_of(open(*items[0]));
  const std::string kind = XdmfDocument::word(*items[1], {"ItemType"});
  const auto shape = document_.sizes(*items[1], "Dimensions");
  if (!shape || shape->size() != part.start.size() || (!kind.empty() && kind != "uniform"))
    document_.refuse(*items[1], concat(shape ? shape->size() : 0, " sizes in Dimensions"),
                     concat(part.start.size(), " of a Uniform array, as the HyperSlab has"));
  check_part(document_, item, part, *shape);
  XdmfNumbers numbers = open_whole(*items[1], &*shape);
  if (numbers.part_) document_.refuse(*items[1], "a part of a part", "a whole array", ErrorCode::unsupported);
  numbers.item_ = &item;
  numbers.count_ = product_of(part.count);
  numbers.part_ = part;
  if (numbers.data_set_) check_stored_bytes(numbers, *numbers.data_set_);
  const auto own = document_.sizes(item, "Dimensions");
  if (own && product_of(*own) != numbers.count_)
    document_.refuse(item, concat(product_of(*own), " numbers in Dimensions"),
                     concat(numbers.count_, ", as the HyperSlab selects"));
  return numbers;
}

/// @param shape  that the whole must have; null when only the count of its numbers matters
XdmfNumbers XdmfData::open_whole(const XmlElement& item, const Sizes* shape) {
  XdmfNumbers numbers;
  numbers.document_ = &document_;
  numbers.item_ = &item;
  numbers.text_ = document_.text(item);
  const auto declared = document_.sizes(item, "Dimensions");
  const std::string format = XdmfDocument::word(item, {"Format"});
  if (!declared && format != "hdf") document_.refuse(item, "no Dimensions", "the size of each axis");
  if (declared) numbers.whole_shape_ = *declared;
  numbers.count_ = product_of(numbers.whole_shape_);
  if (format == "hdf") {
    open_hdf(numbers, declared.has_value());
    if (shape == nullptr)
      check_stored_bytes(numbers, *numbers.data_set_);
    else if (numbers.data_set_->shape() != *shape)
      document_.refuse(item, "other Dimensions than the data set has", "the same");
    return numbers;
  }
  numbers.type_ = declared_type(document_, item);
  if (format == "binary")
    open_binary(numbers);
  else if (format.empty() || format == "xml")
    open_text(numbers);
  else
    document_.refuse(item, concat("the format ", in_quotes(format)), "XML, HDF or Binary", ErrorCode::unsupported);
  return numbers;
}

void XdmfData::open_text(XdmfNumbers& numbers) const {
  numbers.keeps_digits_ = numbers.type_ == ElementType::F32 && numbers.item_->attribute("Precision").empty();
  if (numbers.count_ > numbers.text_.size() / 2 + 1)
    numbers.refuse(concat(numbers.text_.size(), " bytes of text"), concat(numbers.count_, " numbers"));
}

void XdmfData::open_binary(XdmfNumbers& numbers) {
  const XmlElement& item = *numbers.item_;
  const std::string packing = XdmfDocument::word(item, {"Compression"}), order = XdmfDocument::word(item, {"Endian"});
  if (!packing.empty() && packing != "raw" && packing != "none")
    numbers.refuse(concat("the compression ", in_quotes(packing)), "Raw", ErrorCode::unsupported);
  if (!order.empty() && order != "native" && order != "little" && order != "big")
    numbers.refuse(concat("the byte order ", in_quotes(order)), "Little, Big or Native");
  numbers.big_endian_ = order == "big";
  const std::string_view seek = item.attribute("Seek");
  const auto first = seek.empty() ? std::optional<std::uint64_t>(0) : parse_number<std::uint64_t>(seek);
  if (!first) numbers.refuse(concat("Seek ", in_quotes(seek)), "a number of bytes");
  const std::filesystem::path path = document_.companion(item, numbers.text_);
  std::shared_ptr<const ForeignFile>& file = binary_files_[path];
  if (!file) file = std::make_shared<ForeignFile>(path);
  const auto wanted = checked_product({numbers.count_, formats::element_bytes(numbers.type_)});
  const std::uint64_t there = file->bytes().size();
  if (!wanted || *first > there || *wanted > there - *first)
    numbers.refuse(concat(there, " bytes in ", in_quotes(numbers.text_)),
                   concat(numbers.count_, " numbers behind the first ", *first, " bytes"));
  numbers.binary_ = file;
  numbers.first_byte_ = *first;
}

void XdmfData::open_hdf(XdmfNumbers& numbers, bool has_shape) {
  const XmlElement& item = *numbers.item_;
  const std::size_t bar = std::min(numbers.text_.find('|'), numbers.text_.size());
  const std::size_t colon = numbers.text_.substr(0, bar).find(':');
  if (colon == std::string_view::npos)
    numbers.refuse(in_quotes(numbers.text_), "a file and a data set, such as a.h5:/mesh/points");
  const std::filesystem::path path = document_.companion(item, numbers.text_.substr(0, colon));
  const auto name = without_entities(numbers.text_.substr(colon + 1, bar - colon - 1));
  if (!name || name->empty()) numbers.refuse(in_quotes(numbers.text_), "the name of a data set behind the colon");
  const Hdf5DataSet& data_set =
      numbers.data_set_.emplace(hdf5_files_.try_emplace(path, path).first->second.data_set(*name));
  numbers.type_ = data_set.type();
  std::uint64_t there = product_of(data_set.shape());
  if (bar < numbers.text_.size()) {
    Sizes shape;
    numbers.part_ = part_in_text(document_, item, numbers.text_.substr(bar + 1), shape);
    if (shape != data_set.shape()) numbers.refuse("a part of an array of other sizes", "the sizes of the data set");
    check_part(document_, item, *numbers.part_, shape);
    there = product_of(numbers.part_->count);
  }
  // Programs write flat arrays for tables, and the other way round: only the count matters.
  if (has_shape && there != numbers.count_)
    numbers.refuse(concat(numbers.count_, " numbers in Dimensions"), concat(there, ", as ", in_quotes(*name), " has"));
  numbers.count_ = there;
  numbers.whole_shape_ = data_set.shape();
}

}  // namespace rhoray::preprocess
