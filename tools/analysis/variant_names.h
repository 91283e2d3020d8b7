#pragma once

#include <string>
#include <utility>
#include <vector>

namespace rhoray::tools {

/// What the rows of the results are, for someone who has never seen them: a group, or a row of a group, and a sentence.
/// @param groups  that were looked at
std::vector<std::pair<std::string, std::string>> variant_words(const std::vector<std::string>& groups, bool is_mesh,
                                                               bool is_projection);

}  // namespace rhoray::tools
