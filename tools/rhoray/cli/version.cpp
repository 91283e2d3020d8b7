#include "tools/rhoray/cli/version.h"

#include "formats/base/text.h"
#include "rhoray_commit.h"  // written by write_commit.cmake at every build

namespace rhoray::tools {

std::string version() {
  return RHORAY_VERSION;
}
std::string commit() {
  return RHORAY_COMMIT;
}
std::string compiler() {
  return concat(RHORAY_COMPILER, ", ", RHORAY_BUILD_TYPE);
}
std::string version_line() {
  return concat("rhoray ", version(), " (commit ", commit(), ", ", compiler(), ")");
}

}  // namespace rhoray::tools
