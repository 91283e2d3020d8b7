#include "data/recipes/marschner_lobb.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "data/recipes/write_nrrd.h"
#include "formats/base/error.h"

namespace rhoray::recipes {

namespace {

template <class T>
std::vector<T> plane(std::int64_t size, double z, double scale, double rounding) {
  std::vector<T> samples;
  samples.reserve(static_cast<std::size_t>(size * size));
  const auto at = [&](std::int64_t i) { return -1 + 2 * static_cast<double>(i) / static_cast<double>(size - 1); };
  for (std::int64_t j = 0; j < size; ++j)
    for (std::int64_t i = 0; i < size; ++i)
      samples.push_back(static_cast<T>(scale * marschner_lobb({at(i), at(j), z}) + rounding));
  return samples;
}

}  // namespace

double marschner_lobb(const Vec3& p) {
  constexpr double pi = std::numbers::pi, alpha = 0.25, f_m = 6;
  const double r = std::sqrt(p.x * p.x + p.y * p.y);
  const double rho_r = std::cos(2 * pi * f_m * std::cos(pi * r / 2));
  return (1 - std::sin(pi * p.z / 2) + alpha * (1 + rho_r)) / (2 * (1 + alpha));
}

void write_marschner_lobb(const std::filesystem::path& path, const MarschnerLobbOptions& options) {
  const std::int64_t n = options.size;
  if (n < 2 || n > 4096) throw Error(ErrorCode::usage, concat("size ", n, "; expected 2 to 4096"));
  const double spacing = 2 / static_cast<double>(n - 1);
  const NrrdHeader header{.type = options.as_bytes ? "uint8" : "float",
                          .sample_count = {n, n, n},
                          .first_sample = Vec3(-1),
                          .spacing = Vec3(spacing),
                          .in_patient_mm = false,
                          .content = "marschner-lobb"};
  write_nrrd(path, options.replace_existing, header, [&](PendingFile& raw) {
    for (std::int64_t k = 0; k < n; ++k) {
      const double z = -1 + static_cast<double>(k) * spacing;
      const auto write = [&](const auto& samples) { raw.append(std::as_bytes(std::span(samples))); };
      if (options.as_bytes)
        write(plane<std::uint8_t>(n, z, 255, 0.5));
      else
        write(plane<float>(n, z, 1, 0));
    }
  });
}

}  // namespace rhoray::recipes
