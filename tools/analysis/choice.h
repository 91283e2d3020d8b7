#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "tools/rhoray/option_values.h"
#include "tools/rhoray/scene/resolve.h"

namespace rhoray::tools {

/// What a method is to keep.
struct Goal {
  std::optional<double> max_error;  ///< cells along the ray in 99 % of the pixels; of largest values a share of the
                                    ///< field's range
  std::optional<double> budget_ms;  ///< for tracing the picture, on this machine

  bool is_given() const { return max_error || budget_ms; }
};
std::vector<Option> goal_options(Goal& goal);  ///< --max-error, --budget-ms
void check(const Goal& goal);                  ///< refuses numbers that are not above 0 (ErrorCode::usage)

/// A method that was tried on a small picture of the scene.
struct Candidate {
  render::Method method;
  std::string word;
  double error = 0;         ///< that 99 % of the pixels keep that show or should show something
  double foreseen_ms = 0;   ///< for the whole picture
  bool keeps_error = true;  ///< max_error, in 99 % of all pixels, at a confidence of 97.5 %; or by proof
};

struct Choice {
  Candidate chosen;
  bool meets_goal = true;
  std::string sentence;  ///< what was chosen, and why
  std::vector<Candidate> candidates;
};

/// Tries the methods there are on a small picture of one layer, compares their answers with the exact ones, and takes
/// the cheapest that keeps the error, or the best that keeps the time. Where no method keeps both, the error is kept;
/// where none keeps the time, the fastest is taken; the sentence says so.
/// @param goal  with several layers: of this layer
Choice choose_method(const ResolvedScene& plan, std::size_t layer, const Goal& goal, unsigned threads,
                     std::stop_token stop = {});

/// Chooses for every isosurface and projection, which share the time, and puts the methods into the plan.
std::vector<Choice> choose_methods(ResolvedScene& plan, const Goal& goal, unsigned threads);

}  // namespace rhoray::tools
