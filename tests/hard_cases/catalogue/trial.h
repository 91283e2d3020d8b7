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

/// The columns of the table. "direct" is the bracketed root in grids, canonical edges in meshes,
/// and critical points for largest values. "paper" is Appendix A, Appendix B and the face rule.
std::span<const NamedMethod> catalogue_methods();
const NamedMethod& method_named(std::string_view name);

/// The results of a method for the queries of a case (its rays, once for each isovalue). An answer
/// is right if it agrees with the exact decision and position. A method that proves its answers
/// must be within the sum of both bounds. Others must be within a thousandth of a cell, which a
/// picture does not show and single precision reaches for simple roots. A largest value must be
/// within the bounds, or within a millionth of the field's range.
///
/// Rays that only touch the surface are counted separately: methods that prove their answers must
/// see them, others may or may not.
struct Tally {
  int queries = 0, missed = 0, false_hits = 0, wrong_place = 0;
  int touches = 0, touches_lost = 0;
  std::vector<std::string> complaints;  ///< the first few wrong answers, in full

  int wrong() const { return missed + false_hits + wrong_place; }
  int not_seen() const { return wrong() + touches_lost; }
};

/// A case whose queries have been answered with exact arithmetic.
class Trial {
 public:
  explicit Trial(const HardCase& hard_case);

  /// @param moved_by  counts an answer as right, too, if it is the exact one for a ray that is moved
  ///                  along each axis by at most this part of the longest edge of the data's box
  Tally tally(const NamedMethod& method, double moved_by = 0);

  /// Whether this part of the longest edge is at most the tolerance for the place of a hit.
  bool resolves(double moved_by) const;

  /// Counts the queries where the closed form contradicts the exact answer, and those where it has
  /// an answer.
  Tally against_known_answers() const;

  int hit_count() const;

 private:
  struct Truth {
    render::Hit hit;
    bool touches;
  };

  const HardCase& case_;
  std::unique_ptr<TracedDataset> traced_;
  std::vector<Truth> truths_;  ///< ordered by isovalue

  render::Hit ask(const render::Ray& ray, double isovalue, const render::Method& method);
  double t_per_cell(const render::Ray& ray) const;
  double longest_edge() const;
  bool is_right(const render::Hit& answer, const render::Hit& truth, const render::Ray& ray, bool proves) const;
  bool is_right_when_moved(const render::Hit& answer, const render::Ray& ray, double isovalue, double moved_by);
};

}  // namespace rhoray::tests
