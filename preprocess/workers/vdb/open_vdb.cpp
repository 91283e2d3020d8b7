#include "preprocess/open_vdb.h"

#include "preprocess/process/child_process.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/worker_names.h"
#include "preprocess/workers/vdb/facts.h"

namespace rhoray::preprocess {
namespace {

formats::PackedFile run(std::vector<std::string> arguments, const std::filesystem::path& path,
                        std::uint64_t memory_limit_bytes) {
  WorkerRequest request;
  request.program = vdb_worker;
  request.doing = "reading " + path.string();
  request.arguments = std::move(arguments);
  request.memory_limit_bytes = memory_limit_bytes;
  std::error_code ignored;
  if (const std::uintmax_t bytes = std::filesystem::file_size(path, ignored); !ignored) request.input_bytes = bytes;
  return run_worker(request);
}

}  // namespace

bool is_vdb(const std::filesystem::path& path) {
  return extension_of(path) == ".vdb";
}

formats::PackedFile open_vdb(const std::filesystem::path& path, const std::string& field,
                             std::uint64_t memory_limit_bytes) {
  return run({"nanovdb", path.string(), field}, path, memory_limit_bytes);
}

std::vector<VdbGridFacts> inspect_vdb(const std::filesystem::path& path, std::uint64_t memory_limit_bytes) {
  return take_facts(run({"info", path.string()}, path, memory_limit_bytes));
}

}  // namespace rhoray::preprocess
