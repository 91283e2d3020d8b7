#include "preprocess/values/isosurface_profile.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "formats/base/parallel.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {

namespace {

using Place = IsosurfaceProfile::Place;

/// Samples whose pairs are taken, about.
constexpr std::uint64_t sample_budget = std::uint64_t{1} << 19;
/// Samples per task; a task's sums take 4 KiB.
constexpr std::uint64_t grain_samples = 1 << 15;

/// Rounds to four digits: the sums are estimates, and every digit stands in the header.
double rounded_to_four_digits(double number) {
  std::array<char, 32> text;
  const char* const end =
      std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::scientific, 3).ptr;
  std::from_chars(text.data(), end, number);
  return number;
}

/// Distances between neighbours along one axis, in world units.
struct AxisSteps {
  std::vector<double> to_next;  ///< from sample i to i + 1
  std::vector<double> around;   ///< half the steps on both sides of sample i
};

AxisSteps steps_of(const ProfiledLattice& lattice, int axis) {
  const std::array<Vec3, 3> map{lattice.world_from_grid.x_axis, lattice.world_from_grid.y_axis,
                                lattice.world_from_grid.z_axis};
  const double length = map[static_cast<std::size_t>(axis)].length();
  const std::vector<double>& table = lattice.axes[static_cast<std::size_t>(axis)];
  const auto count = static_cast<std::size_t>(lattice.sample_count[axis]);
  AxisSteps steps;
  for (std::size_t i = 0; i + 1 < count; ++i)
    steps.to_next.push_back(table.empty() ? length : length * (table[i + 1] - table[i]));
  for (std::size_t i = 0; i < count; ++i) {
    const double before = i > 0 ? steps.to_next[i - 1] : 0, after = i + 1 < count ? steps.to_next[i] : 0;
    steps.around.push_back((before + after) / 2);
  }
  return steps;
}

}  // namespace

IsosurfaceProfile::IsosurfaceProfile(const formats::FieldSummary& field)
    : half_lo_(field.range.lo / 2),
      half_width_((field.range.hi / 2 - half_lo_) / static_cast<double>(field.histogram.size())),
      steps_(field.histogram.size() + 1) {}

template <class T>
Place IsosurfaceProfile::place(T value) const {
  if (!has_data(value)) return {};
  // Halved, as in formats::histogram_bin.
  const double position = (static_cast<double>(value) / 2 - half_lo_) / half_width_;
  return {.position = static_cast<float>(position), .below = static_cast<std::int32_t>(position + 0.5)};
}

void IsosurfaceProfile::add(const IsosurfaceProfile& other) {
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    steps_[i].patch += other.steps_[i].patch;
    steps_[i].jump += other.steps_[i].jump;
  }
}

void IsosurfaceProfile::store(double share, formats::FieldSummary& field) const {
  constexpr double patches_per_area = 1.5;  // the mean of |x| + |y| + |z| over all directions
  constexpr double rounding = 1e-12;        // what is left of sums that cancel
  double patch = 0, jump = 0, largest = 0;
  field.isosurface_area.clear(), field.mean_gradient.clear();
  for (std::size_t bin = 0; bin + 1 < steps_.size(); ++bin) {
    patch += steps_[bin].patch, jump += steps_[bin].jump;
    largest = std::max(largest, patch);
    const bool exists = patch > rounding * largest;
    const double area = patch / (share * patches_per_area);
    const double gradient = 2 * half_width_ * jump / patch * patches_per_area;
    field.isosurface_area.push_back(exists ? rounded_to_four_digits(area) : 0);
    field.mean_gradient.push_back(exists ? rounded_to_four_digits(std::max(0.0, gradient)) : 0);
  }
  const auto is_finite = [](double number) { return std::isfinite(number); };
  if (std::all_of(field.isosurface_area.begin(), field.isosurface_area.end(), is_finite) &&
      std::all_of(field.mean_gradient.begin(), field.mean_gradient.end(), is_finite))
    return;
  field.isosurface_area.clear(), field.mean_gradient.clear();
}

template <class T>
void profile_isosurfaces(std::span<const T> samples, const ProfiledLattice& lattice, formats::FieldSummary& field) {
  const IsosurfaceProfile none(field);
  if (!none.has_bins()) return;
  const std::array<AxisSteps, 3> steps{steps_of(lattice, 0), steps_of(lattice, 1), steps_of(lattice, 2)};
  const auto nx = static_cast<std::size_t>(lattice.sample_count.x),
             ny = static_cast<std::size_t>(lattice.sample_count.y),
             nz = static_cast<std::size_t>(lattice.sample_count.z);
  // An odd stride visits all y of a lattice whose count is a power of two.
  const std::size_t stride = samples.size() <= sample_budget ? 1 : (samples.size() / sample_budget) | 1;
  const std::size_t row_count = (ny * nz + stride - 1) / stride;
  const IsosurfaceProfile sums = parallel_reduce(
      row_count, std::max<std::size_t>(1, grain_samples / nx), none,
      [&](const IndexRange& part) {
        IsosurfaceProfile profile = none;
        std::vector<Place> row(nx), other(nx);
        const auto fill = [&](std::vector<Place>& places, std::size_t first) {
          for (std::size_t i = 0; i < nx; ++i) places[i] = none.place(samples[first + i]);
        };
        for (std::size_t r = part.begin(); r < part.end(); ++r) {
          const std::size_t j = r * stride % ny, k = r * stride / ny, first = nx * r * stride;
          fill(row, first);
          for (std::size_t i = 0; i + 1 < nx; ++i)
            profile.add(row[i], row[i + 1], steps[0].to_next[i], steps[1].around[j] * steps[2].around[k]);
          if (j + 1 < ny) {
            fill(other, first + nx);
            for (std::size_t i = 0; i < nx; ++i)
              profile.add(row[i], other[i], steps[1].to_next[j], steps[0].around[i] * steps[2].around[k]);
          }
          if (k + 1 < nz) {
            fill(other, first + nx * ny);
            for (std::size_t i = 0; i < nx; ++i)
              profile.add(row[i], other[i], steps[2].to_next[k], steps[0].around[i] * steps[1].around[j]);
          }
        }
        return profile;
      },
      [](IsosurfaceProfile a, const IsosurfaceProfile& b) {
        a.add(b);
        return a;
      });
  sums.store(static_cast<double>(row_count) / static_cast<double>(ny * nz), field);
}

#define RHORAY_PROFILE(T)                           \
  template Place IsosurfaceProfile::place(T) const; \
  template void profile_isosurfaces(std::span<const T>, const ProfiledLattice&, formats::FieldSummary&)
RHORAY_PROFILE(std::uint8_t);
RHORAY_PROFILE(std::int8_t);
RHORAY_PROFILE(std::uint16_t);
RHORAY_PROFILE(std::int16_t);
RHORAY_PROFILE(std::uint32_t);
RHORAY_PROFILE(std::int32_t);
RHORAY_PROFILE(float);
RHORAY_PROFILE(double);
#undef RHORAY_PROFILE

}  // namespace rhoray::preprocess
