#include <algorithm>
#include <cmath>

#include "preprocess/import/reading/byte_stream.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/keyed_words.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
namespace fs = std::filesystem;

/// The text before the samples: `Key = words` on each line, up to ElementDataFile.
class Header : public KeyedWords {
 public:
  explicit Header(const ForeignFile& file) : KeyedWords(file.path()) {
    WordReader reader(file);
    while (!has("ElementDataFile")) {
      if (reader.at_end()) refuse_input(path(), "header", "the end of the file", "the key ElementDataFile");
      add(reader.line());
    }
    data_position_ = reader.position();
  }

  bool is_true(const std::string& key) const {
    const std::string text = word(key, "False");
    return text == "True" || text == "true" || text == "1" || text == "T";
  }
  std::size_t data_position() const { return data_position_; }
  /// what ElementDataFile says, with the spaces in it
  const std::string& data_file() const { return data_file_; }

 private:
  void add(std::string_view line) {
    const std::size_t equals = line.find('=');
    const auto words_in = [](std::string_view text) {
      std::vector<std::string> words;
      for (std::size_t begin = 0; (begin = text.find_first_not_of(" \t\r", begin)) != std::string_view::npos;) {
        const std::size_t end = std::min(text.find_first_of(" \t\r", begin), text.size());
        words.emplace_back(text.substr(begin, end - begin));
        begin = end;
      }
      return words;
    };
    const std::vector<std::string> key = words_in(line.substr(0, equals));
    if (key.empty()) return;
    if (equals == std::string_view::npos || key.size() != 1)
      refuse_input(path(), "header", in_quotes(line), "lines of the form Key = value");
    const std::string_view value = line.substr(equals + 1);
    set(key.front(), words_in(value));
    if (key.front() == "ElementDataFile") data_file_ = trimmed(value);
  }

  std::size_t data_position_ = 0;
  std::string data_file_;
};

ElementType sample_type(const Header& header) {
  // MET_LONG and MET_ULONG have 4 bytes each in the format's definition.
  static constexpr std::pair<std::string_view, ElementType> types[] = {
      {"MET_CHAR", ElementType::I8},        {"MET_UCHAR", ElementType::U8},  {"MET_SHORT", ElementType::I16},
      {"MET_USHORT", ElementType::U16},     {"MET_INT", ElementType::I32},   {"MET_UINT", ElementType::U32},
      {"MET_LONG", ElementType::I32},       {"MET_ULONG", ElementType::U32}, {"MET_LONG_LONG", ElementType::I64},
      {"MET_ULONG_LONG", ElementType::U64}, {"MET_FLOAT", ElementType::F32}, {"MET_DOUBLE", ElementType::F64}};
  const std::string name = header.word("ElementType", "nothing");
  const std::optional<ElementType> found = find_in(types, name);
  if (!found) header.refuse("ElementType", name, "MET_CHAR to MET_DOUBLE, one number each", ErrorCode::unsupported);
  return *found;
}

Affine world_from_grid(const Header& header) {
  const std::vector<double> rows = header.numbers<double>({"TransformMatrix", "Rotation", "Orientation"}, 9);
  std::vector<double> spacing = header.numbers<double>({"ElementSpacing", "ElementSize"}, 3);
  std::vector<double> origin = header.numbers<double>({"Offset", "Position", "Origin"}, 3);
  if (spacing.empty()) spacing = {1, 1, 1};
  if (origin.empty()) origin = {0, 0, 0};
  Affine map = axis_parallel({spacing[0], spacing[1], spacing[2]}, {origin[0], origin[1], origin[2]});
  if (!rows.empty()) {  // each row is the world direction of one axis of the grid
    map.x_axis = spacing[0] * Vec3(rows[0], rows[1], rows[2]);
    map.y_axis = spacing[1] * Vec3(rows[3], rows[4], rows[5]);
    map.z_axis = spacing[2] * Vec3(rows[6], rows[7], rows[8]);
  }
  return map;
}

/// The files named by `slice%03d.raw FIRST LAST [STEP]`. The pattern may contain one %d, with a
/// width.
std::vector<std::string> numbered_files(const Header& header, const std::vector<std::string>& words) {
  const auto number = [&](std::size_t i) { return i < words.size() ? parse_number<int>(words[i]) : std::optional(1); };
  const std::optional<std::int64_t> first = number(1), last = number(2), step = number(3);  // 64 bits: sums fit
  std::vector<std::string> files;
  const bool is_series = first && last && step && *step >= 1 && *last >= *first && (*last - *first) / *step < 1'000'000;
  for (std::int64_t i = first.value_or(0); is_series && i <= *last; i += *step)
    if (const auto name = numbered_name(words.front(), i)) files.push_back(*name);
  if (files.empty()) header.refuse("ElementDataFile", in_quotes(words.front()), "NAME%0Nd FIRST LAST STEP");
  return files;
}

/// The files that hold the samples, one after the other; empty if the samples follow the header.
std::vector<std::string> data_files(const Header& header, const ForeignFile& file) {
  const std::vector<std::string>& words = header.words("ElementDataFile");
  if (words.empty()) header.refuse("ElementDataFile", "nothing", "a file's name or LOCAL");
  if (words.front() == "LOCAL" || words.front() == "Local" || words.front() == "local") return {};
  if (words.front() == "LIST") {
    WordReader reader(file, header.data_position());
    std::vector<std::string> files;
    while (!reader.at_end()) files.emplace_back(reader.line());
    if (files.empty()) header.refuse("ElementDataFile", "an empty LIST", "names of files");
    return files;
  }
  if (words.size() >= 3 && words.front().find('%') != std::string::npos) return numbered_files(header, words);
  return {header.data_file()};
}

/// The bytes that HeaderSize says to skip; a negative one leaves the last `wanted` bytes.
std::uint64_t skipped_bytes(const Header& header, std::span<const std::byte> source, std::uint64_t wanted) {
  const auto given = header.number<std::int64_t>("HeaderSize", 0);
  if (given >= 0) return static_cast<std::uint64_t>(given);
  return source.size() > wanted ? source.size() - wanted : 0;
}

/// The part of `source` that holds uncompressed samples.
std::span<const std::byte> plain_samples(const Header& header, const fs::path& path, std::span<const std::byte> source,
                                         std::uint64_t wanted, std::vector<std::string>& notes) {
  const std::uint64_t skipped = skipped_bytes(header, source, wanted);
  const auto samples = samples_behind(path, source, skipped, wanted);
  note_rest(notes, path, source.size() - skipped - wanted);
  return samples;
}

/// Copies or decompresses the part of `source` that holds `samples`.
void fill(const Header& header, const fs::path& path, std::span<const std::byte> source, std::span<std::byte> samples,
          std::vector<std::string>& notes) {
  if (header.is_true("CompressedData")) {
    check_packed_size(path, samples.size(), source.size());
    const auto stored = header.number<std::uint64_t>("CompressedDataSize", source.size());
    const std::uint64_t skipped = skipped_bytes(header, source, stored);
    const auto packed = samples_behind(path, source, skipped, source.size() - std::min(skipped, source.size()));
    ByteStream stream(path, packed, true);
    if (!stream.is_packed()) refuse_input(path, "samples", "another beginning", "zlib data, as CompressedData says");
    stream.read(samples, "samples");
    note_rest(notes, path, stream.finish());
    return;
  }
  const std::span<const std::byte> plain = plain_samples(header, path, source, samples.size(), notes);
  std::copy(plain.begin(), plain.end(), samples.begin());
}

/// A file in the same folder that the header names.
ForeignFile part_file(const Header& header, const std::string& name) {
  try {
    return ForeignFile(header.path().parent_path() / name);
  } catch (const Error& error) {
    throw Error(error.code(), concat(header.path().string(), ", key ElementDataFile: ", error.what()), error.hint());
  }
}

/// Fills the samples from the files one after the other; each file holds an equal part.
void fill_from_files(const Header& header, const ForeignFile& file, const std::vector<std::string>& files,
                     std::span<std::byte> samples, std::vector<std::string>& notes) {
  if (files.empty()) fill(header, header.path(), file.bytes().subspan(header.data_position()), samples, notes);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const ForeignFile part = part_file(header, files[i]);
    const std::uint64_t part_bytes = samples.size() / files.size();
    fill(header, part.path(), part.bytes(), samples.subspan(i * part_bytes, part_bytes), notes);
  }
}

/// Refuses sizes that the files on disk cannot hold, before anything is allocated.
void check_files(const Header& header, const ForeignFile& file, const std::vector<std::string>& files,
                 std::uint64_t wanted) {
  std::uint64_t held = file.bytes().size() - header.data_position();
  if (!files.empty()) {
    held = 0;
    for (const std::string& name : files) held += part_file(header, name).bytes().size();
  }
  if (header.is_true("CompressedData"))
    check_packed_size(header.path(), wanted, held);
  else if (held < wanted)
    header.refuse("DimSize", concat("sizes that need ", wanted, " bytes, with ", held, " bytes of data"),
                  "sizes that the data can fill");
}

/// Notes a scale that the header has for the stored numbers.
void note_scale(const Header& header, std::vector<std::string>& notes) {
  const auto slope = header.number<double>("ElementToIntensityFunctionSlope", 1);
  const auto offset = header.number<double>("ElementToIntensityFunctionOffset", 0);
  if (slope != 1 || offset != 0)
    notes.push_back(
        concat("stored numbers were not scaled; the header's scale is ", slope, " times the number plus ", offset));
}

/// @param colors  true: read only samples with 3 or 4 components of 8 bits
NeutralVolume read_samples(const fs::path& path, const std::string& field, bool colors) {
  const ForeignFile file(path);
  const Header header(file);
  const std::vector<int> axes = header.numbers<int>({"NDims"}, 1);
  if (axes.empty() || axes[0] != 3)
    refuse_input(path, "key NDims", axes.empty() ? "nothing" : concat(axes[0]), "3",
                 axes.empty() ? ErrorCode::invalid : ErrorCode::unsupported);
  const std::vector<std::int64_t> sizes = header.numbers<std::int64_t>({"DimSize"}, 3);
  if (sizes.empty()) refuse_input(path, "header", "no key DimSize", "three sizes");
  if (header.word("BinaryData", "True") == "False")
    refuse_input(path, "key BinaryData", "False: samples as text", "True", ErrorCode::unsupported);
  const auto channels = header.number<int>("ElementNumberOfChannels", 1);
  constexpr int most_channels = 1024;
  if (colors ? channels != 3 && channels != 4 : channels < 1 || channels > most_channels)
    refuse_input(path, "key ElementNumberOfChannels", concat(channels, " numbers for each sample"),
                 colors ? "3 or 4: colours" : concat("1 to ", most_channels), ErrorCode::unsupported);

  NeutralVolume volume;
  volume.sample_count = {sizes[0], sizes[1], sizes[2]};
  volume.component_count = colors ? channels : 1;
  volume.type = sample_type(header);
  if (colors && volume.type != ElementType::U8)
    refuse_input(path, "key ElementType", header.word("ElementType", ""), "MET_UCHAR: colours of 8 bits",
                 ErrorCode::unsupported);
  volume.world_from_grid = world_from_grid(header);
  if (const std::string unit = header.word("DistanceUnits", "?"); unit != "?") volume.length_unit = unit;
  note_scale(header, volume.notes);
  // Whoever says how the axes lie in a body writes places as ITK does.
  if (header.word("AnatomicalOrientation", "???") != "???") volume.space = formats::Space::lps;
  const std::vector<VectorArray> arrays{{stem_of(path), colors ? 1 : channels}};
  const ScalarChoice choice = choose_scalar(path, arrays, field);
  set_names(volume, arrays, choice, field);
  const std::uint64_t bytes = colors ? checked_color_bytes(path, volume.sample_count, channels)
                                     : checked_array_bytes(path, volume.sample_count, {volume.type, channels});
  const std::vector<std::string> files = data_files(header, file);
  if (!files.empty() && static_cast<std::uint64_t>(sizes[2]) % files.size() != 0)
    refuse_input(path, "key ElementDataFile", concat(files.size(), " files for ", sizes[2], " slices"),
                 "the same number of slices in each file");
  check_files(header, file, files, bytes);
  const bool big_endian = header.is_true("ElementByteOrderMSB") || header.is_true("BinaryDataByteOrderMSB");
  // The caller uses samples in a file only if the header names the file. A pattern with a number
  // does not name it.
  const bool is_named = files.empty() || header.words("ElementDataFile").front().find('%') == std::string::npos;
  const bool stays = arrays.front().component_count == 1 && files.size() <= 1 && is_named &&
                     !header.is_true("CompressedData") && is_native(volume.type, big_endian);
  if (stays) {
    const ForeignFile& holder = files.empty() ? file : part_file(header, files.front());
    const auto source = files.empty() ? file.bytes().subspan(header.data_position()) : holder.bytes();
    leave_samples_in(volume, holder, plain_samples(header, holder.path(), source, bytes, volume.notes));
  } else {
    Array<std::byte> samples(bytes);
    fill_from_files(header, file, files, samples, volume.notes);
    make_native(samples, formats::element_bytes(volume.type), big_endian);
    take_scalar(volume, {volume.type, arrays.front().component_count, std::move(samples)}, choice.component);
  }
  finish_volume(volume, path);
  return volume;
}

}  // namespace

NeutralVolume read_metaimage(const fs::path& path, const std::string& field) {
  return read_samples(path, field, false);
}

NeutralVolume read_metaimage_colors(const fs::path& path, const std::string& field) {
  return read_samples(path, field, true);
}

}  // namespace rhoray::preprocess
