#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tests/hard_cases/catalogue/hard_case.h"

namespace rhoray::tests {

struct NamedMethod {
  std::string_view name;
  render::Method method;
  bool for_grids, for_meshes, for_largest;

  bool answers(Asked asked) const {
    return asked == Asked::surface_of_grid ? for_grids : asked == Asked::surface_of_mesh ? for_meshes : for_largest;
  }
};

/// The columns of the table. "direct" is the bracketed root in grids, canonical edges in meshes, critical points for
/// largest values; "paper" is Appendix A, Appendix B and the face rule.
std::span<const NamedMethod> catalogue_methods();
const NamedMethod& method_named(std::string_view name);

/// What a method made of the questions of a case (its rays, once for each isovalue). Right is the judge's decision, at
/// the judge's place: for a method that proves its answers within the sum of both bounds, for others within a
/// thousandth of a cell, which a picture does not show and single precision reaches for simple roots; a largest value
/// within the bounds, or a millionth of the field's range.
///
/// Rays that only touch the surface count apart: what proves its answers must see them, the others may or may not.
struct Tally {
  int queries = 0, missed = 0, false_hits = 0, wrong_place = 0;
  int touches = 0, touches_lost = 0;
  std::vector<std::string> complaints;  ///< the first few wrong answers, in full

  int wrong() const { return missed + false_hits + wrong_place; }
  int not_seen() const { return wrong() + touches_lost; }
};

/// A case, its questions answered by the judge.
class Trial {
 public:
  explicit Trial(const HardCase& hard_case);

  Tally tally(const NamedMethod& method);

  /// Questions at which the closed form contradicts the judge; and those at which it says something.
  Tally against_known_answers() const;

  int hit_count() const;

 private:
  struct Truth {
    render::Hit hit;
    bool touches;
  };

  const HardCase& case_;
  std::unique_ptr<TracedVolume> traced_;
  std::vector<Truth> truths_;  ///< isovalue by isovalue

  render::Hit ask(const render::Ray& ray, double isovalue, const render::Method& method);
  double t_per_cell(const render::Ray& ray) const;
};

}  // namespace rhoray::tests
