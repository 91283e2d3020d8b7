#include <gdcmImageReader.h>
#include <gdcmStringFilter.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <sstream>

#include "formats/base/bytes.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/foreign_names.h"
#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/zip_archive.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
namespace fs = std::filesystem;

/// One image of a series, with its samples as stored.
struct DicomImage {
  std::string name;    ///< file name, for messages
  std::string series;  ///< SeriesInstanceUID
  std::string description, modality, unit;
  Index3 sample_count;  ///< columns, rows, frames
  /// unit vectors in the direction from sample to sample along a row and down a column (LPS, mm)
  Vec3 row, column;
  Vec3 spacing;  ///< along row and column; z: from frame to frame
  Vec3 origin;
  gdcm::PixelFormat format;
  double slope = 1, intercept = 0;
  std::vector<char> samples;
};

std::string unpadded(std::string text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

std::string unit_of(const std::string& modality, const std::string& code) {
  if (code == "BQML") return "Bq/ml";
  if (!code.empty() && code != "NONE") return code;
  return modality == "CT" ? "HU" : "";
}

std::uint32_t number_at(std::string_view bytes, bool big_endian) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i)
    number |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << 8 * (big_endian ? 3 - i : i);
  return number;
}

/// GDCM replaces missing bytes of a truncated file by zeros. Returns true if uncompressed samples
/// are complete in the file: a Pixel Data element of this size, or one byte more as padding to an
/// even size, in any encoding of a data set.
bool holds_samples(std::string_view bytes, std::uint64_t expected) {
  const auto holds_after = [&](std::string_view head, bool big_endian) {
    for (std::size_t at = bytes.find(head); at != std::string_view::npos; at = bytes.find(head, at + 1)) {
      const std::string_view rest = bytes.substr(at + head.size());
      if (rest.size() < 4) return false;
      const std::uint32_t length = number_at(rest, big_endian);
      if (length >= expected && length <= expected + 1 && rest.size() - 4 >= expected) return true;
    }
    return false;
  };
  using namespace std::string_view_literals;
  return holds_after("\xe0\x7f\x10\x00"sv, false) || holds_after("\xe0\x7f\x10\x00OW\0\0"sv, false) ||
         holds_after("\xe0\x7f\x10\x00OB\0\0"sv, false) || holds_after("\x7f\xe0\x00\x10OW\0\0"sv, true) ||
         holds_after("\x7f\xe0\x00\x10OB\0\0"sv, true);
}

/// GDCM invents missing pixels as it unpacks. Returns true if each Pixel Data element has all its
/// fragments in the file, up to the delimiter after the last one (DICOM PS3.5, section A.4). A
/// preview may be one more such element. Also true if there is none.
bool holds_fragments(std::string_view bytes) {
  using namespace std::string_view_literals;
  constexpr std::uint32_t item = 0xe000fffe, delimiter = 0xe0ddfffe;
  constexpr std::string_view tag = "\xe0\x7f\x10\x00"sv, undefined_length = "\0\0\xff\xff\xff\xff"sv;
  bool is_found = bytes.find(tag) == bytes.npos;
  for (std::size_t at = bytes.find(tag); at != bytes.npos; at = bytes.find(tag, at + tag.size())) {
    if (bytes.substr(at).size() < 12 || bytes.substr(at + 6, 6) != undefined_length) continue;
    std::size_t next = at + 12;
    for (std::uint32_t kind = item; kind != delimiter;) {
      if (bytes.size() - next < 8) return false;
      kind = number_at(bytes.substr(next), false);
      const std::uint32_t length = number_at(bytes.substr(next + 4), false);
      next += 8;
      if ((kind != item && kind != delimiter) || length > bytes.size() - next) return false;
      next += length;
    }
    is_found = true;
    at = next - tag.size();
  }
  return is_found;
}

/// Refuses packed samples that claim more than the file can hold, or are not complete in it. GDCM
/// unpacks samples as it reads a file, so this looks at its header first.
void check_packed_samples(std::istream& stream, const std::string& name, std::string_view bytes, const fs::path& path) {
  const gdcm::Tag pixel_representation(0x0028, 0x0103);  // behind all sizes; images must have it
  gdcm::Reader head;
  head.SetStream(stream);
  const bool is_read = head.ReadUpToTag(pixel_representation);
  stream.clear();
  stream.seekg(0);
  const gdcm::TransferSyntax& syntax = head.GetFile().GetHeader().GetDataSetTransferSyntax();
  const bool is_deflated = syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
  if (!is_read || (!syntax.IsEncapsulated() && !is_deflated)) return;
  gdcm::StringFilter texts;
  texts.SetFile(head.GetFile());
  const auto number = [&](std::uint16_t element) {
    return parse_number<std::uint64_t>(unpadded(texts.ToString(gdcm::Tag(0x0028, element)))).value_or(1);
  };
  constexpr std::uint16_t numbers_for_each = 0x02, frames = 0x08, rows = 0x10, columns = 0x11, bits = 0x100;
  const std::optional<std::uint64_t> expected =
      checked_product({number(numbers_for_each), number(frames), number(rows), number(columns), number(bits) / 8});
  if (!expected) refuse_input(path, name, "sizes beyond 64 bits", "sizes that a file can hold");
  constexpr std::uint64_t tightest_runs = 64;  // a run of 128 samples has two bytes
  const fs::path file = path.filename() == name ? path : path / name;
  if (is_deflated || syntax == gdcm::TransferSyntax::RLELossless)
    check_packed_size(file, *expected, bytes.size(), is_deflated ? tightest_zlib : tightest_runs);
  if (!is_deflated && !holds_fragments(bytes))
    refuse_input(path, name, "samples that end too early", concat(*expected, " bytes of them"));
}

/// Nothing if the file is DICOM but holds no image.
std::optional<DicomImage> read_image(const std::string& name, std::string_view bytes, const fs::path& path) {
  std::istringstream stream{std::string(bytes)};
  check_packed_samples(stream, name, bytes, path);
  gdcm::ImageReader reader;
  reader.SetStream(stream);
  if (!reader.Read()) {
    if (!reader.GetFile().GetDataSet().FindDataElement(gdcm::Tag(0x7fe0, 0x0010))) return std::nullopt;
    refuse_input(path, name, "an image that cannot be read", "a whole DICOM image");
  }
  const gdcm::Image& image = reader.GetImage();
  gdcm::StringFilter texts;
  texts.SetFile(reader.GetFile());
  const auto text = [&](std::uint16_t group, std::uint16_t element) {
    return unpadded(texts.ToString(gdcm::Tag(group, element)));
  };
  DicomImage result;
  result.name = name;
  result.series = text(0x0020, 0x000e);
  result.description = text(0x0008, 0x103e);
  result.modality = text(0x0008, 0x0060);
  result.unit = unit_of(result.modality, text(0x0054, 0x1001));
  const unsigned* const size = image.GetDimensions();
  result.sample_count = {size[0], size[1], image.GetNumberOfDimensions() == 3 ? size[2] : 1};
  const double* const cosines = image.GetDirectionCosines();
  result.row = {cosines[0], cosines[1], cosines[2]};
  result.column = {cosines[3], cosines[4], cosines[5]};
  result.spacing = {image.GetSpacing(0), image.GetSpacing(1), image.GetSpacing(2)};
  result.origin = {image.GetOrigin(0), image.GetOrigin(1), image.GetOrigin(2)};
  result.format = image.GetPixelFormat();
  result.slope = image.GetSlope();
  result.intercept = image.GetIntercept();
  if (result.format.GetSamplesPerPixel() != 1)
    refuse_input(path, name, concat(result.format.GetSamplesPerPixel(), " numbers for each pixel"), "1",
                 ErrorCode::unsupported);
  if (image.GetPhotometricInterpretation() == gdcm::PhotometricInterpretation::PALETTE_COLOR)
    refuse_input(path, name, "PALETTE COLOR: indices into a table of colours", "MONOCHROME1 or MONOCHROME2",
                 ErrorCode::unsupported);
  const std::uint64_t expected = static_cast<std::uint64_t>(volume(result.sample_count)) * result.format.GetPixelSize();
  if (image.GetBufferLength() != expected)
    refuse_input(path, name, concat(image.GetBufferLength(), " bytes of samples"), concat(expected));
  const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  const bool is_packed = syntax.IsEncapsulated() || syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
  if (!is_packed && !holds_samples(bytes, expected))
    refuse_input(path, name, "samples that end too early", concat(expected, " bytes of them"));
  result.samples.resize(expected);
  if (!image.GetBuffer(result.samples.data()))
    refuse_input(path, name, "samples that cannot be unpacked", "a whole DICOM image");
  return result;
}

struct Found {
  std::vector<DicomImage> images;
  std::uint64_t other_count = 0;  ///< files that are not DICOM images
};

void take_image(Found& found, const std::string& name, std::string_view bytes, const fs::path& path) {
  std::optional<DicomImage> image =
      bytes.size() > 132 && bytes.substr(128, 4) == "DICM" ? read_image(name, bytes, path) : std::nullopt;
  if (image)
    found.images.push_back(*std::move(image));
  else
    ++found.other_count;
}

Found read_images(const fs::path& path) {
  Found found;
  if (fs::is_directory(path)) {
    for (const fs::path& file : files_in(path)) {
      const std::uint64_t size = fs::file_size(file);
      if (size == 0) ++found.other_count;
      if (size != 0) take_image(found, file.filename().string(), ForeignFile(file).text(), path);
    }
  } else if (extension_of(path) == ".zip") {
    read_zip(path, [&](const std::string& name, std::string_view bytes) { take_image(found, name, bytes, path); });
  } else {
    take_image(found, path.filename().string(), ForeignFile(path).text(), path);
  }
  if (found.images.empty())
    refuse_input(path, "files", concat("no DICOM image in ", found.other_count), "a series of DICOM images");
  return found;
}

/// The images of one series: the series that `wanted` names by description or number, else the only
/// one, else the one with the most images. Series that share a description are named by description
/// and number; their images take that name as their description.
std::vector<DicomImage> one_series(Found found, const std::string& wanted, const fs::path& path,
                                   std::vector<std::string>& notes, std::vector<std::string>& others) {
  std::map<std::string, std::vector<DicomImage>> series;
  for (DicomImage& image : found.images) series[image.series].push_back(std::move(image));
  std::map<std::string, int> uses;
  for (const auto& [id, images] : series) ++uses[images.front().description];
  for (auto& [id, images] : series)
    if (std::string& name = images.front().description; !name.empty() && uses[name] > 1) name += concat(" (", id, ")");
  const auto name_of = [](const std::vector<DicomImage>& images) {
    return images.front().description.empty() ? images.front().series : images.front().description;
  };
  auto chosen = series.end();
  for (auto at = series.begin(); at != series.end(); ++at) {
    const bool is_wanted = !wanted.empty() && (wanted == at->first || wanted == name_of(at->second));
    const bool is_larger = wanted.empty() && (chosen == series.end() || at->second.size() > chosen->second.size());
    if (is_wanted || is_larger) chosen = at;
  }
  std::string names;
  for (const auto& [id, images] : series)
    names += concat(names.empty() ? "" : ", ", "'", name_of(images), "' (", images.size(), " images)");
  if (chosen == series.end())
    throw Error(ErrorCode::usage, concat(path.string(), ": found no series '", wanted, "'; expected one of ", names));
  if (series.size() > 1) notes.push_back(concat("using series '", name_of(chosen->second), "' of ", names));
  for (auto at = series.begin(); at != series.end(); ++at)
    if (at != chosen) others.push_back(name_of(at->second));
  return std::move(chosen->second);
}

Vec3 normal_of(const DicomImage& image) {
  return image.row.cross(image.column);
}

/// Checks that all images lie in parallel planes and have the same size.
void check_alike(const std::vector<DicomImage>& images, const fs::path& path) {
  const DicomImage& first = images.front();
  const auto close = [](const Vec3& a, const Vec3& b, double tolerance) { return (a - b).length() <= tolerance; };
  for (const DicomImage& image : images) {
    const bool alike =
        image.sample_count == first.sample_count && close(image.row, first.row, 1e-4) &&
        close(image.column, first.column, 1e-4) &&
        close({image.spacing.x, image.spacing.y, 0}, {first.spacing.x, first.spacing.y, 0}, 1e-4 * first.spacing.x);
    if (!alike)
      refuse_input(path, image.name, concat("an image that does not lie as ", first.name, " does"),
                   "images of one size, spacing and direction", ErrorCode::unsupported);
  }
}

/// Sets the third axis of the grid from the positions of the images, with a table if the steps
/// between them differ.
void place_images(NeutralVolume& volume, std::vector<DicomImage>& images, const fs::path& path) {
  const Vec3 normal = normal_of(images.front());
  std::stable_sort(images.begin(), images.end(), [&](const DicomImage& a, const DicomImage& b) {
    return a.origin.dot(normal) < b.origin.dot(normal);
  });
  const DicomImage& first = images.front();
  volume.world_from_grid = {first.spacing.x * first.row, first.spacing.y * first.column, first.spacing.z * normal,
                            first.origin};
  if (images.size() == 1) return;
  const Vec3 way = images.back().origin - first.origin;
  const auto steps = static_cast<double>(images.size() - 1);
  const double mean = way.length() / steps;
  std::vector<double> places;
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Vec3 from_first = images[i].origin - first.origin;
    places.push_back(from_first.dot(way.normalized()));
    if ((from_first - places.back() * way.normalized()).length() > 1e-2 * mean)
      refuse_input(path, images[i].name, "an image that does not stand in one line with the others",
                   "images shifted along one direction", ErrorCode::unsupported);
    if (i == 0) continue;
    smallest = std::min(smallest, places[i] - places[i - 1]);
    largest = std::max(largest, places[i] - places[i - 1]);
    if (!(places[i] - places[i - 1] > 1e-3 * mean))
      refuse_input(path, images[i].name, concat("an image at the place of ", images[i - 1].name),
                   "one image at each place", ErrorCode::unsupported);
  }
  if (largest - smallest <= 1e-2 * mean) {  // positions are written with few digits
    volume.world_from_grid.z_axis = way / steps;
    return;
  }
  volume.world_from_grid.z_axis = way.normalized();
  volume.axes[2] = std::move(places);
  volume.notes.push_back(concat("steps between images differ, ", smallest, " to ", largest, " mm; they are kept"));
}

/// The value of a stored sample of at most 32 bits, before scaling.
std::int64_t stored_number(const char* bytes, const gdcm::PixelFormat& format) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, bytes, format.GetBitsAllocated() / 8U);
  const unsigned stored = format.GetBitsStored();
  bits >>= format.GetHighBit() + 1U - stored;
  const std::uint64_t mask = (std::uint64_t{1} << stored) - 1;
  const auto number = static_cast<std::int64_t>(bits & mask);
  const bool is_negative = format.GetPixelRepresentation() == 1 && (number >> (stored - 1) & 1) != 0;
  return is_negative ? number - static_cast<std::int64_t>(mask) - 1 : number;
}

void check_format(const gdcm::PixelFormat& format, const std::string& name, const fs::path& path) {
  const unsigned allocated = format.GetBitsAllocated(), stored = format.GetBitsStored(), high = format.GetHighBit();
  if ((allocated != 8 && allocated != 16 && allocated != 32) || stored < 1 || stored > allocated || high + 1 < stored ||
      high >= allocated)
    refuse_input(path, name, concat(stored, " of ", allocated, " bits, the highest ", high),
                 "8, 16 or 32 bits for integers", ErrorCode::unsupported);
}

/// The narrowest integers that hold these; 64-bit floats if none do.
ElementType integers_for(double low, double high) {
  const auto holds = [&]<class T>(T) {
    return low >= static_cast<double>(std::numeric_limits<T>::min()) &&
           high <= static_cast<double>(std::numeric_limits<T>::max());
  };
  if (holds(std::uint8_t{})) return ElementType::U8;
  if (holds(std::uint16_t{})) return ElementType::U16;
  if (holds(std::int16_t{})) return ElementType::I16;
  if (holds(std::uint32_t{})) return ElementType::U32;
  return holds(std::int32_t{}) ? ElementType::I32 : ElementType::F64;
}

/// The narrowest type that holds every scaled sample: integers if scaling keeps them whole, else
/// 32-bit floats, or 64-bit floats if 32 bits would make neighbouring numbers one.
ElementType type_for(const std::vector<DicomImage>& images, const fs::path& path) {
  double low = 0, high = 0;
  bool is_whole = true, is_wide = false;
  for (const DicomImage& image : images) {
    check_format(image.format, image.name, path);
    is_whole = is_whole && image.slope == 1 && image.intercept == std::floor(image.intercept);
    const double range = std::ldexp(1.0, image.format.GetBitsStored());
    const double least = image.format.GetPixelRepresentation() == 1 ? -range / 2 : 0;
    const double ends[] = {image.slope * least + image.intercept, image.slope * (least + range - 1) + image.intercept};
    low = std::min({low, ends[0], ends[1]});
    high = std::max({high, ends[0], ends[1]});
    const double largest = std::max(std::abs(ends[0]), std::abs(ends[1]));
    const bool has_steps = largest <= std::ldexp(std::abs(image.slope), std::numeric_limits<float>::digits);
    is_wide = is_wide || !has_steps || largest > static_cast<double>(std::numeric_limits<float>::max());
  }
  if (is_whole) return integers_for(low, high);
  return is_wide ? ElementType::F64 : ElementType::F32;
}

void take_samples(NeutralVolume& volume, const std::vector<DicomImage>& images, const fs::path& path) {
  volume.type = type_for(images, path);
  Array<std::byte> samples(checked_volume_bytes(path, volume.sample_count, volume.type));
  formats::with_element_type(volume.type, [&]<class T>(T) {
    std::byte* to = samples.data();
    for (const DicomImage& image : images)
      for (std::size_t at = 0; at < image.samples.size(); at += image.format.GetPixelSize(), to += sizeof(T)) {
        const auto number = static_cast<double>(stored_number(image.samples.data() + at, image.format));
        const auto value = static_cast<T>(number * image.slope + image.intercept);
        std::memcpy(to, &value, sizeof value);
      }
  });
  set_samples(volume, std::move(samples));
}

}  // namespace

NeutralVolume read_dicom(const fs::path& path, const std::string& field) {
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  NeutralVolume volume;
  Found found = read_images(path);
  if (found.other_count != 0)
    volume.notes.push_back(concat(found.other_count, " files left out: they hold no DICOM image"));
  std::vector<DicomImage> images = one_series(std::move(found), field, path, volume.notes, volume.other_fields);
  check_alike(images, path);
  if (images.size() > 1 && images.front().sample_count.z != 1)
    refuse_input(path, "files", concat(images.size(), " images of several frames"), "one", ErrorCode::unsupported);
  volume.sample_count = images.front().sample_count;
  volume.sample_count.z *= static_cast<std::int64_t>(images.size());
  place_images(volume, images, path);
  take_samples(volume, images, path);
  volume.length_unit = "mm";
  volume.space = formats::Space::lps;
  const DicomImage& first = images.front();
  volume.field_name = !field.empty()              ? field
                      : first.description.empty() ? (first.modality.empty() ? stem_of(path) : first.modality)
                                                  : first.description;
  volume.field_unit = first.unit;
  finish_volume(volume, path);
  return volume;
}

}  // namespace rhoray::preprocess
