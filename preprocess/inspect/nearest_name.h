#pragma once

#include <span>
#include <string>
#include <string_view>

namespace rhoray::preprocess {

/// The name that takes the fewest letters put in, left out or exchanged to become the one asked for, capitals or not;
/// empty when none is near: more than half of the longer one's letters differ.
std::string nearest_name(std::string_view asked, std::span<const std::string> names);

}  // namespace rhoray::preprocess
