#pragma once

#include <vector>

#include "preprocess/open_vdb.h"

namespace rhoray::preprocess {

/// Facts as a packed file of kind "vdb-facts" with one array of texts, for the way between two
/// processes. Taking them checks that every text and number is there.
void send(const std::vector<VdbGridFacts>& grids, int descriptor);
std::vector<VdbGridFacts> take_facts(const formats::PackedFile& file);

}  // namespace rhoray::preprocess
