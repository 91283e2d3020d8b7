#include "preprocess/import/volume/nrrd_samples.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>

#include "preprocess/import/reading/byte_stream.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/volume/nrrd_header.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// Reads numbers that spaces or commas separate. Refuses what the type does not hold exactly.
template <class T>
void read_text(const std::filesystem::path& path, std::string_view text, std::span<std::byte> samples,
               std::vector<std::string>& notes) {
  constexpr std::string_view separators = " \t\r\n\v\f,";
  const std::size_t count = samples.size() / sizeof(T);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view word = take_word(text, separators);
    if (word.empty())
      refuse_input(path, concat("sample ", i), "the end of the data", count_text(count, "number", "numbers"));
    const std::optional<T> value = parse_number<T>(word);
    if (!value)
      refuse_input(path, concat("sample ", i), in_quotes(word),
                   concat("a number of ", formats::element_name(formats::element_type_of<T>())));
    std::memcpy(samples.data() + i * sizeof(T), &*value, sizeof(T));
  }
  if (const std::size_t rest = text.find_first_not_of(separators); rest != text.npos)
    note_rest(notes, path, text.find_last_not_of(separators) + 1 - rest);
}

/// Reads the samples of one file.
void load_part(const NrrdSamples& source, const NrrdSamples::Part& part, ElementType type, std::span<std::byte> samples,
               std::vector<std::string>& notes) {
  const ForeignFile file(part.file);
  std::size_t begin = part.begin;
  for (std::uint64_t line = 0; line < source.line_skip && begin < file.text().size(); ++line)
    begin = std::min(file.text().find('\n', begin), file.text().size() - 1) + 1;
  if (source.encoding == "gzip") {
    ByteStream stream(part.file, file.bytes().subspan(begin), true);
    if (!stream.is_packed()) refuse_input(part.file, "samples", "another beginning", "gzip data");
    stream.drain(static_cast<std::uint64_t>(source.byte_skip));
    stream.read(samples, "samples");
    note_rest(notes, part.file, stream.finish());
  } else if (source.encoding == "ASCII") {
    const std::string_view lines = file.text().substr(begin);
    const std::string_view text =
        lines.substr(std::min<std::size_t>(static_cast<std::size_t>(source.byte_skip), lines.size()));
    formats::with_element_type(type, [&]<class T>(T) { read_text<T>(part.file, text, samples, notes); });
  } else {
    const std::span<const std::byte> found = raw_samples(source, file, begin, samples.size(), notes);
    std::copy(found.begin(), found.end(), samples.begin());
  }
}

}  // namespace

std::span<const std::byte> raw_samples(const NrrdSamples& source, const ForeignFile& file, std::size_t begin,
                                       std::uint64_t wanted, std::vector<std::string>& notes) {
  const std::span<const std::byte> held = file.bytes().subspan(begin);
  const std::uint64_t from_end = held.size() > wanted ? held.size() - wanted : 0;
  const std::uint64_t skipped = source.byte_skip < 0 ? from_end : static_cast<std::uint64_t>(source.byte_skip);
  const std::span<const std::byte> samples = samples_behind(file.path(), held, skipped, wanted);
  note_rest(notes, file.path(), held.size() - skipped - wanted);
  return samples;
}

bool is_read_here(const NrrdSamples& source) {
  return (source.encoding == "raw" && source.byte_skip >= -1) ||
         ((source.encoding == "gzip" || source.encoding == "ASCII") && source.byte_skip >= 0);
}

void check_data_size(const NrrdSamples& source, std::uint64_t wanted, std::uint64_t sample_count) {
  const std::filesystem::path& path = source.header;
  std::uint64_t held = 0;
  for (const NrrdSamples::Part& part : source.parts) {
    std::error_code missing;
    held += std::filesystem::file_size(part.file, missing) - part.begin;
    if (missing) refuse_nrrd(path, missing.message());
  }
  if (wanted % source.parts.size() != 0)
    refuse_input(path, "key data file", concat(source.parts.size(), " files"), "as many as the sizes need");
  constexpr std::uint64_t tightest_bzip2 = 1'500'000;
  if (source.encoding == "gzip") check_packed_size(path, wanted, held);
  if (source.encoding == "bzip2") check_packed_size(path, wanted, held, tightest_bzip2);
  // ASCII: at least a digit per sample, with spaces in between
  const std::uint64_t least = source.encoding == "raw"     ? wanted
                              : source.encoding == "ASCII" ? 2 * sample_count - 1
                              : source.encoding == "hex"   ? 2 * wanted
                                                           : 0;
  if (held < least)
    refuse_input(path, "key sizes", concat("sizes that need ", least, " bytes, with ", held, " bytes of data"),
                 "sizes that the data can fill");
}

Array<std::byte> load_samples(const NrrdSamples& source, ElementType type, std::uint64_t bytes,
                              std::vector<std::string>& notes) {
  Array<std::byte> samples(bytes);
  const std::uint64_t share = bytes / source.parts.size();
  for (std::size_t i = 0; i < source.parts.size(); ++i)
    load_part(source, source.parts[i], type, std::span(samples).subspan(i * share, share), notes);
  if (source.encoding != "ASCII") make_native(samples, formats::element_bytes(type), source.is_big_endian);
  return samples;
}

}  // namespace rhoray::preprocess
