// Numeric arrays in MATLAB's MAT-files of version 5, plain or compressed by zlib (-v6, -v7). The
// first axis of an array is x. Source: MathWorks, "MAT-File Format", R2006b and later.

#include <algorithm>
#include <bit>
#include <cstring>

#include "formats/base/word_list.h"
#include "preprocess/import/reading/array_choice.h"
#include "preprocess/import/reading/byte_stream.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/samples.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
namespace fs = std::filesystem;

constexpr std::size_t header_bytes = 128;
constexpr std::uint32_t matrix_element = 14, compressed_element = 15;

/// Numbers of the types in which numbers are stored, and of the classes of arrays.
constexpr std::pair<std::uint32_t, ElementType> stored_types[] = {
    {1, ElementType::I8},   {2, ElementType::U8},  {3, ElementType::I16}, {4, ElementType::U16},
    {5, ElementType::I32},  {6, ElementType::U32}, {7, ElementType::F32}, {9, ElementType::F64},
    {12, ElementType::I64}, {13, ElementType::U64}};
constexpr std::pair<std::uint32_t, ElementType> classes[] = {
    {6, ElementType::F64},  {7, ElementType::F32},  {8, ElementType::I8},   {9, ElementType::U8},
    {10, ElementType::I16}, {11, ElementType::U16}, {12, ElementType::I32}, {13, ElementType::U32},
    {14, ElementType::I64}, {15, ElementType::U64}};

/// The tag before each part of the file. Up to 4 bytes may stand in the tag itself.
struct Tag {
  std::uint32_t type = 0, bytes = 0;
  bool is_small = false;
  std::array<std::byte, 4> small{};
};

/// An array with its content not yet read.
struct Variable {
  NamedShape array;
  std::uint32_t class_number = 0;
  bool is_complex = false;
  std::span<const std::byte> element;  ///< its whole element behind the tag
  bool is_packed = false;
};

/// Reads the parts of one element, one after the other.
class ElementReader {
 public:
  ElementReader(const fs::path& path, const Variable& variable, bool big_endian)
      : path_(path),
        big_endian_(big_endian),
        is_packed_(variable.is_packed),
        source_bytes_(variable.element.size()),
        stream_(path, variable.element, variable.is_packed) {
    if (!is_packed_) return;
    if (!stream_.is_packed()) refuse_input(path, "compressed element", "another beginning", "zlib data");
    if (const Tag inner = tag(); inner.type != matrix_element)
      refuse_input(path, "compressed element", concat("type ", inner.type), "an array");
  }

  Tag tag() {
    std::array<std::byte, 8> raw;
    stream_.read(raw, "tag");
    Tag tag;
    std::copy(raw.begin() + 4, raw.end(), tag.small.begin());
    make_native(raw, 4, big_endian_);
    std::memcpy(&tag.type, raw.data(), 4);
    std::memcpy(&tag.bytes, raw.data() + 4, 4);
    tag.is_small = tag.type >> 16 != 0;
    if (!tag.is_small) return tag;
    tag.bytes = tag.type >> 16;
    tag.type &= 0xffff;
    if (tag.bytes > tag.small.size()) refuse_input(path_, "tag", concat(tag.bytes, " bytes"), "at most 4");
    return tag;
  }

  /// The content of the part with this tag, and the bytes that fill it up to a multiple of 8.
  void content(const Tag& tag, std::span<std::byte> to) {
    if (tag.is_small) {
      std::copy_n(tag.small.begin(), to.size(), to.begin());
      return;
    }
    stream_.read(to, "array");
    stream_.drain((8 - to.size() % 8) % 8);
  }

  /// A part of few numbers.
  template <class T>
  std::vector<T> numbers(std::string_view what, std::size_t most) {
    const Tag found = tag();
    if (found.bytes % sizeof(T) != 0 || found.bytes > most * sizeof(T))
      refuse_input(path_, what, concat(found.bytes, " bytes"), concat("at most ", most * sizeof(T)));
    std::vector<T> result(found.bytes / sizeof(T));
    const auto bytes = std::as_writable_bytes(std::span(result));
    content(found, bytes);
    make_native(bytes, sizeof(T), big_endian_);
    return result;
  }

  /// Refuses a part that the element cannot hold.
  void check_size(std::uint64_t bytes) const {
    if (is_packed_)
      check_packed_size(path_, bytes, source_bytes_);
    else if (bytes > source_bytes_)
      refuse_input(path_, "array", concat(source_bytes_, " bytes"), concat(bytes));
  }

  /// Reads on to the end, where a compressed element has its checksum.
  void finish() { stream_.finish(); }

  bool big_endian() const { return big_endian_; }

 private:
  const fs::path& path_;
  bool big_endian_, is_packed_;
  std::size_t source_bytes_;
  ByteStream stream_;
};

/// Reads the header of an array. Returns false for objects and functions, which have no sizes.
bool read_head(ElementReader& reader, Variable& variable, const fs::path& path) {
  const auto flags = reader.numbers<std::uint32_t>("array flags", 2);
  if (flags.empty()) refuse_input(path, "array flags", "none", "two numbers");
  variable.class_number = flags[0] & 0xff;
  variable.is_complex = (flags[0] & 0x800) != 0;
  constexpr std::uint32_t last_class = 15;
  if (variable.class_number > last_class) return false;
  constexpr std::size_t most_axes = 32, longest_name = 4096;
  const auto sizes = reader.numbers<std::int32_t>("sizes of an array", most_axes);
  const auto name = reader.numbers<char>("name of an array", longest_name);
  variable.array = {std::string(name.begin(), name.end()), {sizes.begin(), sizes.end()}};
  return true;
}

/// Refuses other files, and says how to make one that is read. Returns the byte order.
bool is_big_endian(const ForeignFile& file) {
  const std::string_view text = file.text();
  const auto refuse = [&](std::string_view found) {
    throw Error(ErrorCode::unsupported,
                concat(file.path().string(), ", byte 0: found ", found, "; expected a MAT-file of version 5"),
                "save it in MATLAB with save(NAME, VARIABLE, '-v7')");
  };
  if (text.starts_with("MATLAB 7.3 MAT-file")) refuse("a MAT-file of version 7.3 (HDF5)");
  const std::string_view order = text.substr(std::min<std::size_t>(126, text.size())).substr(0, 2);
  if (!text.starts_with("MATLAB 5.0 MAT-file") || (order != "IM" && order != "MI")) refuse("another beginning");
  return order == "MI";
}

std::vector<Variable> variables_in(const ForeignFile& file, bool big_endian) {
  std::vector<Variable> variables;
  std::span<const std::byte> rest = file.bytes().subspan(header_bytes);
  while (!rest.empty()) {
    const Variable outer{.array = {}, .element = rest};
    const Tag tag = ElementReader(file.path(), outer, big_endian).tag();
    if (tag.bytes > rest.size() - 8)
      refuse_input(file.path(), concat("byte ", file.bytes().size() - rest.size()), concat(rest.size() - 8, " bytes"),
                   concat(tag.bytes, " bytes of an element"));
    Variable variable{.array = {}, .element = rest.subspan(8, tag.bytes), .is_packed = tag.type == compressed_element};
    rest = rest.subspan(8 + tag.bytes);
    if (tag.type != matrix_element && tag.type != compressed_element) continue;
    ElementReader reader(file.path(), variable, big_endian);
    if (read_head(reader, variable, file.path())) variables.push_back(std::move(variable));
  }
  return variables;
}

template <class To>
void convert(ElementType from, std::span<const std::byte> numbers, std::span<std::byte> to) {
  formats::with_element_type(from, [&]<class From>(From) {
    for (std::size_t i = 0; i < numbers.size() / sizeof(From); ++i) {
      From number;
      std::memcpy(&number, numbers.data() + i * sizeof(From), sizeof number);
      const auto value = static_cast<To>(number);
      std::memcpy(to.data() + i * sizeof(To), &value, sizeof value);
    }
  });
}

/// True if MATLAB may store numbers of a class so: it saves whole numbers in fewer bytes.
bool may_store(ElementType stored, ElementType type) {
  const auto is_real = [](ElementType t) { return t == ElementType::F32 || t == ElementType::F64; };
  if (is_real(stored) && !is_real(type)) return false;
  return stored == type || formats::element_bytes(stored) <= formats::element_bytes(type);
}

/// Reads the numbers, and brings them to the type of the array's class.
Array<std::byte> read_numbers(ElementReader& reader, ElementType type, std::uint64_t bytes, const fs::path& path) {
  const Tag tag = reader.tag();
  const std::optional<ElementType> stored = find_in(stored_types, tag.type);
  if (!stored || !may_store(*stored, type))
    refuse_input(path, "array", concat("numbers of type ", tag.type),
                 concat("numbers of ", formats::element_name(type)));
  const std::uint64_t stored_bytes = bytes / formats::element_bytes(type) * formats::element_bytes(*stored);
  if (tag.bytes != stored_bytes)
    refuse_input(path, "array", concat(tag.bytes, " bytes"), concat(stored_bytes, ", as its sizes need"));
  reader.check_size(stored_bytes);
  Array<std::byte> numbers(stored_bytes);
  reader.content(tag, numbers);
  reader.finish();
  make_native(numbers, formats::element_bytes(*stored), reader.big_endian());
  if (*stored == type) return numbers;
  Array<std::byte> converted(bytes);
  formats::with_element_type(type, [&]<class To>(To) { convert<To>(*stored, numbers, converted); });
  return converted;
}

/// Leaves out volumes of classes that are not read, if there is one that is read.
void leave_out_unreadable(std::vector<Variable>& variables, std::vector<std::string>& notes) {
  const auto is_volume = [](const Variable& variable) { return component_count_of(variable.array.shape).has_value(); };
  const auto is_unreadable = [&](const Variable& variable) {
    return is_volume(variable) && (variable.is_complex || !find_in(classes, variable.class_number));
  };
  const auto is_readable = [&](const Variable& variable) { return is_volume(variable) && !is_unreadable(variable); };
  if (std::none_of(variables.begin(), variables.end(), is_readable)) return;
  std::vector<std::string> names;
  for (const Variable& variable : variables)
    if (is_unreadable(variable)) names.push_back(variable.array.name);
  if (!names.empty()) notes.push_back(concat("arrays that cannot be read were left out: ", joined(names)));
  std::erase_if(variables, is_unreadable);
}

}  // namespace

NeutralVolume read_matlab(const fs::path& path, const std::string& field) {
  const ForeignFile file(path);
  const bool big_endian = is_big_endian(file);
  std::vector<Variable> variables = variables_in(file, big_endian);
  NeutralVolume volume;
  if (field.empty()) leave_out_unreadable(variables, volume.notes);
  std::vector<NamedShape> arrays;
  for (const Variable& variable : variables) arrays.push_back(variable.array);
  const VolumeChoice choice =
      choose_volume(path, arrays, field, "3 axes: x, y, z, or a fourth of 2 to 9 numbers for each sample");
  const auto& [name, component_count] = choice.volumes[choice.scalar.array];
  Variable variable = variables[choice.array];
  const std::optional<ElementType> type = find_in(classes, variable.class_number);
  if (!type || variable.is_complex)
    refuse_input(path, concat("array '", name, "'"), type ? "complex numbers" : "no plain array of numbers",
                 "real numbers", ErrorCode::unsupported);
  volume.sample_count = {variable.array.shape[0], variable.array.shape[1], variable.array.shape[2]};
  const std::uint64_t bytes = checked_array_bytes(path, volume.sample_count, {*type, component_count});
  ElementReader reader(path, variable, big_endian);
  read_head(reader, variable, path);
  Samples samples{*type, component_count, read_numbers(reader, *type, bytes, path)};
  interleave(samples, {.inner = static_cast<std::size_t>(rhoray::volume(volume.sample_count))});
  take_scalar(volume, std::move(samples), choice.scalar.component);
  set_names(volume, choice.volumes, choice.scalar, field);
  finish_volume(volume, path);
  return volume;
}

}  // namespace rhoray::preprocess
