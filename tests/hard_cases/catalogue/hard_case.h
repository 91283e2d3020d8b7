#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/traverse/ray.h"
#include "tests/render/support/traced_dataset.h"

/// The catalogue of numerically hard cases: R a ray in a cell, V the traversal from cell to cell, D
/// values of the data, T tetrahedra, M largest values. Each case is a small volume or mesh, with
/// rays chosen to be hard in it.
namespace rhoray::tests {

enum class Asked { surface_of_grid, surface_of_mesh, largest_value };

/// An answer in closed form: the t of the first crossing (infinity: none), or the largest value.
/// Nothing at the border of the form's validity.
using KnownAnswer = std::function<std::optional<double>(const render::Ray& ray, double isovalue)>;

/// The method that is expected to fail on a case, and the minimum number of failing queries. It
/// shows that the case is still hard. Without a method, the reason why none fails.
struct NaiveFailure {
  std::string_view method{};  ///< a name in catalogue_methods()
  int at_least = 0;
  std::string_view reason{};
};

struct HardCase {
  std::string id;
  std::string story;
  Asked asked = Asked::surface_of_grid;
  std::function<std::unique_ptr<TracedDataset>()> pack;
  /// Every ray is traced for each isovalue. For largest values, one arbitrary isovalue.
  std::vector<double> isovalues{0};
  std::vector<render::Ray> rays;
  NaiveFailure naive;
  KnownAnswer known{};
  double known_cells = 1e-6;              ///< tolerance of the closed form's t against the exact t,
                                          ///< in cells
  std::string_view direct_may_fail_by{};  ///< why direct methods in double promise less here
  double cell_edge = 1;                   ///< edge of a typical cell, in the frame of the volume
};

std::vector<HardCase> cubic_cases();
std::vector<HardCase> chord_cases();
std::vector<HardCase> traversal_cases();
std::vector<HardCase> value_cases();
std::vector<HardCase> tet_cases();
std::vector<HardCase> maximum_cases();

/// All cases, in this order.
std::vector<HardCase> catalogue();

}  // namespace rhoray::tests
