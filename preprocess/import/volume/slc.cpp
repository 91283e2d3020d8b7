#include <algorithm>

#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"

namespace rhoray::preprocess {
namespace {

/// Reads the words of the header of a Stony Brook SLC file (VolVis), then skips its icon.
class SlcHeader {
 public:
  explicit SlcHeader(const ForeignFile& file) : reader_(file) {
    if (reader_.word("11111") != "11111") reader_.refuse("another beginning", "11111, the mark of SLC files");
    for (int axis = 0; axis < 3; ++axis) sample_count_[axis] = reader_.number<std::int64_t>("three sizes");
    if (const int bits = reader_.number<int>("bits of a sample"); bits != 8)
      reader_.refuse(concat(bits, " bits for a sample"), "8", ErrorCode::unsupported);
    for (int axis = 0; axis < 3; ++axis) spacing_[axis] = reader_.number<double>("three spacings");
    unit_ = reader_.number<int>("a kind of unit");
    reader_.number<int>("where the data came from");
    reader_.number<int>("what was changed");
    compression_ = reader_.number<int>("a kind of compression");
    if (compression_ != 0 && compression_ != 1)
      reader_.refuse(concat("compression ", compression_), "0 or 1", ErrorCode::unsupported);
    const auto width = reader_.number<std::uint64_t>("the icon's width");
    const auto height = reader_.number<std::uint64_t>("the icon's height");
    if (width > 10000 || height > 10000) reader_.refuse(concat(width, " x ", height), "an icon up to 10000 x 10000");
    mark();
    reader_.bytes(3 * width * height, "an icon");
  }

  /// The slice's bytes as stored in the file.
  std::span<const std::byte> next_slice(std::uint64_t plain_bytes) {
    if (compression_ == 0) return reader_.bytes(plain_bytes, "a slice");
    const auto bytes = reader_.number<std::uint64_t>("the bytes of a packed slice");
    mark();
    return reader_.bytes(bytes, "a packed slice");
  }

  const Index3& sample_count() const { return sample_count_; }
  const Vec3& spacing() const { return spacing_; }
  bool is_packed() const { return compression_ == 1; }
  std::uint64_t bytes_left() const { return reader_.bytes_left(); }
  std::string length_unit() const {
    constexpr const char* names[] = {"m", "mm", "um", "ft"};
    return unit_ >= 0 && unit_ < 4 ? names[unit_] : "";
  }

 private:
  /// Skips to the next X; binary bytes begin right after it.
  void mark() {
    for (;;) {
      const char letter = std::to_integer<char>(reader_.bytes(1, "X, before binary data").front());
      if (letter == 'X') return;
      if (letter != ' ' && letter != '\n') reader_.refuse("another letter", "X, before binary data");
    }
  }

  WordReader reader_;
  Index3 sample_count_;
  Vec3 spacing_;
  int unit_ = 0, compression_ = 0;
};

/// Unpacks runs of bytes. A run starts with a count in seven bits; the eighth bit says whether that
/// many bytes follow, or one byte is repeated. A count of 0 ends the runs. VolVis' own files omit
/// the last sample of a slice: it then equals the one before. Returns true if it was omitted.
bool unpack_runs(const std::filesystem::path& path, std::int64_t slice, std::span<const std::byte> packed,
                 std::span<std::byte> plain) {
  std::size_t from = 0, to = 0;
  const auto expect = [&](bool holds) {
    if (!holds) refuse_input(path, concat("slice ", slice), "runs that do not fit", concat(plain.size(), " samples"));
  };
  while (to < plain.size()) {
    expect(from < packed.size());
    const auto control = std::to_integer<unsigned>(packed[from++]);
    const std::size_t count = control & 0x7fU;
    if (count == 0 && to != 0 && to + 1 == plain.size()) {
      plain[to] = plain[to - 1];
      return true;
    }
    const bool are_different = (control & 0x80U) != 0;
    expect(count != 0 && count <= plain.size() - to && (are_different ? count : 1) <= packed.size() - from);
    if (are_different) {
      std::copy_n(packed.begin() + static_cast<std::ptrdiff_t>(from), count,
                  plain.begin() + static_cast<std::ptrdiff_t>(to));
      from += count;
    } else {
      std::fill_n(plain.begin() + static_cast<std::ptrdiff_t>(to), count, packed[from++]);
    }
    to += count;
  }
  return false;
}

}  // namespace

NeutralVolume read_slc(const std::filesystem::path& path, const std::string&) {
  const ForeignFile file(path);
  SlcHeader header(file);
  NeutralVolume volume;
  volume.sample_count = header.sample_count();
  const std::uint64_t bytes = checked_volume_bytes(path, volume.sample_count, volume.type);
  constexpr std::uint64_t longest_run = 127;
  if (bytes / (header.is_packed() ? longest_run : 1) > header.bytes_left())
    refuse_input(path, "header", concat("sizes of ", bytes, " samples, and ", header.bytes_left(), " bytes"),
                 "sizes that the data can fill");
  const std::uint64_t slice_bytes = bytes / static_cast<std::uint64_t>(volume.sample_count.z);
  Array<std::byte> samples(bytes);
  std::int64_t short_slices = 0;
  for (std::int64_t k = 0; k < volume.sample_count.z; ++k) {
    const std::span<const std::byte> stored = header.next_slice(slice_bytes);
    const auto slice = std::span(samples).subspan(static_cast<std::uint64_t>(k) * slice_bytes, slice_bytes);
    if (header.is_packed())
      short_slices += unpack_runs(path, k, stored, slice) ? 1 : 0;
    else
      std::copy(stored.begin(), stored.end(), slice.begin());
  }
  if (short_slices != 0)
    volume.notes.push_back(concat(short_slices, " slices lack their last sample; the one before it was repeated"));
  note_rest(volume.notes, path, header.bytes_left());
  set_samples(volume, std::move(samples));
  volume.world_from_grid = axis_parallel(header.spacing(), {0, 0, 0});
  volume.length_unit = header.length_unit();
  volume.field_name = stem_of(path);
  finish_volume(volume, path);
  return volume;
}

}  // namespace rhoray::preprocess
