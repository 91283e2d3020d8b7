#pragma once

#include <span>
#include <string>

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

/// Reads the command line, runs the subcommand that it names and returns the exit code. Every Error
/// that comes up ends as one line `rhoray SUBCOMMAND: fact` and, where it has one, a line `hint:
/// ...` on stderr.
int run_command_line(std::span<const Subcommand> subcommands, int argc, const char* const* argv);

/// The lines in which an Error is shown; `place` is "rhoray pack".
std::string error_lines(const std::string& place, const std::string& fact, const std::string& hint);

}  // namespace rhoray::tools
