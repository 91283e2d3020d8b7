#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "formats/base/bytes.h"
#include "preprocess/export/nifti_header.h"
#include "preprocess/import/reading/byte_stream.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/time_steps.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

using namespace nifti;

/// The first 348 bytes of a NIfTI-1 file, in either byte order.
class Header {
 public:
  Header(const std::filesystem::path& path, std::span<const std::byte, header_bytes> bytes)
      : path_(path), bytes_(bytes) {
    if (at<std::int32_t>(0) == static_cast<std::int32_t>(header_bytes)) return;
    swapped_ = true;
    if (at<std::int32_t>(0) == static_cast<std::int32_t>(header_bytes)) return;
    const bool second_version = at<std::int32_t>(0) == 540 || __builtin_bswap32(at<std::uint32_t>(0)) == 540;
    if (second_version) refuse_input(path, "byte 0", "NIfTI-2", "NIfTI-1", ErrorCode::unsupported);
    refuse_input(path, "byte 0", "another beginning", "the header size 348 of NIfTI-1");
  }

  template <class T>
  T at(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + offset, sizeof(T));
    if (swapped_) make_native(raw, sizeof(T), std::endian::native == std::endian::little);
    return std::bit_cast<T>(raw);
  }
  double real(std::size_t offset) const { return static_cast<double>(at<float>(offset)); }
  std::string_view magic() const { return {reinterpret_cast<const char*>(bytes_.data()) + nifti::magic, 4}; }
  bool big_endian() const { return swapped_ == (std::endian::native == std::endian::little); }
  const std::filesystem::path& path() const { return path_; }

 private:
  const std::filesystem::path& path_;
  std::span<const std::byte, header_bytes> bytes_;
  bool swapped_ = false;
};

/// Size along an axis from 1 to 7.
std::int64_t size_of(const Header& header, int axis) {
  return std::int64_t{header.at<std::int16_t>(dim + 2 * static_cast<std::size_t>(axis))};
}

Index3 sample_count(const Header& header) {
  const std::int64_t axes = size_of(header, 0);
  if (axes < 1 || axes > 7) refuse_input(header.path(), "dim[0]", concat(axes), "1 to 7");
  for (int axis = 6; axis <= axes; ++axis)
    if (size_of(header, axis) > 1)
      refuse_input(header.path(), concat("dim[", axis, "]"),
                   concat(size_of(header, axis), " groups of numbers for each sample"), "1", ErrorCode::unsupported);
  if (axes < 3) refuse_input(header.path(), "dim[0]", concat(axes, " axes"), "3", ErrorCode::unsupported);
  return {size_of(header, 1), size_of(header, 2), size_of(header, 3)};
}

/// The times of the volumes, in the file's unit; NaN without a time step.
std::vector<double> times_of(const Header& header) {
  const std::int64_t count = size_of(header, 0) < 4 ? 1 : std::max<std::int64_t>(size_of(header, 4), 1);
  const double step = header.real(pixdim + 16);
  std::vector<double> times;
  for (std::int64_t i = 0; i < count; ++i)
    times.push_back(step > 0 ? header.real(toffset) + static_cast<double>(i) * step : std::nan(""));
  return times;
}

/// Components of colours of 8 bits; 0 for other samples.
int color_components(const Header& header) {
  const int code = header.at<std::int16_t>(datatype);
  return code == 128 ? 3 : code == 2304 ? 4 : 0;
}

/// Numbers for each sample: those of colours lie side by side, those of vectors and tensors behind
/// all samples.
int component_count(const Header& header) {
  constexpr std::int64_t most = 1024;
  const std::int64_t numbers = size_of(header, 0) < 5 ? 1 : std::max<std::int64_t>(size_of(header, 5), 1);
  if (numbers > most)
    refuse_input(header.path(), "dim[5]", concat(numbers, " numbers for each sample"), concat("at most ", most),
                 ErrorCode::unsupported);
  if (numbers > 1 && color_components(header) != 0)
    refuse_input(header.path(), "dim[5]", concat(numbers, " colours for each sample"), "1", ErrorCode::unsupported);
  return std::max(static_cast<int>(numbers), color_components(header));
}

ElementType sample_type(const Header& header) {
  if (color_components(header) != 0) return ElementType::U8;
  const int code = header.at<std::int16_t>(datatype);
  const std::optional<ElementType> found = find_in(data_types, code);
  if (!found)
    refuse_input(header.path(), "datatype", concat(code), "integers or floating-point numbers of 8 to 64 bits",
                 ErrorCode::unsupported);
  return *found;
}

Affine from_sform(const Header& header) {
  const auto row = [&](std::size_t r, std::size_t c) { return header.real(srow + 16 * r + 4 * c); };
  const auto column = [&](std::size_t c) { return Vec3(row(0, c), row(1, c), row(2, c)); };
  return {column(0), column(1), column(2), column(3)};
}

Vec3 grid_spacing(const Header& header) {
  const auto along = [&](std::size_t axis) {
    const double spacing = std::abs(header.real(pixdim + 4 * axis));
    return spacing > 0 ? spacing : 1.0;
  };
  return {along(1), along(2), along(3)};
}

/// Method 2 of nifti1.h: a rotation given by a unit quaternion, the spacing, and qfac, which may
/// mirror the third axis.
Affine from_qform(const Header& header) {
  double b = header.real(quatern), c = header.real(quatern + 4), d = header.real(quatern + 8);
  double a = 1 - (b * b + c * c + d * d);
  if (a < 1e-7) {  // as in nifti1.h: rounding in the file's floats
    const double length = std::sqrt(b * b + c * c + d * d);
    b /= length, c /= length, d /= length, a = 0;
  } else {
    a = std::sqrt(a);
  }
  const Vec3 spacing = grid_spacing(header);
  const double qfac = header.real(pixdim) < 0 ? -1 : 1;
  return {spacing.x * Vec3(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)),
          spacing.y * Vec3(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)),
          qfac * spacing.z * Vec3(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - b * b - c * c),
          {header.real(qoffset), header.real(qoffset + 4), header.real(qoffset + 8)}};
}

Affine world_from_grid(const Header& header) {
  if (header.at<std::int16_t>(sform_code) > 0) return from_sform(header);
  if (header.at<std::int16_t>(qform_code) > 0) return from_qform(header);
  return axis_parallel(grid_spacing(header), {0, 0, 0});
}

std::string length_unit(const Header& header) {
  return length_units[header.at<std::uint8_t>(xyzt_units) & 7];
}

template <class T, class Result>
Array<std::byte> scaled(std::span<const std::byte> samples, double slope, double intercept) {
  Array<std::byte> result(samples.size() / sizeof(T) * sizeof(Result));
  for (std::size_t i = 0; i < samples.size() / sizeof(T); ++i) {
    T stored;
    std::memcpy(&stored, samples.data() + i * sizeof(T), sizeof stored);
    const auto value = static_cast<Result>(static_cast<double>(stored) * slope + intercept);
    std::memcpy(result.data() + i * sizeof(Result), &value, sizeof value);
  }
  return result;
}

/// Applies scl_slope and scl_inter if the file has them. The result is 32-bit floats, or 64-bit
/// floats if 32 bits would round.
void apply_scale(NeutralVolume& volume, const Header& header) {
  const double slope = header.real(scl_slope), intercept = header.real(scl_inter);
  if (!std::isfinite(slope) || !std::isfinite(intercept) || slope == 0 || (slope == 1 && intercept == 0)) return;
  const std::size_t stored_bytes = formats::element_bytes(volume.type);
  const bool wide = stored_bytes > 4 || volume.type == ElementType::I32 || volume.type == ElementType::U32;
  set_samples(volume, formats::with_element_type(volume.type, [&]<class T>(T) {
                return wide ? scaled<T, double>(volume.samples, slope, intercept)
                            : scaled<T, float>(volume.samples, slope, intercept);
              }));
  volume.type = wide ? ElementType::F64 : ElementType::F32;
  volume.notes.push_back(concat("stored numbers were scaled: ", slope, " times the number plus ", intercept));
}

std::span<const std::byte> samples_in(const ForeignFile& file, std::uint64_t first, std::uint64_t count) {
  const std::span<const std::byte> all = file.bytes();
  if (first > all.size() || count > all.size() - first)
    refuse_input(file.path(), "samples", concat("the end of the data after ", all.size(), " bytes"),
                 concat(count, " bytes after the first ", first));
  return all.subspan(first, count);
}

/// One volume of a file: its number, and how many there are.
struct Place {
  std::uint64_t index = 0, count = 1;
};

/// The volume that `time` selects; the first without one.
Place choose_volume(const Header& header, const std::string& time, std::vector<std::string>& notes) {
  const std::vector<double> times = times_of(header);
  if (!time.empty()) return {choose_time_step(times, time, header.path(), notes), times.size()};
  if (times.size() > 1)
    notes.push_back(concat("using the first of ", times.size(), " volumes; choose another with --time"));
  return {0, times.size()};
}

/// Takes the numbers of one volume: leaves them in the file, or copies or decompresses them.
/// @param groups  of numbers of all samples, each of `bytes` bytes; they lie behind those of all
///   times
void take_samples(NeutralVolume& volume, const Place& place, std::uint64_t groups, std::uint64_t bytes,
                  const Header& header, const ForeignFile& file, ByteStream& stream) {
  const double offset = header.real(vox_offset);
  if (!(offset >= 352 && offset < 1e9))  // written so that NaN is refused
    refuse_input(file.path(), "vox_offset", concat(offset), "at least 352");
  const std::optional<std::uint64_t> all = checked_product({place.count, groups, bytes});
  if (!all) refuse_input(file.path(), "dim", "sizes beyond 64 bits", "sizes that a file can hold");
  if (stream.is_packed())
    check_packed_size(file.path(), *all, file.bytes().size());
  else
    samples_in(file, static_cast<std::uint64_t>(offset), *all);
  std::uint64_t skipped = static_cast<std::uint64_t>(offset) - header_bytes + place.index * bytes;
  if (groups == 1 && !stream.is_packed() && is_native(volume.type, header.big_endian())) {
    leave_samples_in(volume, file, samples_in(file, header_bytes + skipped, bytes));
    note_rest(volume.notes, file.path(), file.bytes().size() - static_cast<std::uint64_t>(offset) - *all);
    return;
  }
  Array<std::byte> samples(groups * bytes);
  const auto skip = [&](std::uint64_t count) {
    if (stream.drain(count) != count)
      refuse_input(file.path(), "samples", "the end of the data", "as many as dim says");
  };
  for (std::uint64_t group = 0; group < groups; ++group) {
    skip(skipped);
    stream.read(std::span(samples).subspan(group * bytes, bytes), "samples");
    skipped = (place.count - 1) * bytes;
  }
  skip((place.count - place.index - 1) * bytes);
  note_rest(volume.notes, file.path(), stream.finish());
  make_native(samples, formats::element_bytes(volume.type), header.big_endian());
  set_samples(volume, std::move(samples));
}

/// Takes the chosen scalar from all numbers of each sample, which the volume has.
void take_component(NeutralVolume& volume, int component, const Header& header) {
  constexpr std::size_t intent_code = 68;
  constexpr int symmetric_matrix = 1005;
  const int count = component_count(header);
  Samples samples{volume.type, count, Array<std::byte>(volume.samples.begin(), volume.samples.end())};
  if (color_components(header) == 0)
    interleave(samples, {.inner = static_cast<std::size_t>(rhoray::volume(volume.sample_count))});
  if (count == 6 && header.at<std::int16_t>(intent_code) == symmetric_matrix) pick(samples, from_lower_rows);
  take_scalar(volume, std::move(samples), component);
}

/// @param colors  true: read only colours of 8 bits, in a file of one volume
NeutralVolume read_samples(const std::filesystem::path& path, const std::string& field, const std::string& time,
                           bool colors) {
  const ForeignFile file(path);
  ByteStream stream(path, file.bytes(), true);
  std::array<std::byte, header_bytes> header_text;
  stream.read(header_text, "header");
  const Header header(path, header_text);
  if (header.magic() == std::string_view("ni1\0", 4))
    refuse_input(path, "magic", "ni1: the samples lie in another file", "n+1: header and samples in one file",
                 ErrorCode::unsupported);
  if (header.magic() != std::string_view("n+1\0", 4)) refuse_input(path, "magic", "another word", "n+1");

  NeutralVolume volume;
  volume.sample_count = sample_count(header);
  volume.type = sample_type(header);
  if (colors) {
    volume.component_count = color_components(header);
    if (volume.component_count == 0)
      refuse_input(path, "datatype", concat(header.at<std::int16_t>(datatype)), "128 or 2304: colours of 8 bits",
                   ErrorCode::unsupported);
    if (times_of(header).size() > 1)
      refuse_input(path, "dim[4]", concat(times_of(header).size(), " volumes of colours"), "1", ErrorCode::unsupported);
  }
  volume.world_from_grid = world_from_grid(header);
  volume.length_unit = length_unit(header);
  const bool is_placed = header.at<std::int16_t>(sform_code) > 0 || header.at<std::int16_t>(qform_code) > 0;
  if (is_placed) volume.space = formats::Space::ras;
  const std::vector<VectorArray> arrays{{stem_of(path), colors ? 1 : component_count(header)}};
  const ScalarChoice choice = choose_scalar(path, arrays, field);
  set_names(volume, arrays, choice, field);
  const int together = std::max(1, color_components(header));
  const std::uint64_t bytes = checked_array_bytes(path, volume.sample_count, {volume.type, together});
  const std::uint64_t groups = static_cast<std::uint64_t>(component_count(header) / together);
  take_samples(volume, choose_volume(header, time, volume.notes), groups, bytes, header, file, stream);
  if (together == 1) apply_scale(volume, header);
  if (arrays.front().component_count > 1) take_component(volume, choice.component, header);
  finish_volume(volume, path);
  return volume;
}

}  // namespace

NeutralVolume read_nifti(const std::filesystem::path& path, const std::string& field, const std::string& time) {
  return read_samples(path, field, time, false);
}

NeutralVolume read_nifti_colors(const std::filesystem::path& path, const std::string& field) {
  return read_samples(path, field, {}, true);
}

}  // namespace rhoray::preprocess
