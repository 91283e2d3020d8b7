#include <string>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/import/volume/image_slices.h"
#include "preprocess/import/worker_arguments.h"
#include "preprocess/process/child_process.h"
#include "preprocess/process/foreign_file.h"
#include "preprocess/process/messages.h"

// A separate program: OpenImageIO takes longer to load than most imports take.
int main(int count, char** words) {
  using namespace rhoray;
  using namespace rhoray::preprocess;
  const std::vector<std::string> arguments(words + 1, words + count);
  return worker_main([&](int, int output) {
    if (arguments.size() < 4 || (arguments[0] != "volume" && arguments[0] != "colors"))
      throw Error(ErrorCode::usage, "found arguments that no verb has; expected volume or colors, PATH FIELD TIME");
    const VolumeRequest request = volume_request(arguments);
    NeutralVolume slices =
        request.colors ? read_color_slices(arguments[1]) : read_image_slices(arguments[1], request.field);
    slices.sources = noted_sources();
    send(slices, output);
  });
}
