#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "formats/base/affine.h"
#include "formats/field_summary.h"

namespace rhoray::preprocess {

/// Estimates isosurface_area and mean_gradient of a field (formats::FieldSummary) from pairs of
/// neighbouring samples.
///
/// A pair crosses the isosurfaces between its two values. It stands for a patch whose projection
/// along the pair is the cell's volume divided by the pair's distance. Summed over three
/// perpendicular directions, (difference / distance) x patch gives the integral of the gradient's
/// magnitude over the isosurface. The patches alone give 1.5 times the area, in the mean over all
/// directions of the surface; it is divided out.
class IsosurfaceProfile {
 public:
  /// A sample among the bins of the histogram.
  struct Place {
    float position = 0;       ///< in bins
    std::int32_t below = -1;  ///< how many middles of bins are below; -1 without data
  };

  /// @param field  with its range and histogram; at least one bin
  explicit IsosurfaceProfile(const formats::FieldSummary& field);

  /// False without a finite value, when all values are equal, and for ranges below about 1e-305.
  /// Bins of such ranges are a few of the smallest numbers wide: rounding would put places beyond
  /// the last bin.
  bool has_bins() const { return std::isnormal(half_width_); }

  /// @param value  in the field's range, unless it is no data; has_bins() holds
  template <class T>
  Place place(T value) const;

  /// @param distance  between the two samples, world units
  /// @param patch     world units squared
  void add(const Place& a, const Place& b, double distance, double patch) {
    if (a.below == b.below || a.below < 0 || b.below < 0) return;
    const double jump =
        patch / distance * (a.position < b.position ? b.position - a.position : a.position - b.position);
    const auto [first, last] = a.below < b.below ? std::pair(a.below, b.below) : std::pair(b.below, a.below);
    Step& up = steps_[static_cast<std::size_t>(first)];
    Step& down = steps_[static_cast<std::size_t>(last)];
    up.patch += patch, up.jump += jump;
    down.patch -= patch, down.jump -= jump;
  }
  void add(const IsosurfaceProfile& other);

  /// Stores both lists, rounded to four digits. Stores none if a number is not finite.
  /// @param share  of all pairs that was added
  void store(double share, formats::FieldSummary& field) const;

 private:
  struct Step {
    double patch = 0, jump = 0;
  };
  double half_lo_, half_width_;
  std::vector<Step> steps_;  ///< how the sums change from the bin before; one more than bins
};

/// Where samples lie, x fastest: as formats::GridDescription says.
struct ProfiledLattice {
  Index3 sample_count;
  const Affine& world_from_grid;
  const std::array<std::vector<double>, 3>& axes;
};

/// Stores the profile of a field on a lattice, or nothing if it has no bins (has_bins()).
/// Uses the pairs of about half a million samples in whole rows along x, evenly spread. So the time
/// does not grow with the lattice. The result does not depend on the number of threads.
template <class T>
void profile_isosurfaces(std::span<const T> samples, const ProfiledLattice& lattice, formats::FieldSummary& field);

}  // namespace rhoray::preprocess
