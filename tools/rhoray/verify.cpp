#include <algorithm>
#include <cstdio>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/brick_grid.h"
#include "formats/color_grid.h"
#include "formats/intact.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/input_file.h"
#include "tools/rhoray/cli/command_line.h"
#include "tools/rhoray/cli/options.h"
#include "tools/rhoray/cli/progress_display.h"
#include "tools/rhoray/damage.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/subcommands.h"

namespace rhoray::tools {

namespace {

struct VerifyOptions {
  CommonOptions common;
  std::vector<std::filesystem::path> files;
  bool deep = false;
};

/// The findings in one file; all empty if it is undamaged.
struct Findings {
  std::vector<formats::DamagedBlock> blocks;
  std::vector<std::string> sentences;  ///< beyond damaged blocks
  std::uint64_t file_bytes = 0;
  Json json_blocks = Json::array();

  bool none() const { return blocks.empty() && sentences.empty(); }
};

/// Findings in the content according to the file's kind, or why it could not be read.
std::vector<std::string> content_findings(const formats::PackedFile& file, bool deep) {
  try {
    if (file.description().kind == "grid") {
      const formats::BrickGrid grid(file);
      return deep ? formats::deep_findings(grid) : std::vector<std::string>{};
    }
    if (file.description().kind == formats::ColorGrid::kind) {
      const formats::ColorGrid grid(file);
      return {};  // every texel is a colour: there is nothing deeper
    }
    if (file.description().kind == formats::TriangleMesh::kind) {
      const formats::TriangleMesh surface(file);
      return deep ? formats::deep_findings(surface) : std::vector<std::string>{};
    }
    if (file.description().kind == "tets") {
      const formats::TetMesh mesh(file);
      return deep ? formats::deep_findings(mesh) : std::vector<std::string>{};
    }
    throw Error(ErrorCode::unsupported, concat(file.name(), ": kind '", file.description().kind,
                                               "'; expected 'colors', 'grid', 'surface' or 'tets'"));
  } catch (const Error& error) {
    if (error.code() != ErrorCode::invalid) throw;
    return {error.what()};
  }
  return {};
}

Findings examine(const std::filesystem::path& path, const VerifyOptions& options, ProgressDisplay& display) {
  Findings findings;
  preprocess::require_input(path);
  require_packed(path);
  try {
    const formats::PackedFile file = formats::PackedFile::open(path);
    findings.file_bytes = file.file_bytes();
    display.show(concat("checking ", path.string()));
    findings.blocks = file.damaged_blocks(options.common.threads, {{}, display.progress()});
    for (const formats::DamagedBlock& block : findings.blocks)
      findings.json_blocks.push_back({{"first_byte", block.first_byte},
                                      {"byte_count", block.byte_count},
                                      {"arrays", arrays_touched(file, block)}});
    for (const formats::DamagedBlock& block : findings.blocks)
      findings.sentences.push_back(concat(path.string(), ", ", damage_text(file, block)));
    if (findings.blocks.empty()) findings.sentences = content_findings(file, options.deep);
    formats::require_intact(file);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::invalid) throw;
    findings.sentences.push_back(error.what());
  }
  return findings;
}

void print(const std::filesystem::path& path, const Findings& findings, const VerifyOptions& options) {
  if (options.common.json) {
    const Json json{{"file", path.string()},
                    {"ok", findings.none()},
                    {"file_bytes", findings.file_bytes},
                    {"deep", options.deep},
                    {"damaged_blocks", findings.json_blocks},
                    {"findings", findings.sentences}};
    std::puts(dump(json).c_str());
    return;
  }
  for (const std::string& sentence : findings.sentences) std::puts(sentence.c_str());
  if (findings.none())
    std::puts(concat(path.string(), ": sound (", bytes_text(findings.file_bytes),
                     options.deep ? ", values included" : "", ")")
                  .c_str());
}

int run(const VerifyOptions& options) {
  ProgressDisplay display(options.common);
  int result = 0;
  for (const std::filesystem::path& path : options.files) {
    try {
      const Findings findings = examine(path, options, display);
      print(path, findings, options);
      if (!findings.none()) result = std::max(result, static_cast<int>(ErrorCode::invalid));
    } catch (const Error& error) {
      std::fputs(error_lines("rhoray verify", error.what(), error.hint()).c_str(), stderr);
      result = std::max(result, static_cast<int>(error.code()));
    }
  }
  return result;
}

}  // namespace

Subcommand verify_subcommand() {
  const auto options = std::make_shared<VerifyOptions>();
  return {.name = "verify",
          .summary = "Check packed files for damage",
          .group = "Files",
          .examples = {"rhoray verify head.rho torso.rho", "rhoray verify head.rho --deep --json"},
          .sections = {{.heading = "Exit codes",
                        .entries = {{"0", "no damage"}, {"3", "a file could not be read"}, {"4", "damage found"}}}},
          .options = all_options(
              {{files_option("FILE", "Packed files", options->files),
                flag_option("--deep", "Also check every value: ranges, macrocells, boxes, leaf lists", options->deep)},
               threads_option(options->common),
               message_options(options->common, "Print one JSON document per file to stdout, one per line")}),
          .run = [options] { return run(*options); }};
}

}  // namespace rhoray::tools
