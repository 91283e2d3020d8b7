#include "preprocess/import/vtk/vtk_xml_stream.h"

#include <lz4.h>
#include <lzma.h>
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
#include "preprocess/import/reading/text_reading.h"
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

constexpr std::pair<std::string_view, ElementType> types[] = {
    {"Int8", ElementType::I8},     {"UInt8", ElementType::U8},   {"Int16", ElementType::I16},
    {"UInt16", ElementType::U16},  {"Int32", ElementType::I32},  {"UInt32", ElementType::U32},
    {"Int64", ElementType::I64},   {"UInt64", ElementType::U64}, {"Float32", ElementType::F32},
    {"Float64", ElementType::F64},
};

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

/// Casts numbers as C++ does, but so that nothing is undefined and no large number becomes a small
/// one.
template <class Number, class T>
Number cast(T value) {
  if constexpr (std::is_floating_point_v<T> && std::is_integral_v<Number>)
    return value >= 0 && value < static_cast<T>(1ULL << 53) ? static_cast<Number>(value)
                                                            : std::numeric_limits<Number>::max();
  else if constexpr (std::is_integral_v<T> && sizeof(Number) < sizeof(T))
    return std::in_range<Number>(value) ? static_cast<Number>(value) : std::numeric_limits<Number>::max();
  else
    return static_cast<Number>(value);
}

/// Unpacks data of known size. False if they are damaged or have another size.
bool unpack_lz4(std::span<const std::byte> packed, std::span<std::byte> bytes) {
  return packed.size() <= LZ4_MAX_INPUT_SIZE &&
         ::LZ4_decompress_safe(reinterpret_cast<const char*>(packed.data()), reinterpret_cast<char*>(bytes.data()),
                               static_cast<int>(packed.size()),
                               static_cast<int>(bytes.size())) == static_cast<int>(bytes.size());
}

bool unpack_lzma(std::span<const std::byte> packed, std::span<std::byte> bytes) {
  std::uint64_t most_memory = std::uint64_t{256} << 20;  // the strongest preset needs 65 MiB
  std::size_t read = 0, written = 0;
  const lzma_ret outcome =
      ::lzma_stream_buffer_decode(&most_memory, 0, nullptr, reinterpret_cast<const std::uint8_t*>(packed.data()), &read,
                                  packed.size(), reinterpret_cast<std::uint8_t*>(bytes.data()), &written, bytes.size());
  if (outcome == LZMA_MEM_ERROR) throw std::bad_alloc();
  return outcome == LZMA_OK && written == bytes.size();
}

bool unpack_zlib(std::span<const std::byte> packed, std::span<std::byte> bytes) {
  auto size = static_cast<uLongf>(bytes.size());
  const int outcome = ::uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                                   reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
  if (outcome == Z_MEM_ERROR) throw std::bad_alloc();
  return outcome == Z_OK && size == bytes.size();
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

VtkXmlStream::VtkXmlStream(const ForeignFile& file, std::string_view type) : file_(&file) {
  if (file.text().find("<VTKFile") == std::string_view::npos) refuse("byte 0", "no element VTKFile", "a VTK XML file");
  std::size_t end = 0;
  std::optional<XmlElement> root = xml_outline(file.text(), "AppendedData", end);
  if (!root) refuse(concat("byte ", end), "the end of XML that is well-formed", "elements that end");
  root_ = *std::move(root);
  const std::string_view found = root_.attribute("type");
  if (root_.name != "VTKFile") refuse("root element", in_quotes(root_.name), "VTKFile");
  if (found != type) refuse("element VTKFile", in_quotes(found), type, ErrorCode::unsupported);
  if (root_.child(type) == nullptr) refuse("element VTKFile", concat("no element ", type), "one");
  take_version();
  take_encoding();
}

void VtkXmlStream::take_version() {
  const std::string_view version = root_.attribute("version");
  const std::size_t point = std::min(version.find('.'), version.size());
  major_ = parse_number<int>(version.substr(0, point)).value_or(0);
  minor_ = parse_number<int>(version.substr(std::min(point + 1, version.size()))).value_or(0);
}

void VtkXmlStream::take_encoding() {
  /// The position of an attribute's value among `words`; 0 without a value.
  const auto choice = [&](const XmlElement& element, std::string_view name,
                          std::initializer_list<std::string_view> words) -> std::size_t {
    const std::string_view word = element.attribute(name);
    const auto* const found = std::find(words.begin(), words.end(), word);
    if (word.empty()) return 0;
    if (found == words.end()) {
      std::string known;
      for (const std::string_view other : words)
        if (!other.empty()) known += concat(known.empty() ? "" : " or ", other);
      refuse(concat("attribute ", name), in_quotes(word), known, ErrorCode::unsupported);
    }
    return static_cast<std::size_t>(found - words.begin());
  };
  big_endian_ = choice(root_, "byte_order", {"LittleEndian", "BigEndian"}) == 1;
  header_bytes_ = choice(root_, "header_type", {"UInt32", "UInt64"}) == 1 ? 8 : 4;
  packing_ = static_cast<Packing>(
      choice(root_, "compressor", {"", "vtkZLibDataCompressor", "vtkLZ4DataCompressor", "vtkLZMADataCompressor"}));
  const XmlElement* appended = root_.child("AppendedData");
  if (appended == nullptr) return;
  const std::size_t underscore = appended->content.find_first_not_of(spaces);
  if (underscore == std::string_view::npos || appended->content[underscore] != '_')
    refuse("element AppendedData", "another beginning", "an underscore");
  appended_ = appended->content.substr(underscore + 1);
  appended_base64_ = choice(*appended, "encoding", {"raw", "base64"}) == 1;
}

void VtkXmlStream::check_attribute(std::string_view name, std::uint64_t count) const {
  // No compressor of VTK stores a point, cell or sample in less than 1/4096 byte; ten times that to
  // be safe.
  constexpr std::uint64_t most_per_byte = 40960;
  if (const std::size_t bytes = file_->bytes().size(); count / most_per_byte > bytes)
    refuse_attribute(name, concat(count, " in ", bytes, " bytes"), "a number that the file can hold");
}

std::uint64_t VtkXmlStream::count_in(const XmlElement& element, std::string_view name) const {
  const auto count = parse_number<std::uint64_t>(element.attribute(name));
  if (!count) refuse_attribute(name, in_quotes(element.attribute(name)), "a number");
  check_attribute(name, *count);
  return *count;
}

/// Nothing for an array that does not hold numbers.
std::optional<VtkXmlArray> VtkXmlStream::array(const XmlElement& element) const {
  VtkXmlArray array;
  array.name = element.attribute("Name");
  const std::optional<ElementType> type = find_in(types, element.attribute("type"));
  if (!type) return std::nullopt;
  const std::string_view count = element.attribute("NumberOfComponents");
  const std::optional<int> components = count.empty() ? std::optional(1) : parse_number<int>(count);
  if (!components || *components < 1) refuse_attribute("NumberOfComponents", in_quotes(count), "at least 1");
  array.unit = unit_of(element);
  array.type = *type;
  array.component_count = *components;
  array.content = element.content;
  const std::string_view format = element.attribute("format");
  if (format == "binary") array.format = VtkXmlArray::Format::base64;
  if (format != "appended") return array;
  const std::optional<std::uint64_t> offset = parse_number<std::uint64_t>(trimmed(element.attribute("offset")));
  if (!offset || *offset > appended_.size())
    refuse(array, concat("offset ", in_quotes(element.attribute("offset"))),
           concat("a place in ", appended_.size(), " bytes of appended data"));
  array.format = VtkXmlArray::Format::appended;
  array.appended_byte = *offset;
  return array;
}

std::vector<VtkXmlArray> VtkXmlStream::arrays_in(const XmlElement* data, std::vector<std::string>* left_out) const {
  std::vector<VtkXmlArray> arrays;
  if (data == nullptr) return arrays;
  for (const XmlElement& element : data->children) {
    const std::string_view steps = element.attribute("TimeStep");
    const bool is_later = !steps.empty() && parse_number<int>(steps.substr(0, steps.find(' '))) != 0;
    if ((element.name != "DataArray" && element.name != "Array") || is_later) continue;
    if (std::optional<VtkXmlArray> found = array(element))
      arrays.push_back(*std::move(found));
    else if (left_out != nullptr)
      left_out->push_back(concat("array '", element.attribute("Name"), "' left out: it does not hold numbers"));
  }
  return arrays;
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

std::uint64_t VtkXmlStream::checked_count(const VtkXmlArray& array, std::uint64_t owners) const {
  const auto components = static_cast<std::uint64_t>(array.component_count);
  const std::optional<std::uint64_t> count = checked_product({owners, components});
  const std::size_t size = formats::element_bytes(array.type);
  const bool is_text = array.format == VtkXmlArray::Format::text;
  const std::uint64_t there =
      array.format == VtkXmlArray::Format::appended ? appended_.size() - array.appended_byte : array.content.size();
  // of zlib, as in check_packed_size; of LZMA
  const std::uint64_t tightest = packing_ == Packing::none ? 1 : packing_ == Packing::lzma ? 8192 : 1040;
  const std::uint64_t most = is_text ? there / 2 + 1 : there * tightest / size;
  if (!count || *count > most) refuse(array, concat(there, " bytes"), concat(owners, " x ", components, " numbers"));
  return *count;
}

void VtkXmlStream::count_progress(std::uint64_t bytes) const {
  report_worker_progress(bytes_done_->fetch_add(bytes) + bytes, file_->bytes().size());
}

/// Calls act(first byte, bytes) for pieces that together are the first wanted_bytes of the array,
/// from several threads. Pieces keep the file's byte order; no number is split between two pieces.
template <class Act>
void VtkXmlStream::for_each_piece(const VtkXmlArray& array, std::uint64_t wanted_bytes, const Act& act) const {
  if (packing_ != Packing::none)
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
    const std::span<std::byte> unpacked = std::span(buffer).first(bytes(block));
    const auto unpack = stream_.packing_ == Packing::lz4    ? unpack_lz4
                        : stream_.packing_ == Packing::lzma ? unpack_lzma
                                                            : unpack_zlib;
    if (!unpack(packed, unpacked))
      stream_.refuse(array_, concat("a damaged block ", block), concat("packed data of ", bytes(block), " bytes"));
    return unpacked;
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

/// Calls take(number) for `count` numbers of a text, which are removed from it; returns how many
/// were found.
template <class T, class Take>
std::uint64_t read_text(std::string_view& text, std::uint64_t count, const Take& take) {
  for (std::uint64_t found = 0; found < count; ++found) {
    const std::optional<T> number = parse_number<T>(take_word(text, spaces));
    if (!number) return found;
    take(found, *number);
  }
  return count;
}

}  // namespace

template <class Number>
void VtkXmlStream::read(const VtkXmlArray& array, std::span<Number> numbers) const {
  constexpr bool as_bytes = std::is_same_v<Number, std::byte>;
  formats::with_element_type(array.type, [&]<class T>(T) {
    const std::uint64_t count = as_bytes ? numbers.size() / sizeof(T) : numbers.size();
    const auto put = [&](std::uint64_t at, T value) {
      if constexpr (as_bytes)
        std::memcpy(numbers.data() + at * sizeof(T), &value, sizeof(T));
      else
        numbers[at] = cast<Number>(value);
    };
    if (array.format == VtkXmlArray::Format::text) {
      std::string_view text = array.content;
      const std::uint64_t found = read_text<T>(text, count, put);
      if (found != count) refuse(array, concat(found, " numbers"), concat(count));
      std::uint64_t rest = 0;
      while (!take_word(text, spaces).empty()) ++rest;
      if (rest > 0)
        notes_->push_back(concat("array '", array.name, "': ", count_text(rest, "word", "words"), " after its numbers ",
                                 rest == 1 ? "was" : "were", " left out"));
      return;
    }
    if (count == 0) return;
    const bool swaps = !is_native(array.type, big_endian_);
    for_each_piece(array, count * sizeof(T), [&](std::uint64_t first_byte, std::span<const std::byte> bytes) {
      if (as_bytes && !swaps) {
        std::memcpy(numbers.data() + first_byte, bytes.data(), bytes.size());
        return;
      }
      for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
        std::array<std::byte, sizeof(T)> raw;
        std::memcpy(raw.data(), bytes.data() + at, sizeof(T));
        if (swaps) std::reverse(raw.begin(), raw.end());
        put((first_byte + at) / sizeof(T), std::bit_cast<T>(raw));
      }
    });
  });
}

template void VtkXmlStream::read(const VtkXmlArray&, std::span<double>) const;
template void VtkXmlStream::read(const VtkXmlArray&, std::span<std::uint64_t>) const;
template void VtkXmlStream::read(const VtkXmlArray&, std::span<std::uint8_t>) const;
template void VtkXmlStream::read(const VtkXmlArray&, std::span<std::byte>) const;

}  // namespace rhoray::preprocess
