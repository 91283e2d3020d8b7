// Only in builds with the thread sanitizer: OpenVDB's loops have one thread, because they run on
// oneTBB, whose synchronisation this sanitizer does not see.
#include <tbb/global_control.h>

namespace {

const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);

}  // namespace
