#include "preprocess/import/reading/time_steps.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "preprocess/import/reading/numbers.h"

namespace rhoray::preprocess {
namespace {

/// " (t = 2)"; nothing where the file tells no time.
std::string time_text(double time) {
  if (std::isnan(time)) return {};
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", time);
  return concat(" (t = ", text, ")");
}

std::size_t nearest(std::span<const double> times, double time) {
  std::size_t best = 0;
  for (std::size_t step = 1; step < times.size(); ++step)
    if (std::isnan(times[best]) || std::abs(times[step] - time) < std::abs(times[best] - time)) best = step;
  return best;
}

}  // namespace

std::size_t choose_time_step(std::span<const double> times, const std::string& request,
                             const std::filesystem::path& path, std::vector<std::string>& notes) {
  RHORAY_CHECK(!times.empty());
  const auto refuse = [&](const std::string& expected) -> Error {
    return {ErrorCode::usage, concat(path.string(), ", time step: found '", request, "'; expected ", expected)};
  };
  if (request == "first") return 0;
  if (request == "last") return times.size() - 1;
  if (request.empty()) {
    if (times.size() > 1)
      notes.push_back(concat("using the last of ", times.size(), " time steps", time_text(times.back()),
                             "; choose another with --time"));
    return times.size() - 1;
  }
  if (request.starts_with('#')) {
    const std::optional<std::uint64_t> step = parse_number<std::uint64_t>(std::string_view(request).substr(1));
    if (!step || *step >= times.size()) throw refuse(concat("#0 to #", times.size() - 1));
    return *step;
  }
  const std::optional<double> time = parse_number<double>(request);
  if (!time || !std::isfinite(*time)) throw refuse("first, last, #N or a time");
  if (std::all_of(times.begin(), times.end(), [](double known) { return std::isnan(known); }))
    throw refuse(concat("first, last or #0 to #", times.size() - 1, ": the steps have no times"));
  const std::size_t step = nearest(times, *time);
  if (times[step] != *time)
    notes.push_back(concat("using time step #", step, " of ", times.size(), time_text(times[step]),
                           ", the nearest to t = ", *time));
  return step;
}

void refuse_time_step(const std::string& request, const std::filesystem::path& path) {
  if (!request.empty())
    throw Error(ErrorCode::usage, concat(path.string(), ": found no time steps; expected some, for '", request, "'"));
}

}  // namespace rhoray::preprocess
