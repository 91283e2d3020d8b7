#include "tools/rhoray/bench/picture_hash.h"

#include <xxhash.h>

#include <cstdio>

namespace rhoray::tools {

std::string picture_hash(const render::Framebuffer& picture) {
  const XXH64_hash_t hash = XXH3_64bits(picture.color.data(), picture.color.size() * sizeof(float));
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace rhoray::tools
