#include "preprocess/workers/tetgen/job.h"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>

#include "formats/base/error.h"
#include "preprocess/process/messages.h"

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
    throw Error(ErrorCode::internal, concat("tetrahedralizing worker: argument \"", text, "\"; expected a number"));
  return number;
}

}  // namespace

std::vector<std::string> arguments_of(const TetrahedralizeOptions& options, const SizeMessage& sizes) {
  const auto* distance = options.size_field ? std::get_if<SizeByDistance>(options.size_field.get()) : nullptr;
  const SizeByDistance none;
  const SizeByDistance& d = distance != nullptr ? *distance : none;
  std::vector<std::string> arguments{fill_verb,
                                     concat(options.quality.value_or(usual_quality)),
                                     concat(options.max_volume),
                                     options.tetgen,
                                     concat(int{options.regions}),
                                     concat(int{options.use_point_sizes}),
                                     sizes.kind,
                                     concat(sizes.descriptor),
                                     concat(int{options.empty_cavities}),
                                     concat(d.near),
                                     concat(d.far),
                                     concat(d.growth),
                                     concat(int{options.solids_may_touch})};
  for (const auto& [region, max_volume] : options.region_volumes) {
    arguments.push_back(concat(region));
    arguments.push_back(concat(max_volume));
  }
  return arguments;
}

namespace {

std::shared_ptr<const SizeField> size_field_from(const std::string& kind, int descriptor, SizeByDistance distance) {
  if (kind.empty()) return nullptr;
  const auto file = formats::PackedFile::from_descriptor(descriptor, "handed-over size field");
  if (kind == "volume") return std::make_shared<const SizeField>(receive_volume(file));
  if (kind == "mesh") return std::make_shared<const SizeField>(receive_mesh(file));
  distance.surface = receive_surface(file);
  return std::make_shared<const SizeField>(std::move(distance));
}

}  // namespace

TetrahedralizeOptions options_from(std::span<const char* const> arguments) {
  constexpr std::size_t fixed = 13;
  if (arguments.size() < fixed || (arguments.size() - fixed) % 2 != 0)
    throw Error(ErrorCode::internal,
                concat("tetrahedralizing worker: ", arguments.size(), " arguments; expected ", fixed, " and pairs"));
  const auto number = [&](std::size_t i) { return number_from(arguments[i]); };
  TetrahedralizeOptions options;
  options.quality = number(1);
  options.max_volume = number(2);
  options.tetgen = arguments[3];
  options.regions = number(4) != 0;
  options.use_point_sizes = number(5) != 0;
  options.empty_cavities = number(8) != 0;
  options.size_field = size_field_from(arguments[6], static_cast<int>(number(7)),
                                       {.surface = {}, .near = number(9), .far = number(10), .growth = number(11)});
  options.solids_may_touch = number(12) != 0;
  for (std::size_t i = fixed; i < arguments.size(); i += 2)
    options.region_volumes.push_back({.region = number(i), .max_volume = number(i + 1)});
  return options;
}

namespace {

bool limits_regions(const NeutralSurface& surface) {
  return std::any_of(surface.regions.begin(), surface.regions.end(), [](const auto& r) { return r.max_volume > 0; });
}

bool follows_sizes(const TetrahedralizeOptions& options, const NeutralSurface& surface) {
  return options.use_point_sizes && !surface.point_sizes.empty();
}

}  // namespace

bool wants_sizes(const TetrahedralizeOptions& options, const NeutralSurface& surface) {
  return follows_sizes(options, surface) || limits_regions(surface) || options.max_volume > 0 || options.size_field ||
         !options.region_volumes.empty();
}

std::string tetgen_switches(const TetrahedralizeOptions& options, const NeutralSurface& surface) {
  const double quality = options.quality.value_or(usual_quality);
  std::string switches = "p";
  if (quality > 0)
    switches += "q" + without_exponent(quality);
  else if (wants_sizes(options, surface))
    switches += "q0";  // refine, but for size alone
  if (options.max_volume > 0) switches += "a" + without_exponent(options.max_volume);
  if (limits_regions(surface)) switches += "a";
  if (options.regions) switches += "An";  // n: neighbours, by which regions are numbered
  if (follows_sizes(options, surface)) switches += "m";
  return switches + options.tetgen;
}

void check_tetgen_switches(const std::string& switches) {
  struct Refused {
    char letter;
    std::string_view why;
  };
  static constexpr Refused refused[] = {{'p', "is always on"},
                                        {'q', "is --quality"},
                                        {'a', "is --max-volume"},
                                        {'A', "is --regions"},
                                        {'m', "is --size-field or --sizes"},
                                        {'Q', "is always in force: what TetGen prints is kept from the screen"},
                                        {'d', "makes no mesh; without it crossings are looked for too"},
                                        {'r', "refines a mesh; the input here is a surface"},
                                        {'c', "would fill the convex hull, whatever the surface encloses"}};
  constexpr std::string_view allowed = "YOSTXM", numbers = "0123456789./e-+";
  for (std::size_t i = 0; i < switches.size(); ++i) {
    if (allowed.find(switches[i]) != std::string_view::npos) {
      const std::size_t next = switches.find_first_not_of(numbers, i + 1);
      i = std::min(next, switches.size()) - 1;
      continue;
    }
    std::string_view why = "changes what TetGen writes or reads, which is settled here";
    for (const Refused& r : refused)
      if (r.letter == switches[i]) why = r.why;
    throw Error(ErrorCode::usage,
                concat("TetGen's switch '", switches[i], "' ", why, "; expected some of Y O S T X M"));
  }
}

}  // namespace rhoray::preprocess
