#include "preprocess/import/vtk/vtk_xml_stream.h"

#include <sys/resource.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include "formats/base/bytes.h"
#include "formats/base/error.h"
#include "formats/base/parallel.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/process/child_process.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

constexpr std::string_view spaces = " \t\r\n";
// larger blocks are left to VTK
constexpr std::uint64_t largest_block_bytes = std::uint64_t{64} << 20;
constexpr std::uint64_t plain_piece_bytes = std::uint64_t{1} << 18;

constexpr std::array<std::int8_t, 256> base64_digits = [] {
  std::array<std::int8_t, 256> digits{};
  digits.fill(-1);
  std::int8_t value = 0;
  for (const char letter : std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"))
    digits[static_cast<unsigned char>(letter)] = value++;
  return digits;
}();

/// Reads base64 piece by piece. Each group of four letters is decoded independently, so texts that
/// end with '=' may follow each other.
class Base64Reader {
 public:
  explicit Base64Reader(std::string_view text) : text_(text) {}

  /// False if the text ends too early, or is not base64.
  bool read(std::span<std::byte> bytes) {
    std::size_t filled = 0;
    for (;;) {
      while (kept_ > 0 && filled < bytes.size()) {
        bytes[filled++] = static_cast<std::byte>(four_ >> 16 & 0xff);
        four_ <<= 8;
        --kept_;
      }
      if (filled == bytes.size()) return true;
      if (!next_four()) return false;
    }
  }

 private:
  bool next_four() {
    four_ = 0;
    kept_ = 3;
    for (int i = 0; i < 4; ++i) {
      while (at_ < text_.size() && spaces.find(text_[at_]) != spaces.npos) ++at_;
      if (at_ == text_.size()) return false;
      const char letter = text_[at_++];
      const int digit = base64_digits[static_cast<unsigned char>(letter)];
      if (letter == '=' && i >= 2)
        --kept_;
      else if (digit < 0 || kept_ != 3)
        return false;
      four_ = four_ << 6 | static_cast<std::uint32_t>(digit < 0 ? 0 : digit);
    }
    return true;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::uint32_t four_ = 0;
  int kept_ = 0;  ///< bytes of four_ not yet returned
};

std::optional<ElementType> type_named(std::string_view name) {
  constexpr std::pair<std::string_view, ElementType> types[] = {
      {"Int8", ElementType::I8},     {"UInt8", ElementType::U8},   {"Int16", ElementType::I16},
      {"UInt16", ElementType::U16},  {"Int32", ElementType::I32},  {"UInt32", ElementType::U32},
      {"Int64", ElementType::I64},   {"UInt64", ElementType::U64}, {"Float32", ElementType::F32},
      {"Float64", ElementType::F64},
  };
  for (const auto& [known, type] : types)
    if (known == name) return type;
  return std::nullopt;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(spaces), text.size());
  const std::size_t end = text.find_last_not_of(spaces) + 1;
  return text.substr(begin, end - std::min(begin, end));
}

std::string unit_of(const XmlElement& array) {
  for (const XmlElement& child : array.children)
    if (child.name == "InformationKey" && child.attribute("name") == "UNITS_LABEL")
      return std::string(trimmed(child.content));
  return {};
}

/// Number of decompression threads: as many as cores, but fewer under a memory cap, because each
/// thread takes a share of it.
unsigned unpacking_threads() {
  constexpr rlim_t share = rlim_t{64} << 20;
  rlimit limit{};
  if (::getrlimit(RLIMIT_DATA, &limit) != 0)
    throw Error(ErrorCode::internal, concat("the system does not tell the limit RLIMIT_DATA: ", std::strerror(errno)));
  if (limit.rlim_cur == RLIM_INFINITY) return 0;
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  return static_cast<unsigned>(std::clamp<rlim_t>(limit.rlim_cur / share, 1, cores));
}

/// Casts numbers as C++ does, but floats via integers, so that nothing is undefined.
template <class Number, class T>
Number cast(T value) {
  if constexpr (std::is_floating_point_v<T> && std::is_integral_v<Number>)
    return value >= 0 && value < static_cast<T>(1ULL << 53) ? static_cast<Number>(value)
                                                            : std::numeric_limits<Number>::max();
  else
    return static_cast<Number>(value);
}

}  // namespace

/// Bytes from the start of an array: plain, or in base64.
struct VtkXmlStream::Source {
  std::span<const std::byte> plain;
  std::optional<Base64Reader> base64{};

  bool read(std::span<std::byte> bytes) {
    if (base64) return base64->read(bytes);
    if (bytes.size() > plain.size()) return false;
    std::copy_n(plain.begin(), bytes.size(), bytes.begin());
    plain = plain.subspan(bytes.size());
    return true;
  }
};

std::optional<VtkXmlStream> VtkXmlStream::open(const ForeignFile& file) {
  std::optional<XmlElement> root = xml_outline(file.text(), "AppendedData");
  if (!root || root->name != "VTKFile" || root->child(root->attribute("type")) == nullptr) return std::nullopt;
  VtkXmlStream stream(file, *std::move(root));
  if (!stream.take_encoding()) return std::nullopt;
  return stream;
}

bool VtkXmlStream::take_encoding() {
  const auto one_of = [](std::string_view word, std::string_view first, std::string_view second, bool& is_second) {
    is_second = word == second;
    return is_second || word == first || word.empty();
  };
  bool is_wide = false;
  if (!one_of(root_.attribute("byte_order"), "LittleEndian", "BigEndian", big_endian_) ||
      !one_of(root_.attribute("header_type"), "UInt32", "UInt64", is_wide) ||
      !one_of(root_.attribute("compressor"), "", "vtkZLibDataCompressor", is_packed_))
    return false;
  header_bytes_ = is_wide ? 8 : 4;
  const XmlElement* appended = root_.child("AppendedData");
  if (appended == nullptr) return true;
  const std::size_t underscore = appended->content.find_first_not_of(spaces);
  if (underscore == std::string_view::npos || appended->content[underscore] != '_') return false;
  appended_ = appended->content.substr(underscore + 1);
  return one_of(appended->attribute("encoding"), "raw", "base64", appended_base64_);
}

std::optional<VtkXmlArray> VtkXmlStream::array(const XmlElement& element) const {
  VtkXmlArray array;
  const std::optional<ElementType> type = type_named(element.attribute("type"));
  const std::string_view count = element.attribute("NumberOfComponents");
  const std::optional<int> components = count.empty() ? std::optional(1) : parse_number<int>(count);
  if (element.name != "DataArray" || !type || !components || *components < 1 || *components > 1024 ||
      element.attributes.contains("TimeStep"))
    return std::nullopt;
  array.name = element.attribute("Name");
  array.unit = unit_of(element);
  array.type = *type;
  array.component_count = *components;
  array.content = element.content;
  const std::string_view format = element.attribute("format");
  if (format == "ascii") return array;
  if (format == "binary") {
    array.format = VtkXmlArray::Format::base64;
    return array;
  }
  const std::optional<std::uint64_t> offset = parse_number<std::uint64_t>(trimmed(element.attribute("offset")));
  if (format != "appended" || !offset || *offset > appended_.size()) return std::nullopt;
  array.format = VtkXmlArray::Format::appended;
  array.appended_byte = *offset;
  return array;
}

std::optional<std::vector<VtkXmlArray>> VtkXmlStream::arrays_in(const XmlElement* data) const {
  std::vector<VtkXmlArray> arrays;
  if (data == nullptr) return arrays;
  for (const XmlElement& element : data->children) {
    std::optional<VtkXmlArray> found = array(element);
    if (!found || found->name.empty()) return std::nullopt;
    arrays.push_back(*std::move(found));
  }
  return arrays;
}

void VtkXmlStream::refuse(const VtkXmlArray& array, std::string_view found, std::string_view expected) const {
  refuse_input(file_->path(), concat("array '", array.name, "'"), found, expected);
}

VtkXmlStream::Source VtkXmlStream::source_of(const VtkXmlArray& array) const {
  if (array.format == VtkXmlArray::Format::base64) return {.plain = {}, .base64 = Base64Reader(array.content)};
  const std::string_view rest = appended_.substr(array.appended_byte);
  if (appended_base64_) return {.plain = {}, .base64 = Base64Reader(rest)};
  return {.plain = std::as_bytes(std::span(rest)), .base64 = {}};
}

std::uint64_t VtkXmlStream::header_number(const VtkXmlArray& array, Source& source) const {
  std::array<std::byte, 8> raw{};
  if (!source.read(std::span(raw).first(header_bytes_)))
    refuse(array, "the end of the data", "the numbers that tell its size");
  make_native(std::span(raw).first(header_bytes_), header_bytes_, big_endian_);
  std::uint64_t wide = 0;
  std::uint32_t narrow = 0;
  std::memcpy(&wide, raw.data(), sizeof wide);
  std::memcpy(&narrow, raw.data(), sizeof narrow);
  return header_bytes_ == 8 ? wide : narrow;
}

void VtkXmlStream::check_count(const VtkXmlArray& array, std::uint64_t count) const {
  const std::size_t size = formats::element_bytes(array.type);
  const bool is_text = array.format == VtkXmlArray::Format::text;
  const std::uint64_t there =
      array.format == VtkXmlArray::Format::appended ? appended_.size() - array.appended_byte : array.content.size();
  constexpr std::uint64_t tightest = 1040;  // of zlib, as in check_packed_size
  const std::uint64_t most = is_text ? there / 2 + 1 : (is_packed_ ? there * tightest : there) / size;
  if (count > most) refuse(array, concat(there, " bytes"), concat(count, " numbers"));
}

void VtkXmlStream::count_progress(std::uint64_t bytes) const {
  report_worker_progress(bytes_done_->fetch_add(bytes) + bytes, file_->bytes().size());
}

/// Calls act(first byte, bytes) for pieces that together are the first wanted_bytes of the array,
/// from several threads. Pieces keep the file's byte order; no number is split between two pieces.
template <class Act>
void VtkXmlStream::for_each_piece(const VtkXmlArray& array, std::uint64_t wanted_bytes, const Act& act) const {
  if (is_packed_)
    for_each_packed_piece(array, source_of(array), wanted_bytes, act);
  else
    for_each_plain_piece(array, source_of(array), wanted_bytes, act);
}

template <class Act>
void VtkXmlStream::for_each_plain_piece(const VtkXmlArray& array, Source source, std::uint64_t wanted_bytes,
                                        const Act& act) const {
  const std::uint64_t held = header_number(array, source);
  if (held < wanted_bytes) refuse(array, concat(held, " bytes"), concat(wanted_bytes));
  const std::uint64_t pieces = (wanted_bytes + plain_piece_bytes - 1) / plain_piece_bytes;
  const auto size_of = [&](std::uint64_t piece) {
    return std::min(plain_piece_bytes, wanted_bytes - piece * plain_piece_bytes);
  };
  const auto refuse_end = [&] {
    refuse(array, "the end of the data, or what is no base64", concat(wanted_bytes, " bytes"));
  };
  if (!source.base64) {
    if (source.plain.size() < wanted_bytes) refuse_end();
    for_each_range(pieces, 4, unpacking_threads(), [&](std::uint64_t first, std::uint64_t last) {
      for (std::uint64_t piece = first; piece < last; ++piece) {
        act(piece * plain_piece_bytes, source.plain.subspan(piece * plain_piece_bytes, size_of(piece)));
        count_progress(size_of(piece));
      }
    });
    return;
  }
  std::vector<std::byte> buffer(std::min(plain_piece_bytes, wanted_bytes));
  for (std::uint64_t piece = 0; piece < pieces; ++piece) {
    const std::span<std::byte> bytes = std::span(buffer).first(size_of(piece));
    if (!source.read(bytes)) refuse_end();
    act(piece * plain_piece_bytes, bytes);
    count_progress(bytes.size() / 3 * 4);
  }
}

/// The blocks of a compressed array: size and position of each.
class VtkXmlStream::Blocks {
 public:
  Blocks(const VtkXmlStream& stream, const VtkXmlArray& array, Source& source, std::uint64_t wanted_bytes)
      : stream_(stream), array_(array) {
    const std::uint64_t count = stream.header_number(array, source);
    block_bytes_ = stream.header_number(array, source);
    const std::uint64_t last = stream.header_number(array, source);
    last_bytes_ = last == 0 ? block_bytes_ : last;
    // a block has its size in the header, and at least one byte
    const std::uint64_t most = stream.file_->bytes().size();
    const std::optional<std::uint64_t> whole = checked_product({count, block_bytes_});
    if (count > most || !whole || last_bytes_ > block_bytes_ ||
        (count == 0 ? 0 : *whole - block_bytes_ + last_bytes_) < wanted_bytes)
      stream.refuse(array, concat(count, " blocks of ", block_bytes_, " bytes, the last of ", last_bytes_),
                    concat(wanted_bytes, " bytes"));
    if (count > 0 && (block_bytes_ > largest_block_bytes || block_bytes_ % formats::element_bytes(array.type) != 0))
      stream.refuse(array, concat("blocks of ", block_bytes_, " bytes"),
                    concat("up to ", largest_block_bytes, ", of whole numbers"));
    ends_.resize(count);
    std::uint64_t end = 0;
    for (std::uint64_t& block_end : ends_) {
      const std::uint64_t bytes = stream.header_number(array, source);
      if (bytes > most - std::min(most, end)) stream.refuse(array, "a block beyond the file's end", "blocks within it");
      block_end = end += bytes;
    }
  }

  std::uint64_t count() const { return ends_.size(); }
  std::uint64_t begin(std::uint64_t block) const { return block == 0 ? 0 : ends_[block - 1]; }
  std::uint64_t packed_bytes(std::uint64_t block) const { return ends_[block] - begin(block); }
  std::uint64_t total_packed_bytes() const { return ends_.empty() ? 0 : ends_.back(); }
  std::uint64_t bytes(std::uint64_t block) const { return block + 1 == count() ? last_bytes_ : block_bytes_; }
  std::uint64_t first_byte(std::uint64_t block) const { return block * block_bytes_; }

  std::span<const std::byte> unpack(std::uint64_t block, std::span<const std::byte> packed,
                                    std::vector<std::byte>& buffer) const {
    buffer.resize(block_bytes_);
    auto size = static_cast<uLongf>(buffer.size());
    const int outcome = ::uncompress(reinterpret_cast<Bytef*>(buffer.data()), &size,
                                     reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
    if (outcome == Z_MEM_ERROR) throw std::bad_alloc();
    if (outcome != Z_OK || size != bytes(block))
      stream_.refuse(array_, concat("a damaged block ", block), concat("zlib data of ", bytes(block), " bytes"));
    return std::span(buffer).first(size);
  }

 private:
  const VtkXmlStream& stream_;
  const VtkXmlArray& array_;
  std::uint64_t block_bytes_ = 0, last_bytes_ = 0;
  Array<std::uint64_t> ends_;  ///< end of each block, in compressed bytes
};

template <class Act>
void VtkXmlStream::for_each_packed_piece(const VtkXmlArray& array, Source source, std::uint64_t wanted_bytes,
                                         const Act& act) const {
  const Blocks blocks(*this, array, source, wanted_bytes);
  const auto use = [&](std::uint64_t block, std::span<const std::byte> packed, std::vector<std::byte>& buffer) {
    const std::uint64_t first = blocks.first_byte(block);
    if (first >= wanted_bytes) return;
    const std::span<const std::byte> bytes = blocks.unpack(block, packed, buffer);
    act(first, bytes.first(std::min<std::uint64_t>(bytes.size(), wanted_bytes - first)));
    count_progress(packed.size());
  };
  const auto refuse_end = [&] { refuse(array, "the end of the data, or what is no base64", "all of its blocks"); };
  if (!source.base64) {
    if (source.plain.size() < blocks.total_packed_bytes()) refuse_end();
    for_each_range(blocks.count(), 16, unpacking_threads(), [&](std::uint64_t first, std::uint64_t last) {
      std::vector<std::byte> buffer;
      for (std::uint64_t block = first; block < last; ++block)
        use(block, source.plain.subspan(blocks.begin(block), blocks.packed_bytes(block)), buffer);
    });
    return;
  }
  std::vector<std::byte> packed, buffer;
  for (std::uint64_t block = 0; block < blocks.count(); ++block) {
    packed.resize(blocks.packed_bytes(block));
    if (!source.read(packed)) refuse_end();
    use(block, packed, buffer);
  }
}

namespace {

/// Calls take(number) for `count` numbers of a text; returns how many were found.
template <class T, class Take>
std::uint64_t read_text(std::string_view text, std::uint64_t count, const Take& take) {
  std::uint64_t found = 0;
  for (std::size_t at = 0; found < count; ++found) {
    at = text.find_first_not_of(spaces, at);
    if (at == text.npos) break;
    const std::size_t end = std::min(text.find_first_of(spaces, at), text.size());
    const std::optional<T> number = parse_number<T>(text.substr(at, end - at));
    if (!number) break;
    take(found, *number);
    at = end;
  }
  return found;
}

}  // namespace

template <class Number>
void VtkXmlStream::read(const VtkXmlArray& array, std::span<Number> numbers) const {
  if (numbers.empty()) return;
  check_count(array, numbers.size());
  formats::with_element_type(array.type, [&]<class T>(T) {
    if (array.format == VtkXmlArray::Format::text) {
      const std::uint64_t found = read_text<T>(array.content, numbers.size(),
                                               [&](std::uint64_t at, T value) { numbers[at] = cast<Number>(value); });
      if (found != numbers.size()) refuse(array, concat(found, " numbers"), concat(numbers.size()));
      return;
    }
    for_each_piece(array, numbers.size() * sizeof(T), [&](std::uint64_t first_byte, std::span<const std::byte> bytes) {
      Number* to = numbers.data() + first_byte / sizeof(T);
      const bool swaps = !is_native(array.type, big_endian_);
      for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
        std::array<std::byte, sizeof(T)> raw;
        std::memcpy(raw.data(), bytes.data() + at, sizeof(T));
        if (swaps) std::reverse(raw.begin(), raw.end());
        *to++ = cast<Number>(std::bit_cast<T>(raw));
      }
    });
  });
}

template void VtkXmlStream::read(const VtkXmlArray&, std::span<double>) const;
template void VtkXmlStream::read(const VtkXmlArray&, std::span<std::uint64_t>) const;
template void VtkXmlStream::read(const VtkXmlArray&, std::span<std::uint8_t>) const;

void VtkXmlStream::read_bytes(const VtkXmlArray& array, std::span<std::byte> bytes) const {
  const std::size_t size = formats::element_bytes(array.type);
  check_count(array, bytes.size() / size);
  if (array.format == VtkXmlArray::Format::text) {
    formats::with_element_type(array.type, [&]<class T>(T) {
      const std::uint64_t found = read_text<T>(array.content, bytes.size() / sizeof(T), [&](std::uint64_t at, T value) {
        std::memcpy(bytes.data() + at * sizeof(T), &value, sizeof(T));
      });
      if (found != bytes.size() / sizeof(T)) refuse(array, concat(found, " numbers"), concat(bytes.size() / sizeof(T)));
    });
    return;
  }
  for_each_piece(array, bytes.size(), [&](std::uint64_t first_byte, std::span<const std::byte> piece) {
    const std::span<std::byte> to = bytes.subspan(first_byte, piece.size());
    std::copy(piece.begin(), piece.end(), to.begin());
    make_native(to, size, big_endian_);
  });
}

}  // namespace rhoray::preprocess
