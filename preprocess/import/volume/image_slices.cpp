#include "preprocess/import/volume/image_slices.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <type_traits>

#include "formats/base/regular_file.h"
#include "preprocess/components.h"
#include "preprocess/import/reading/foreign_names.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
namespace fs = std::filesystem;

/// Properties that all slices share.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::string> channels;
  OIIO::TypeDesc type;
  friend bool operator==(const Picture&, const Picture&) = default;
};

std::string text_of(const Picture& picture) {
  return concat(picture.width, " x ", picture.height, ", ", picture.channels.size(), " channels of ",
                picture.type.c_str());
}

Picture picture_of(const OIIO::ImageSpec& spec) {
  return {spec.width, spec.height, spec.channelnames, spec.format};
}

std::unique_ptr<OIIO::ImageInput> open(const fs::path& path) {
  require_regular_file(path);
  note_source(path);
  OIIO::ImageSpec request;
  request["oiio:UnassociatedAlpha"] = 1;  // colours as stored
  auto input = OIIO::ImageInput::open(path.string(), &request);
  if (input) return input;
  OIIO::geterror();  // an error that nobody asked for is printed
  refuse_input(path, "header", "no picture, or a damaged one", "a picture");
}

/// One slice: a file, and a page of it.
struct Slice {
  fs::path file;
  int page = 0;
  bool is_only_page = false;  ///< the file must have no other
};

int page_count(const fs::path& file) {
  const auto input = open(file);
  int pages = 1;
  while (input->seek_subimage(pages, 0)) ++pages;
  OIIO::geterror();  // clear the error that there is no further page
  return pages;
}

std::vector<Slice> slices_of(const fs::path& path, std::size_t least) {
  std::vector<Slice> slices;
  if (fs::is_directory(path)) {
    for (const fs::path& file : files_in(path))
      if (is_picture_name(file)) slices.push_back({file, 0, true});
  } else {
    const int pages = page_count(path);
    for (int page = 0; page < pages; ++page) slices.push_back({path, page});
  }
  if (slices.size() < least)
    throw Error(ErrorCode::unsupported,
                concat(path.string(), ": found ", slices.size(), " slice; expected at least ", least),
                "name the folder that holds the slices of the volume; `rhoray render` takes scenes from PNG and EXR "
                "pictures only");
  return slices;
}

/// Bytes of one slice, all channels, in the file's type.
std::size_t bytes_of(const Picture& picture) {
  return static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * picture.channels.size() *
         picture.type.size();
}

/// Refuses pictures that claim more bytes than their files can hold. Other formats set no limit.
void check_size(const fs::path& path, const std::vector<Slice>& slices, const Picture& picture) {
  constexpr std::uint64_t bits = 8, most_channels = 4;  // a bit may be an index to a colour
  static constexpr std::pair<std::string_view, std::uint64_t> tightest[] = {
      {"pnm", bits}, {"png", bits * most_channels * tightest_zlib}};
  const std::optional<std::uint64_t> limit =
      find_in(tightest, std::string_view(open(slices.front().file)->format_name()));
  if (!limit) return;
  std::uint64_t held = 0;
  for (const Slice& slice : slices) held += slice.page == 0 ? fs::file_size(slice.file) : 0;
  check_packed_size(path, bytes_of(picture) * slices.size(), held, *limit);
}

/// True if the file goes up to the mark of the end of its picture, which other data may follow.
/// Marks are FF and a byte that is not 0. Behind most is a segment, whose length comes first; the
/// packed data of a scan stand without one (ITU-T T.81, annex B).
bool is_whole_jpeg(std::string_view bytes) {
  std::size_t at = 2;
  for (;;) {
    at = bytes.find_first_not_of('\xff', bytes.find('\xff', at));
    if (at == bytes.npos) return false;
    const auto mark = static_cast<unsigned char>(bytes[at++]);
    if (mark == 0xd9) return true;
    if (mark <= 1 || (mark >= 0xd0 && mark <= 0xd8)) continue;  // no segment: packed data, restarts
    if (bytes.size() - at < 2) return false;
    at += 256 * static_cast<unsigned char>(bytes[at]) + static_cast<unsigned char>(bytes[at + 1]);
    if (at >= bytes.size()) return false;
  }
}

/// Reads the pixels of one slice, all channels.
void read_pixels(const Slice& slice, const Picture& expected, std::byte* pixels) {
  const auto input = open(slice.file);
  const auto refuse_damage = [&] {
    input->geterror();  // likewise
    refuse_input(slice.file, concat("page ", slice.page), "damaged data", "a whole picture");
  };
  if (slice.is_only_page && input->seek_subimage(1, 0))
    refuse_input(slice.file, "header", "several pages", "one picture in each file of a folder", ErrorCode::unsupported);
  input->geterror();  // that there is no further page
  // OpenImageIO fills what is missing.
  if (std::string_view(input->format_name()) == "jpeg" && !is_whole_jpeg(ForeignFile(slice.file).text()))
    refuse_damage();
  if (!input->seek_subimage(slice.page, 0)) refuse_damage();
  const Picture found = picture_of(input->spec());
  if (found != expected)
    refuse_input(slice.file, concat("page ", slice.page), text_of(found),
                 concat(text_of(expected), ", as the first slice"));
  if (!input->read_image(slice.page, 0, 0, -1, found.type, pixels)) refuse_damage();
}

ElementType element_type_of_oiio(const Picture& picture, const fs::path& path) {
  using OIIO::TypeDesc;
  static constexpr std::pair<int, ElementType> types[] = {
      {TypeDesc::UINT8, ElementType::U8},  {TypeDesc::UINT16, ElementType::U16}, {TypeDesc::UINT32, ElementType::U32},
      {TypeDesc::INT8, ElementType::I8},   {TypeDesc::INT16, ElementType::I16},  {TypeDesc::INT32, ElementType::I32},
      {TypeDesc::FLOAT, ElementType::F32}, {TypeDesc::DOUBLE, ElementType::F64}};
  const std::optional<ElementType> found = find_in(types, int{picture.type.basetype});
  if (!found)
    refuse_input(path, "header", picture.type.c_str(), "8, 16 or 32 bit integers, or floats", ErrorCode::unsupported);
  return *found;
}

/// The channel that becomes the sample.
struct Choice {
  static constexpr int luminance = -1;  ///< of linear R, G, B (ITU-R BT.709)
  static constexpr int grey = -2;       ///< R, if R, G and B are equal
  static constexpr int magnitude = -3;  ///< of R, G and B; 32-bit floats, or 64-bit floats of wide types
  int channel = 0;
};

constexpr const char* magnitude_name = "colors.mag";

std::size_t colour_count(const Picture& picture) {
  return picture.channels.size() >= 3 ? 3 : 1;  // the rest is alpha
}

Choice choose(const Picture& picture, const std::string& field, const fs::path& path) {
  if (field.empty()) return {colour_count(picture) == 3 ? Choice::grey : 0};
  std::string names;
  for (std::size_t c = 0; c < picture.channels.size(); ++c) {
    if (field == picture.channels[c]) return {static_cast<int>(c)};
    names += concat(names.empty() ? "" : ", ", picture.channels[c]);
  }
  if (colour_count(picture) == 3) {
    if (field == "luminance") return {Choice::luminance};
    if (field == magnitude_name) return {Choice::magnitude};
    names += concat(", luminance, ", magnitude_name);
  }
  throw Error(ErrorCode::usage, concat(path.string(), ": found no field '", field, "'; expected one of ", names));
}

/// Takes the samples of one slice from its pixels. Returns false at a colour where grey was chosen.
template <class T, class Sample>
bool take_slice(const std::vector<std::byte>& pixels, const Picture& picture, const Choice& choice,
                std::span<std::byte> to) {
  const std::size_t channels = picture.channels.size();
  const auto value = [&](std::size_t pixel, std::size_t channel) {
    T number;
    std::memcpy(&number, pixels.data() + (pixel * channels + channel) * sizeof(T), sizeof number);
    return number;
  };
  const auto as_double = [&](std::size_t pixel, std::size_t channel) {
    return static_cast<double>(value(pixel, channel));
  };
  for (std::size_t pixel = 0; pixel < to.size() / sizeof(Sample); ++pixel) {
    const T first = value(pixel, choice.channel < 0 ? 0 : static_cast<std::size_t>(choice.channel));
    auto sample = static_cast<Sample>(first);
    if (choice.channel == Choice::luminance)
      sample = static_cast<Sample>(0.2126 * static_cast<double>(first) + 0.7152 * as_double(pixel, 1) +
                                   0.0722 * as_double(pixel, 2));
    else if (choice.channel == Choice::magnitude)
      sample = static_cast<Sample>(
          magnitude_of(std::array{static_cast<double>(first), as_double(pixel, 1), as_double(pixel, 2)}));
    else if (choice.channel == Choice::grey && (first != value(pixel, 1) || first != value(pixel, 2)))
      return false;
    std::memcpy(to.data() + pixel * sizeof(Sample), &sample, sizeof sample);
  }
  return true;
}

/// The samples of all slices; nothing where grey was chosen and a pixel has a colour.
template <class T, class Sample>
std::optional<Array<std::byte>> take_slices(const std::vector<Slice>& slices, const Picture& picture,
                                            const Choice& choice, std::uint64_t sample_count) {
  std::vector<std::byte> pixels(bytes_of(picture));
  read_pixels(slices.front(), picture, pixels.data());  // before memory for all is taken
  Array<std::byte> samples(sample_count * sizeof(Sample));
  const std::size_t slice_bytes = samples.size() / slices.size();
  for (std::size_t k = 0; k < slices.size(); ++k) {
    if (k > 0) read_pixels(slices[k], picture, pixels.data());
    if (!take_slice<T, Sample>(pixels, picture, choice, std::span(samples).subspan(k * slice_bytes, slice_bytes)))
      return std::nullopt;
  }
  return samples;
}

/// Reads the chosen samples. Colours without a choice become their magnitude, with a note.
void take_samples(NeutralVolume& volume, const std::vector<Slice>& slices, const Picture& picture, Choice choice,
                  std::uint64_t sample_count) {
  formats::with_element_type(volume.type, [&]<class T>(T) {
    std::optional<Array<std::byte>> samples;
    if (choice.channel != Choice::magnitude) samples = take_slices<T, T>(slices, picture, choice, sample_count);
    if (!samples) {
      using Real = std::conditional_t<(sizeof(T) > 4 || (std::is_integral_v<T> && sizeof(T) == 4)), double, float>;
      volume.type = sizeof(Real) == sizeof(double) ? ElementType::F64 : ElementType::F32;
      samples = take_slices<T, Real>(slices, picture, {Choice::magnitude}, sample_count);
      volume.field_name = magnitude_name;
      if (choice.channel == Choice::grey)
        volume.notes.push_back(concat("using the magnitude of the colours, '", magnitude_name,
                                      "'; choose another with --field: R, G, B, luminance"));
    }
    set_samples(volume, *std::move(samples));
  });
}

/// Refuses anything but 8-bit red, green and blue, with or without separate alpha.
void check_colors(const OIIO::ImageSpec& spec, const fs::path& path) {
  const std::vector<std::string>& names = spec.channelnames;
  const bool has_alpha = names.size() == 4;
  const bool is_rgb = (names.size() == 3 || has_alpha) && names[0] == "R" && names[1] == "G" && names[2] == "B" &&
                      (!has_alpha || names[3] == "A");
  if (!is_rgb || spec.format != OIIO::TypeDesc::UINT8)
    refuse_input(path, "header", text_of(picture_of(spec)), "R, G, B, or R, G, B, A, of 8 bits",
                 ErrorCode::unsupported);
  if (has_alpha && spec.get_int_attribute("oiio:UnassociatedAlpha") == 0)
    refuse_input(path, "header", "colours multiplied by alpha", "colours by themselves (unassociated alpha)",
                 ErrorCode::unsupported);
}

constexpr const char* no_spacing =
    "pictures have no sample spacing; using 1 x 1 x 1, choose another with --spacing X,Y,Z";

}  // namespace

NeutralVolume read_image_slices(const fs::path& path, const std::string& field) {
  OIIO::attribute("threads", 1);
  const std::vector<Slice> slices = slices_of(path, 2);
  const Picture picture = picture_of(open(slices.front().file)->spec());
  const Choice choice = choose(picture, field, path);
  NeutralVolume volume;
  volume.type = element_type_of_oiio(picture, path);
  volume.sample_count = {picture.width, picture.height, static_cast<std::int64_t>(slices.size())};
  const std::uint64_t bytes = checked_volume_bytes(path, volume.sample_count, volume.type);
  check_size(path, slices, picture);
  volume.field_name = field.empty() ? "intensity" : field;
  take_samples(volume, slices, picture, choice, bytes / formats::element_bytes(volume.type));
  volume.world_from_grid = axis_parallel({1, 1, 1}, {0, 0, 0});
  if (colour_count(picture) == 3) volume.other_fields.assign(picture.channels.begin(), picture.channels.end());
  volume.notes.emplace_back(no_spacing);
  finish_volume(volume, path);
  return volume;
}

NeutralVolume read_color_slices(const fs::path& path) {
  OIIO::attribute("threads", 1);
  const std::vector<Slice> slices = slices_of(path, 1);
  const OIIO::ImageSpec spec = open(slices.front().file)->spec();
  const Picture picture = picture_of(spec);
  check_colors(spec, slices.front().file);
  NeutralVolume volume;
  volume.component_count = static_cast<int>(picture.channels.size());
  volume.sample_count = {picture.width, picture.height, static_cast<std::int64_t>(slices.size())};
  check_size(path, slices, picture);
  Array<std::byte> samples(checked_color_bytes(path, volume.sample_count, volume.component_count));
  const std::size_t slice_bytes = bytes_of(picture);
  for (std::size_t k = 0; k < slices.size(); ++k) read_pixels(slices[k], picture, samples.data() + k * slice_bytes);
  set_samples(volume, std::move(samples));
  volume.world_from_grid = axis_parallel({1, 1, 1}, {0, 0, 0});
  volume.field_name = "colors";
  volume.notes.emplace_back(no_spacing);
  finish_volume(volume, path);
  return volume;
}

}  // namespace rhoray::preprocess
