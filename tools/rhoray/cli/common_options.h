#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "preprocess/progress.h"
#include "tools/rhoray/cli/option_values.h"

namespace rhoray::tools {

/// Options shared by subcommands. Each subcommand offers those that apply to it.
struct CommonOptions {
  std::filesystem::path output;  ///< empty when not given
  bool force = false;
  unsigned threads = 0;  ///< 0 = all cores
  ByteCount memory;      ///< 0 = not limited
  bool quiet = false;
  bool verbose = false;
  std::string progress = "auto";
  bool json = false;
};

/// -o, --force
std::vector<Option> output_options(CommonOptions& common, const std::string& help, const std::string& value = "FILE");
std::vector<Option> threads_option(CommonOptions& common);             ///< --threads
Option memory_option(CommonOptions& common, const std::string& help);  ///< --memory
/// --memory of a worker process, for experts.
Option worker_memory_option(CommonOptions& common, const std::string& worker);
/// -q, -v, --progress, --json
std::vector<Option> message_options(CommonOptions& common, const std::string& json_help);

// Options of `pack` and `import` for meshes.
Option max_error_option(std::optional<double>& max_error);  ///< --max-error
Option time_option(std::string& time);                      ///< --time

/// The rows of several lists, in order.
std::vector<Option> all_options(std::initializer_list<std::vector<Option>> lists);

/// Puts a line on stderr, unless quiet.
void say(const CommonOptions& common, const std::string& line);
/// Puts a line on stderr when verbose.
void tell(const CommonOptions& common, const std::string& line);

/// Refuses an output that could not be written at the end of the work: the folder is missing, the
/// name is that of a folder, a file exists and --force is not given, or it is the input
/// (ErrorCode::usage).
void require_writable(const CommonOptions& common, const std::filesystem::path& output,
                      const std::filesystem::path& input);

/// The words of a command line as a shell would read them.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace rhoray::tools
