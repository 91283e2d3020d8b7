#include "preprocess/process/run_writer.h"

#include "formats/base/error.h"

namespace rhoray::preprocess {

formats::PackedFile run_writer(WorkerRequest request, const PendingFile& output) {
  request.doing = "writing " + output.name();
  try {
    return run_worker(request);
  } catch (const Error& error) {
    std::string fact = error.what();
    const std::string passing = output.open_name().string();
    for (std::size_t at = 0; (at = fact.find(passing, at)) != std::string::npos; at += output.name().size())
      fact.replace(at, passing.size(), output.name());
    throw Error(error.code(), fact, error.hint());
  }
}

}  // namespace rhoray::preprocess
