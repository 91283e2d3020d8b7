#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace rhoray::tools {

/// One row of a subcommand's options: how it is spelled, what it takes, what it does, and where the
/// answer goes.
struct Option {
  enum class Kind {
    flag,    ///< takes no value; `take` is called with an empty text
    answer,  ///< the same, and it is all that is done, as with --help: no file need be given, nothing is run
    value,   ///< takes one value, at most once; each time that it is given where the value's name ends in "..."
    file,    ///< a positional argument that must be there
    files    ///< as many positional arguments as there are, at least one
  };

  Kind kind = Kind::value;
  std::string names;  ///< "-o,--output", or "FILE" for a positional argument
  std::string value;  ///< what stands for the value in the help: "WxH"
  std::string help;
  std::function<void(const std::string&)> take;  ///< refuses with an Error (ErrorCode::usage); see option_values.h
};

struct Subcommand {
  std::string name;
  std::string summary;
  std::string examples;  ///< ends the help; lines that work when the files they name are there
  std::vector<Option> options;
  std::function<int()> run;  ///< returns the exit code
};

/// Reads the command line, runs the subcommand that it names and returns the exit code. Every Error
/// that comes up ends as one line `rhoray SUBCOMMAND: fact` and, where it has one, a line `hint:
/// ...` on stderr.
int run_command_line(std::span<const Subcommand> subcommands, int argc, const char* const* argv);

/// The lines in which an Error is shown; `place` is "rhoray pack".
std::string error_lines(const std::string& place, const std::string& fact, const std::string& hint);

}  // namespace rhoray::tools
