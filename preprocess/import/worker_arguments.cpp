#include "preprocess/import/worker_arguments.h"

#include "formats/base/error.h"
#include "preprocess/import/reading/numbers.h"

namespace rhoray::preprocess {

std::vector<std::string> volume_arguments(const std::filesystem::path& path, const VolumeRequest& request) {
  const char* verb = request.colors ? "colors" : "volume";
  std::vector<std::string> arguments{verb, path.string(), request.field, request.time};
  if (!request.raw) return arguments;
  const RawVolume& raw = *request.raw;
  for (int axis = 0; axis < 3; ++axis) arguments.push_back(concat(raw.sample_count[axis]));
  arguments.push_back(concat(static_cast<int>(raw.type)));
  arguments.push_back(raw.big_endian ? "1" : "0");
  arguments.push_back(concat(raw.skipped_bytes));
  return arguments;
}

VolumeRequest volume_request(const std::vector<std::string>& arguments) {
  const auto number = [&](std::size_t i) {
    const std::optional<std::uint64_t> value = parse_number<std::uint64_t>(arguments[i]);
    if (!value)
      throw Error(ErrorCode::usage, concat("argument ", i, ": found '", arguments[i], "'; expected a number"));
    return *value;
  };
  if (arguments.size() != 4 && arguments.size() != 10)
    throw Error(ErrorCode::usage, concat("found ", arguments.size(), " arguments; expected 4 or 10"));
  VolumeRequest request;
  request.colors = arguments[0] == "colors";
  request.field = arguments[2];
  request.time = arguments[3];
  if (arguments.size() == 4) return request;
  RawVolume& raw = request.raw.emplace();
  for (int axis = 0; axis < 3; ++axis)
    raw.sample_count[axis] = static_cast<std::int64_t>(number(4 + static_cast<std::size_t>(axis)));
  if (number(7) > static_cast<std::uint64_t>(formats::ElementType::F64))
    throw Error(ErrorCode::usage, concat("argument 7: found ", number(7), "; expected the number of an element type"));
  raw.type = static_cast<formats::ElementType>(number(7));
  raw.big_endian = number(8) != 0;
  raw.skipped_bytes = number(9);
  return request;
}

}  // namespace rhoray::preprocess
