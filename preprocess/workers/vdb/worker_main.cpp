#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/process/child_process.h"
#include "preprocess/process/counts.h"
#include "preprocess/process/messages.h"
#include "preprocess/process/worker_names.h"
#include "preprocess/workers/vdb/hand_out.h"

namespace {

using namespace rhoray;
using namespace rhoray::preprocess;

/// How large a grid may become when dense: half of the memory that this process may have, beside
/// the sparse one.
std::uint64_t dense_limit() {
  constexpr std::uint64_t usual_limit = std::uint64_t{4} << 30;
  rlimit memory{};
  if (::getrlimit(RLIMIT_DATA, &memory) != 0)
    throw Error(ErrorCode::internal, concat("the system does not tell the limit RLIMIT_DATA: ", std::strerror(errno)));
  if (memory.rlim_cur == RLIM_INFINITY) return usual_limit;
  return memory.rlim_cur / 2;
}

void act(const std::vector<std::string>& arguments, int output) {
  const std::string verb = arguments.empty() ? "" : arguments[0];
  if (verb == "info" && arguments.size() == 2)
    hand_over_facts(arguments[1], output);
  else if (verb == "nanovdb" && arguments.size() == 3)
    hand_over_nanovdb(read_scalar_grid(arguments[1], arguments[2]), output);
  else if (verb == "volume" && arguments.size() == 4)
    send(dense_volume(read_scalar_grid(arguments[1], arguments[2]), dense_limit(), arguments[1]), output);
  else if (verb == "write" && arguments.size() == 5 && (arguments[4] == ".vdb" || arguments[4] == ".nvdb"))
    hand_over_counts({write_vdb(arguments[1], arguments[2], arguments[3], arguments[4] == ".nvdb")}, output);
  else
    throw Error(ErrorCode::usage,
                "found arguments that no verb has; expected those of preprocess/process/worker_names.h");
}

}  // namespace

#ifdef __SANITIZE_ADDRESS__
// OpenVDB loses nodes when it refuses a damaged file; here they end with the process.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libopenvdb\n";
}
#endif

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return worker_main([&](int, int output) { act(arguments, output); });
}
