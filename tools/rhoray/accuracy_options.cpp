#include "tools/rhoray/accuracy_options.h"

#include "formats/base/error.h"
#include "formats/base/number_text.h"

namespace rhoray::tools {

namespace {

void require_above_0(const char* option, const std::optional<double>& number) {
  if (number && !(*number > 0))
    throw Error(ErrorCode::usage, concat(option, ": found ", *number, "; expected a number above 0"));
}

}  // namespace

std::vector<Option> goal_options(render::Goal& goal) {
  return in_group(
      "Accuracy",
      {with_details(value_option("--max-error", "E",
                                 "Choose the fastest method with an error of at most E cells in 99 % of the pixels",
                                 goal.max_error),
                    "The error is measured along the ray, on a small picture. For a projection, E is a share of the "
                    "field's range"),
       for_experts(with_details(
           value_option("--budget-ms", "B",
                        "Choose the most accurate method that traces the picture in B milliseconds on this machine",
                        goal.budget_ms),
           "--max-error has priority"))});
}

std::vector<Option> self_check_options(render::SelfCheckOptions& options) {
  return in_group(
      "Accuracy",
      {with_details(value_option("--verify", "N",
                                 "Check N random pixels and N edge pixels with exact arithmetic and print the errors",
                                 options.pixels),
                    "Exit code 6 if the method's promise does not hold, 4 if the file's value ranges are wrong"),
       for_experts(with_details(
           value_option("--verify-limit", "E",
                        "Exit code 6 also if fewer than 99 % of the random pixels are within E cells", options.limit),
           "The error is measured along the ray. For a projection, E is a share of the field's range")),
       for_experts(value_option("--verify-seed", "N", "Random seed for --verify; default 1", options.seed))});
}

void require_valid(const render::Goal& goal) {
  require_above_0("--max-error", goal.max_error);
  require_above_0("--budget-ms", goal.budget_ms);
}

void require_valid(const render::SelfCheckOptions& options) {
  if (options.limit && options.pixels == 0)
    throw Error(ErrorCode::usage, "--verify-limit: needs --verify", "--verify 1000");
  require_above_0("--verify-limit", options.limit);
}

void require_checkable(const render::ResolvedScene& resolved) {
  if (const std::string reason = why_not_checkable(resolved); !reason.empty())
    throw Error(ErrorCode::usage, concat("--verify: ", reason));
}

std::string text_of(const render::SelfCheck& check) {
  const auto line = [&](const char* name, const render::CheckedPixels& found) {
    return concat("  ", name, " ", grouped(found.pixels),
                  " pixels: ", counted(found.missed, "false negative", "false negatives"), ", ",
                  counted(found.false_hits, "false positive", "false positives"), ", largest error ",
                  rounded(found.largest), check.unit.empty() ? "" : " ", check.unit,
                  check.unit.empty() ? "" : concat(", largest value error ", rounded(found.largest_value_error)), "\n");
  };
  return concat(
      "checked with exact arithmetic, seed ", check.seed,
      " (false negative: a missed hit; false positive: a hit that does not exist):\n", line("random", check.random),
      line("edges ", check.edges), "  limit: ", check.limit.empty() ? "none; the method promises nothing" : check.limit,
      "\n  ",
      check.broken.empty() ? (check.limit.empty() ? "no limit to check" : "within the limit") : "OUTSIDE THE LIMIT",
      "\n");
}

Json json_of(const render::SelfCheck& check) {
  const auto found = [](const render::CheckedPixels& pixels) {
    return Json{{"pixels", pixels.pixels},
                {"missed", pixels.missed},
                {"false_hits", pixels.false_hits},
                {"shown", pixels.shown},
                {"beyond_bound", pixels.beyond_bound},
                {"kept_by_99", pixels.kept_by_99},
                {"largest_error", pixels.largest},
                {"largest_value_error", pixels.largest_value_error}};
  };
  return {{"seed", check.seed}, {"random", found(check.random)}, {"edges", found(check.edges)},
          {"unit", check.unit}, {"limit", check.limit},          {"holds", check.broken.empty()}};
}

}  // namespace rhoray::tools
