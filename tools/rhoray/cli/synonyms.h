#pragma once

#include <string>
#include <vector>

namespace rhoray::tools {

/// Hint for an unknown option: ours for the same purpose ("--isovalue is --iso here"), or the one
/// with nearly the same letters. Empty if there is neither.
/// @param known  options of the subcommand
std::string option_hint(const std::string& word, const std::vector<std::string>& known);

/// The same for an unknown subcommand.
std::string subcommand_hint(const std::string& word, const std::vector<std::string>& known);

}  // namespace rhoray::tools
