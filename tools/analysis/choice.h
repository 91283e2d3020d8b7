#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "render/document.h"
#include "tools/rhoray/cli/options.h"

namespace rhoray::tools {

/// Goal that a chosen method must meet.
struct Goal {
  /// Along the ray, in cells, for 99 % of the pixels; for largest values a share of the field's
  /// range.
  std::optional<double> max_error;
  std::optional<double> budget_ms;  ///< for tracing the picture on this machine

  bool is_given() const { return max_error || budget_ms; }
};
std::vector<Option> goal_options(Goal& goal);  ///< --max-error, --budget-ms
/// Refuses numbers that are not above 0 (ErrorCode::usage).
void check(const Goal& goal);

/// A method that was tried on a small picture of the scene.
struct Candidate {
  render::Method method;
  std::string word;
  /// Upper bound for 99 % of the pixels that show or should show something.
  double error = 0;
  double foreseen_ms = 0;  ///< predicted for the whole picture
  /// Meets max_error in 99 % of all pixels, at a confidence of 97.5 %; or by proof.
  bool keeps_error = true;
};

struct Choice {
  Candidate chosen;
  bool meets_goal = true;
  std::string sentence;  ///< what was chosen, and why
  std::vector<Candidate> candidates;
};

/// Tries the available methods on a small picture of one layer, and compares their results with the
/// exact ones. Chooses the cheapest method that meets the error, or the most accurate one that
/// meets the time. If no method meets both, the error has priority. If none meets the time, the
/// fastest is chosen. The sentence says so.
/// @param goal  for this layer, if there are several
Choice choose_method(const render::ResolvedScene& plan, std::size_t layer, const Goal& goal, unsigned threads,
                     std::stop_token stop = {});

/// Chooses for every isosurface and projection, which share the time. Stores the methods in the
/// plan.
std::vector<Choice> choose_methods(render::ResolvedScene& plan, const Goal& goal, unsigned threads);

}  // namespace rhoray::tools
