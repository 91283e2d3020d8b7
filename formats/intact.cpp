#include "formats/intact.h"

#include "formats/base/mapped_file.h"

namespace rhoray::formats {

void require_intact(const PackedFile& file) {
  if (file.arrays().empty()) return;  // only the header was read, and opening has checked it
  MappedFile::require_intact(file.bytes(file.arrays().front().name).data());
}

}  // namespace rhoray::formats
