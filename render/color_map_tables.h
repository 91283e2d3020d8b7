#pragma once

namespace rhoray::render {

// Published colour maps: 256 colours each, six hexadecimal digits of sRGB a colour.
extern const char* const viridis_table;
extern const char* const magma_table;
extern const char* const inferno_table;
extern const char* const plasma_table;
extern const char* const cividis_table;
extern const char* const turbo_table;

}  // namespace rhoray::render
