#include "tools/validate/request.h"

#include <nlohmann/json.hpp>

#include "formats/base/error.h"
#include "formats/base/text.h"

namespace rhoray::tools::validate {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Request, file, field, isovalue, samples, seed, threads, max_depth_error, algorithm,
                                   precision, step, slack, bisect, picture_width, picture_height)

std::string text_of(const Request& request) {
  return nlohmann::json(request).dump();
}

Request request_from(std::string_view text) {
  try {
    return nlohmann::json::parse(text).get<Request>();
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::usage, concat("not a request for a validation: ", error.what()),
                "this program is started by `rhoray validate`");
  }
}

}  // namespace rhoray::tools::validate
