#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "formats/label_names.h"

namespace rhoray::preprocess {

/// Labels and their names, as a foreign file gives them.
using GivenNames = std::vector<std::pair<std::int64_t, std::string>>;

/// Returns the names that a packed file can hold (formats::is_label_name). In a name, control
/// characters become spaces and bytes that are not UTF-8 become U+FFFD; spaces at its ends are
/// removed, and a long one is cut. Of several names of one label the first stays. Names without
/// letters are left out. A note counts all other names that are left out.
formats::LabelNames label_names_from(const GivenNames& given, std::vector<std::string>& notes);

}  // namespace rhoray::preprocess
