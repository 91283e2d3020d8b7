#pragma once

#include <string>
#include <vector>

#include "formats/base/pending_file.h"
#include "preprocess/process/child_process.h"

namespace rhoray::preprocess {

/// Runs a worker that writes `output` by its open_name(). Its refusals are rethrown here with the
/// output's final name.
formats::PackedFile run_writer(WorkerRequest request, const PendingFile& output);

}  // namespace rhoray::preprocess
