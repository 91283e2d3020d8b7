#pragma once

#include <string>
#include <vector>

#include "formats/packed_file.h"

namespace rhoray::tools {

/// Names of the arrays that have bytes in the block, in the file's order; empty when only padding
/// lies there.
std::vector<std::string> arrays_touched(const formats::PackedFile& file, const formats::DamagedBlock& block);

/// "bytes 4096 to 69631 are damaged (arrays samples, macro.1)".
std::string damage_text(const formats::PackedFile& file, const formats::DamagedBlock& block);

/// The packed file as messages about damage name it: its path, or "the packed copy of head.nrrd".
std::string packed_name(const formats::PackedFile& file);

/// Says how to list all damaged blocks, or how to remove a damaged packed copy.
std::string damage_hint(const formats::PackedFile& file);

/// Reads a file once, and refuses it with its first damaged block (ErrorCode::invalid).
/// @param threads  0 = all cores
void refuse_damage(const formats::PackedFile& file, unsigned threads, const Watch& watch = {});

}  // namespace rhoray::tools
