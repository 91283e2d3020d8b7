#pragma once

#include <functional>
#include <string>
#include <vector>

namespace rhoray::tools {

/// One row of a subcommand's options: how it is spelled, what it takes, what it does, and where the
/// answer goes.
struct Option {
  enum class Kind {
    flag,    ///< takes no value; `take` is called with an empty text
    answer,  ///< the same, and it is all that is done, as with --help: no file need be given, nothing is run
    value,   ///< takes one value, the last that is given; all where the value's name ends in "..."
    file,    ///< a positional argument that must be there
    files    ///< as many positional arguments as there are, at least one
  };

  /// Other options that have no effect beside this one. A later option replaces earlier ones, so
  /// that a printed command can be changed by adding to it.
  struct Replaces {
    std::string value;               ///< only if it is given with this value; empty: with any
    bool only_after_another;         ///< only if it was given before with another value
    std::vector<std::string> names;  ///< "--iso"
  };

  Kind kind = Kind::value;
  std::string names;  ///< "-o,--output", or "FILE" for a positional argument
  std::string value;  ///< what stands for the value in the help: "WxH"
  std::string help;   ///< at most two sentences, without the last full stop; the default comes last: "default 30"
  std::function<void(const std::string&)> take;  ///< refuses with an Error (ErrorCode::usage); see options.h
  std::vector<std::string> choices{};            ///< the words that are accepted; empty: also other values
  std::string details{};                         ///< more sentences, which --help-all adds
  std::string group = "Options";                 ///< heading in the help
  bool is_expert = false;                        ///< --help leaves it out, --help-all shows it
  std::vector<Replaces> replaces{};
};

/// A part of the help that is not about options.
struct HelpSection {
  struct Entry {
    std::string term;  ///< empty: the text is a paragraph
    std::string text;
  };

  std::string heading;
  std::vector<Entry> entries;
  bool is_expert = false;  ///< --help leaves it out, --help-all shows it
};

struct Subcommand {
  std::string name;
  std::string summary;
  std::string group = "Subcommands";    ///< heading in the overview
  std::vector<std::string> examples;    ///< work when the files they name are there; --help shows the first three
  std::vector<HelpSection> sections{};  ///< follow the options in the help
  std::vector<Option> options;
  std::function<int()> run;  ///< returns the exit code
};

}  // namespace rhoray::tools
