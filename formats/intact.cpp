#include "formats/intact.h"

#include "formats/base/mapped_file.h"

namespace rhoray::formats {

void require_intact(const PackedFile& file) {
  if (file.arrays().empty()) return;  // all that was read is the header, which is checked on open
  MappedFile::require_intact(file.bytes(file.arrays().front().name).data());
}

}  // namespace rhoray::formats
