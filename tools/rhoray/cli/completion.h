#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

/// What may stand at the place of a word of a command line.
struct Completion {
  struct Candidate {
    std::string word;
    std::string help;  ///< may be empty
  };
  enum class Paths { none, files, folders };

  std::vector<Candidate> candidates;
  Paths paths = Paths::none;  ///< the shell completes these by itself
};

/// The names of the fields of a file; empty if it cannot be read at once.
using FieldsOfFile = std::function<std::vector<std::string>(const std::filesystem::path&)>;

/// What may stand in place of the last of the words behind `rhoray`, which may be empty. Candidates
/// begin with it. Behind `--option=` they are values, without the option.
Completion completion_of(std::span<const Subcommand> subcommands, std::span<const std::string> words,
                         const FieldsOfFile& fields_of);

/// The form in which `rhoray complete` prints it: a line for each candidate, with its help behind a
/// tab, and at the end a line ":files" or ":folders" if the shell is to add paths.
std::string text_of(const Completion& completion);

}  // namespace rhoray::tools
