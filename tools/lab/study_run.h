#pragma once

#include <string>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "tools/analysis/measure.h"
#include "tools/analysis/table.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/version.h"

/// Common parts of the studies: the machine on which they ran, and the output of their tables.
namespace rhoray::study {

/// Machine, version and compiler, and the context of this study alone.
inline Json context_with(const Json& peculiar) {
  const tools::Machine machine = tools::this_machine();
  Json context{{"processor", machine.processor}, {"cores", machine.core_count}, {"system", machine.system},
               {"version", tools::version()},    {"commit", tools::commit()},   {"compiler", tools::compiler()}};
  context.update(peculiar);
  return context;
}

/// Refuses, before the work, an output folder in which these tables could not be published after it
/// (ErrorCode::usage).
inline void require_publishable(const tools::CommonOptions& common, const std::vector<std::string>& tables) {
  if (common.output.empty()) return;
  for (const std::string& table : tables)
    for (const char* extension : {".csv", ".json"})
      tools::require_writable(common, common.output / concat(table, extension), {});
}

/// Writes to stdout, and as CSV and JSON into the output folder, if one is given.
inline void publish(const tools::Table& table, const tools::CommonOptions& common) {
  std::fputs(tools::text_of(table).c_str(), stdout);
  if (common.output.empty()) return;
  PendingFiles files(common.force);
  files.add(common.output / (table.name + ".csv"), tools::csv_of(table));
  files.add(common.output / (table.name + ".json"), tools::json_of(table).dump(2) + "\n");
  files.publish();
}

}  // namespace rhoray::study
