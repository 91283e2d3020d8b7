#include "formats/format_error.h"

namespace rhoray::formats {

void refuse(std::string_view file, std::string_view place, std::string_view found, std::string_view expected,
            Trouble trouble) {
  throw Error(trouble, concat(file, ", ", place, ": found ", found, "; expected ", expected));
}

}  // namespace rhoray::formats
