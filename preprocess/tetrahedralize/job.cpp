#include "preprocess/tetrahedralize/job.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>

#include "formats/base/trouble.h"

namespace rhoray::preprocess {

namespace {

std::string without_exponent(double number) {
  char digits[512];  // the longest: a sign, "0." and 308 zeros before 17 digits
  return {digits, std::to_chars(digits, digits + sizeof digits, number, std::chars_format::fixed).ptr};
}

double number_from(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size())
    throw Error(Trouble::internal, concat("tetrahedralizing worker: argument \"", text, "\"; expected a number"));
  return number;
}

}  // namespace

std::vector<std::string> arguments_of(const TetrahedralizeOptions& options) {
  return {concat(options.quality), concat(options.max_volume), concat(int{options.use_point_sizes}),
          concat(int{options.regions})};
}

TetrahedralizeOptions options_from(std::span<const char* const> arguments) {
  if (arguments.size() != 4)
    throw Error(Trouble::internal, concat("tetrahedralizing worker: ", arguments.size(), " arguments; expected 4"));
  TetrahedralizeOptions options;
  options.quality = number_from(arguments[0]);
  options.max_volume = number_from(arguments[1]);
  options.use_point_sizes = number_from(arguments[2]) != 0;
  options.regions = number_from(arguments[3]) != 0;
  return options;
}

std::string tetgen_switches(const TetrahedralizeOptions& options, const NeutralSurface& surface) {
  const bool follows_sizes = options.use_point_sizes && !surface.point_sizes.empty();
  const bool limits_regions =
      std::any_of(surface.regions.begin(), surface.regions.end(), [](const auto& r) { return r.max_volume > 0; });

  std::string switches = "p";
  if (options.quality > 0)
    switches += "q" + without_exponent(options.quality);
  else if (follows_sizes || limits_regions || options.max_volume > 0)
    switches += "q0";  // refine, but for size alone
  if (options.max_volume > 0) switches += "a" + without_exponent(options.max_volume);
  if (limits_regions) switches += "a";
  if (options.regions) switches += "A";
  if (follows_sizes) switches += "m";
  return switches;
}

}  // namespace rhoray::preprocess
