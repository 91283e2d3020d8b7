#pragma once

#include <string>
#include <utility>
#include <vector>

namespace rhoray::tools {

/// Explains the rows of the results to someone who has never seen them. Each entry is a group, or a
/// row of a group, and a sentence.
/// @param groups  the groups that were examined
std::vector<std::pair<std::string, std::string>> variant_words(const std::vector<std::string>& groups, bool is_mesh,
                                                               bool is_projection);

}  // namespace rhoray::tools
