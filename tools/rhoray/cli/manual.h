#pragma once

#include <span>
#include <string>

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

// Manual pages in mdoc(7), from the tables that make the help.

/// The page rhoray-NAME(1).
/// @param date  "2026-11-27"
std::string manual_page(const Subcommand& subcommand, const std::string& date);

/// The page rhoray(1).
std::string manual_page(std::span<const Subcommand> subcommands, const std::string& date);

}  // namespace rhoray::tools
