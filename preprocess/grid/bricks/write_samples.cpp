#include "preprocess/grid/bricks/write_samples.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "formats/base/parallel.h"

namespace rhoray::preprocess {
namespace {

using formats::BrickLayout;

/// Bytes that a thread sorts before it writes: large enough for the disk, small enough to stay in
/// the cache.
constexpr std::int64_t piece_bytes = std::int64_t{1} << 20;

/// Copies bricks of n^3 samples. N is n where it is a compile-time constant, so that each run of n
/// is one instruction; otherwise 0.
template <class T, std::int64_t N>
class BrickCopier {
 public:
  BrickCopier(std::span<const T> samples, const BrickLayout& layout)
      : samples_(samples), count_(layout.sample_count), n_(N > 0 ? N : layout.brick_edge), m_(layout.superbrick_edge) {}

  /// @param first  the superbrick's first sample
  T* copy_superbrick(const Index3& first, T* out) const {
    Index3 brick;
    for (brick.z = 0; brick.z < m_.z; ++brick.z)
      for (brick.y = 0; brick.y < m_.y; ++brick.y)
        for (brick.x = 0; brick.x < m_.x; ++brick.x) out = copy_brick(first + brick * edge(), out);
    return out;
  }

 private:
  std::int64_t edge() const {
    if constexpr (N > 0)
      return N;
    else
      return n_;
  }
  const T* sample(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return samples_.data() + (k * count_.y + j) * count_.x + i;
  }

  T* copy_brick(const Index3& first, T* out) const {
    const bool is_whole = first.x + edge() <= count_.x && first.y + edge() <= count_.y && first.z + edge() <= count_.z;
    if (!is_whole) return copy_padded_brick(first, out);
    for (std::int64_t k = 0; k < edge(); ++k)
      for (std::int64_t j = 0; j < edge(); ++j, out += edge())
        std::memcpy(out, sample(first.x, first.y + j, first.z + k), static_cast<std::size_t>(edge()) * sizeof(T));
    return out;
  }

  /// Samples beyond the far sides are copies of the last sample.
  T* copy_padded_brick(const Index3& first, T* out) const {
    for (std::int64_t k = 0; k < edge(); ++k)
      for (std::int64_t j = 0; j < edge(); ++j)
        for (std::int64_t i = 0; i < edge(); ++i)
          *out++ = *sample(std::min(first.x + i, count_.x - 1), std::min(first.y + j, count_.y - 1),
                           std::min(first.z + k, count_.z - 1));
    return out;
  }

  std::span<const T> samples_;
  Index3 count_;
  std::int64_t n_;
  Index3 m_;
};

template <class T, std::int64_t N>
void write_bricked(std::span<const T> samples, const BrickLayout& layout, const std::string& array,
                   formats::PackedFileWriter& writer, ProgressMeter& meter) {
  const BrickCopier<T, N> copier(samples, layout);
  const Index3 superbricks = layout.superbrick_count();
  const Index3 edge = layout.superbrick_edge * layout.brick_edge;
  const std::int64_t superbrick_samples = volume(edge);
  const std::int64_t piece = std::max<std::int64_t>(1, piece_bytes / (superbrick_samples * std::int64_t{sizeof(T)}));
  const std::int64_t total = volume(superbricks);

  PerWorker<std::vector<T>> buffers(
      [&] { return std::vector<T>(static_cast<std::size_t>(std::min(piece, total) * superbrick_samples)); });
  parallel_for(static_cast<std::size_t>(total), static_cast<std::size_t>(piece), [&](const IndexRange& part) {
    std::vector<T>& buffer = buffers.of(part);
    const auto begin = static_cast<std::int64_t>(part.begin()), end = static_cast<std::int64_t>(part.end());
    T* out = buffer.data();
    for (std::int64_t s = begin; s < end; ++s) {
      const Index3 at(s % superbricks.x, s / superbricks.x % superbricks.y, s / superbricks.x / superbricks.y);
      out = copier.copy_superbrick(at * edge, out);
    }
    const std::span<const T> sorted(buffer.data(), out);
    writer.write(array, static_cast<std::uint64_t>(begin * superbrick_samples) * sizeof(T), std::as_bytes(sorted));
    meter.add(sorted.size_bytes());
  });
}

template <class T>
void write_linear(std::span<const T> samples, const std::string& array, formats::PackedFileWriter& writer,
                  ProgressMeter& meter) {
  constexpr std::size_t piece = static_cast<std::size_t>(piece_bytes) / sizeof(T);
  parallel_for(samples.size(), piece, [&](const IndexRange& part) {
    const std::span<const T> written = samples.subspan(part.begin(), part.size());
    writer.write(array, part.begin() * sizeof(T), std::as_bytes(written));
    meter.add(written.size_bytes());
  });
}

}  // namespace

template <class T>
void write_samples(std::span<const T> samples, const BrickLayout& layout, const std::string& array,
                   formats::PackedFileWriter& writer, ProgressMeter& meter) {
  if (layout.is_linear()) return write_linear(samples, array, writer, meter);
  switch (layout.brick_edge) {
    case 2:
      return write_bricked<T, 2>(samples, layout, array, writer, meter);
    case 4:
      return write_bricked<T, 4>(samples, layout, array, writer, meter);
    case 8:
      return write_bricked<T, 8>(samples, layout, array, writer, meter);
    default:
      return write_bricked<T, 0>(samples, layout, array, writer, meter);
  }
}

#define RHORAY_INSTANTIATE(T)                                                                                         \
  template void write_samples(std::span<const T>, const BrickLayout&, const std::string&, formats::PackedFileWriter&, \
                              ProgressMeter&)
RHORAY_INSTANTIATE(std::uint8_t);
RHORAY_INSTANTIATE(std::int8_t);
RHORAY_INSTANTIATE(std::uint16_t);
RHORAY_INSTANTIATE(std::int16_t);
RHORAY_INSTANTIATE(std::uint32_t);
RHORAY_INSTANTIATE(std::int32_t);
RHORAY_INSTANTIATE(float);
RHORAY_INSTANTIATE(double);
using Rgb = std::array<std::uint8_t, 3>;
using Rgba = std::array<std::uint8_t, 4>;
RHORAY_INSTANTIATE(Rgb);
RHORAY_INSTANTIATE(Rgba);
#undef RHORAY_INSTANTIATE

}  // namespace rhoray::preprocess
