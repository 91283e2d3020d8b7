#include <string>
#include <vector>

#include "formats/base/trouble.h"
#include "preprocess/export/counts.h"
#include "preprocess/import/numbers.h"
#include "preprocess/vdb/hand_out.h"
#include "preprocess/vdb/worker_arguments.h"
#include "preprocess/worker/child_process.h"
#include "preprocess/worker/handover.h"

namespace {

using namespace rhoray;
using namespace rhoray::preprocess;

/// Without --memory a grid may become this large when dense.
constexpr std::uint64_t usual_dense_limit = std::uint64_t{4} << 30;

std::uint64_t limit_of(const std::string& text) {
  const std::optional<std::uint64_t> limit = parse_number<std::uint64_t>(text);
  if (!limit) throw Error(Trouble::usage, concat("limit: found '", text, "'; expected a number of bytes"));
  return *limit != 0 ? *limit : usual_dense_limit;
}

void act(const std::vector<std::string>& arguments, int output) {
  const std::string verb = arguments.empty() ? "" : arguments[0];
  if (verb == "info" && arguments.size() == 2)
    hand_over_facts(arguments[1], output);
  else if (verb == "nanovdb" && arguments.size() == 3)
    hand_over_nanovdb(read_scalar_grid(arguments[1], arguments[2]), output);
  else if (verb == "volume" && arguments.size() == 4)
    hand_over(dense_volume(read_scalar_grid(arguments[1], arguments[2]), limit_of(arguments[3]), arguments[1]), output);
  else if (verb == "write" && arguments.size() == 5 && (arguments[4] == ".vdb" || arguments[4] == ".nvdb"))
    hand_over_counts({write_vdb(arguments[1], arguments[2], arguments[3], arguments[4] == ".nvdb")}, output);
  else
    throw Error(Trouble::usage,
                "found arguments that no verb has; expected those of preprocess/vdb/worker_arguments.h");
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return worker_main([&](int, int output) { act(arguments, output); });
}
