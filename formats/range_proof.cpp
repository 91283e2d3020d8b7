#include "formats/range_proof.h"

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/text.h"
#include "formats/details/range_checks.h"

namespace rhoray::formats {
namespace {

/// @param findings  found so far
template <class Data>
std::uint64_t prove(const Data& data, std::size_t field, const details::CheckOptions& options,
                    details::Findings& findings) {
  const details::RangesRead read = details::check_ranges(data, field, options, findings);
  const FieldSummary& summary = data.description().fields[field];
  if (!read.values.is_empty() && !details::holds(summary.range, read.values))
    findings.add(concat("the range of field '", summary.name, "' lacks a value"), 0, [&] {
      return concat("it is ", details::interval_text(summary.range), ", its values need ",
                    details::interval_text(read.values));
    });
  if (read.has_gaps && summary.no_data_count == 0)
    findings.add(concat("field '", summary.name, "' has no data somewhere"), 0,
                 [] { return std::string("the file says that 0 values are without data"); });
  const std::vector<std::string> sentences = findings.sentences();
  if (!sentences.empty())
    throw Error(ErrorCode::invalid, concat(data.file().name(), ": ", sentences.front()),
                concat("this file cannot be used for certified results; `rhoray verify --deep ", data.file().name(),
                       "` lists all its faults"));
  return read.bytes;
}

}  // namespace

std::uint64_t prove_ranges(const BrickGrid& grid, std::size_t field, unsigned threads, const Watch& watch) {
  const DefaultFloatingPoint default_floating_point;
  details::Findings findings;
  return prove(grid, field, {.threads = threads, .watch = watch}, findings);
}

std::uint64_t prove_ranges(const TetMesh& mesh, std::size_t field, unsigned threads, const Watch& watch) {
  const DefaultFloatingPoint default_floating_point;
  const details::CheckOptions options{.threads = threads, .watch = watch};
  details::Findings findings;
  details::check_boxes_and_lists(mesh, options, findings);
  return prove(mesh, field, options, findings);
}

}  // namespace rhoray::formats
