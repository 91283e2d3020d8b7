#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tools/rhoray/cli/subcommand.h"

namespace rhoray::tools {

/// Candidates for a word of a command line.
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

/// Completes the last word, which may be empty: candidates begin with it. After `--option=` they
/// are values, without the option.
/// @param words  of the command line, without `rhoray`
Completion completion_of(std::span<const Subcommand> subcommands, std::span<const std::string> words,
                         const FieldsOfFile& fields_of);

/// The output of `rhoray complete`: a line for each candidate, with its help after a tab. A last
/// line ":files" or ":folders" tells the shell to add paths.
std::string text_of(const Completion& completion);

}  // namespace rhoray::tools
