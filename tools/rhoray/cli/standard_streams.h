#pragma once

namespace rhoray::tools {

/// Gives the descriptors 0 to 2 to nobody else: where one of them is closed, the next file that is
/// opened would get it, and messages would go into that file. Writing to an output that was closed
/// still fails. To be called first in main.
void keep_standard_descriptors();

/// Writes what is left for standard output. Where not all of it could be written, says so on stderr
/// and returns ErrorCode::resource in the place of success; where its reader has gone, returns 141
/// and says nothing.
/// @param exit_code  what the program would end with
int finish_standard_output(int exit_code);

}  // namespace rhoray::tools
