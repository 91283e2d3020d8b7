#include "data/recipes/test_volumes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "data/recipes/write_nrrd.h"
#include "formats/base/error.h"
#include "formats/base/parallel.h"

namespace rhoray::recipes {

namespace {

/// Terms that depend on one axis only, for every sample of it. The volume is a cube, so one table
/// serves all three axes.
struct AxisTable {
  explicit AxisTable(std::int64_t size) {
    for (std::int64_t i = 0; i < size; ++i) {
      const double p = -1 + 2 * static_cast<double>(i) / static_cast<double>(size - 1);
      place.push_back(static_cast<float>(p));
      sine.push_back(static_cast<float>(std::sin(gyroid_frequency * p)));
      cosine.push_back(static_cast<float>(std::cos(gyroid_frequency * p)));
      swell.push_back(static_cast<float>(std::sin(4.5 * p + 0.7)));
    }
  }

  // three and a half waves from the centre to the border
  static constexpr double gyroid_frequency = 22;

  std::vector<float> place, sine, cosine, swell;
};

/// In [-8, 8]; depends only on the sample's index.
float sample_noise(std::uint64_t sample) {
  const std::uint64_t bits = (sample + 1) * 0x9e3779b97f4a7c15u;
  return static_cast<float>(((bits ^ bits >> 29) >> 8) % 17) - 8;
}

/// From 0 to 1 with slope 1 in the middle, for t from -0.75 to 0.75.
float step(float t) {
  const float s = std::clamp(t / 1.5F + 0.5F, 0.0F, 1.0F);
  return s * s * (3 - 2 * s);
}

/// 1200 in the body, nothing outside, plus 1600 where the gyroid is high.
void smooth_row(const AxisTable& axis, std::int64_t j, std::int64_t k, std::span<std::uint16_t> row) {
  const auto at = [](const std::vector<float>& table, std::int64_t i) { return table[static_cast<std::size_t>(i)]; };
  const float y = at(axis.place, j), z = at(axis.place, k);
  const float swell = 0.05F * at(axis.swell, j) * at(axis.swell, k);
  const std::uint64_t first = static_cast<std::uint64_t>(k * std::ssize(row) + j) * row.size();
  for (std::size_t i = 0; i < row.size(); ++i) {
    const float x = axis.place[i];
    const float depth = 0.78F + swell * axis.swell[i] - std::sqrt(x * x + 1.1F * (y * y) + 0.85F * (z * z));
    const float body = step(30 * depth);  // the whole rise takes 40 of 512 samples
    const float inside = step(8 * (depth - 0.15F));
    const float gyroid =
        axis.sine[i] * at(axis.cosine, j) + at(axis.sine, j) * at(axis.cosine, k) + at(axis.sine, k) * axis.cosine[i];
    const float value = 10 + 1190 * body + 1600 * inside * step(0.5F * gyroid) + sample_noise(first + i);
    row[i] = static_cast<std::uint16_t>(std::clamp(value, 0.0F, 65535.0F) + 0.5F);
  }
}

/// A wave of period 1, made of two parabolas. Unlike a sine, it has the same values on every
/// machine. The argument is at least -64.
float wave(float t) {
  const float positive = t + 64;
  const float share = positive - static_cast<float>(static_cast<std::int32_t>(positive));
  const float half = share < 0.5F ? share : share - 0.5F;
  const float arch = 16 * half * (0.5F - half);
  return share < 0.5F ? arch : -arch;
}

/// Five octaves. Each is bent by the one before, which rolls the sheets up.
void turbulent_row(const AxisTable& axis, std::int64_t j, std::int64_t k, std::span<std::uint16_t> row) {
  const float y = axis.place[static_cast<std::size_t>(j)], z = axis.place[static_cast<std::size_t>(k)];
  for (std::size_t i = 0; i < row.size(); ++i) {
    float px = axis.place[i], py = y, pz = z, weight = 1, sum = 0, bend = 0;
    for (int octave = 0; octave < 5; ++octave) {
      const float u = px + 0.35F * bend, v = py - 0.25F * bend, w = pz + 0.3F * bend;
      bend = wave(u) * wave(v + 0.25F) + wave(v) * wave(w + 0.25F) + wave(w) * wave(u + 0.25F);
      sum += weight * bend;
      weight *= 0.5F;
      // Rotated by (0.6, 0.8) about two axes, so that no octave is aligned with the grid, and
      // doubled.
      const float x1 = 0.6F * px - 0.8F * py, y1 = 0.8F * px + 0.6F * py;
      const float y2 = 0.6F * y1 - 0.8F * pz, z2 = 0.8F * y1 + 0.6F * pz;
      px = 2 * x1 + 0.31F, py = 2 * y2 + 0.17F, pz = 2 * z2 + 0.43F;
    }
    row[i] = static_cast<std::uint16_t>(std::clamp(2048 + 900 * sum, 0.0F, 65535.0F) + 0.5F);
  }
}

}  // namespace

void write_test_volume(const std::filesystem::path& path, const TestVolumeOptions& options) {
  const std::int64_t n = options.size;
  if (n < 2 || n > 4096) throw Error(ErrorCode::usage, concat("size ", n, "; expected 2 to 4096"));
  const bool is_smooth = options.which == TestVolume::smooth;
  const NrrdHeader header{.type = "uint16",
                          .sample_count = {n, n, n},
                          .first_sample = Vec3(0),
                          .spacing = Vec3(1),
                          .in_patient_mm = false,
                          .content = is_smooth ? "smooth test volume" : "turbulent test volume"};
  const AxisTable axis(n);
  write_nrrd(path, options.replace_existing, header, [&](PendingFile& raw) {
    constexpr std::int64_t slab = 16;  // slices in memory at a time
    std::vector<std::uint16_t> samples(static_cast<std::size_t>(n * n * std::min(slab, n)));
    for (std::int64_t first = 0; first < n; first += slab) {
      const std::int64_t rows = n * std::min(slab, n - first);
      parallel_for_each(static_cast<std::size_t>(rows), [&](std::size_t row_index) {
        const auto r = static_cast<std::int64_t>(row_index);
        const std::span row = std::span(samples).subspan(static_cast<std::size_t>(r * n), static_cast<std::size_t>(n));
        (is_smooth ? smooth_row : turbulent_row)(axis, r % n, first + r / n, row);
      });
      raw.append(std::as_bytes(std::span(samples).first(static_cast<std::size_t>(rows * n))));
    }
  });
}

}  // namespace rhoray::recipes
