// Every subcommand ends with the same exit code for the same kind of input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/tools/workbench.h"

namespace rhoray::tests {
namespace {

/// The kinds of input that a subcommand may accept.
enum class Takes { packed, data, mesh, surface, packed_mesh, picture };

struct Command {
  std::vector<std::string> words;  ///< IN stands for the input
  std::vector<Takes> takes;
};

const Command commands[] = {
    {{"info", "IN"}, {Takes::packed, Takes::data, Takes::mesh, Takes::surface}},
    {{"verify", "IN"}, {Takes::packed}},
    {{"pack", "IN", "-o", "x.rho"}, {Takes::data, Takes::mesh, Takes::surface}},
    {{"export", "IN", "-o", "x.vti"}, {Takes::packed, Takes::data, Takes::mesh, Takes::surface}},
    {{"import", "IN", "-o", "x.vtu"}, {Takes::mesh}},
    {{"tetrahedralize", "IN", "-o", "x.vtu"}, {Takes::surface}},
    {{"resample", "IN", "--size", "8", "-o", "x.rho"}, {Takes::mesh}},
    {{"render", "IN", "-o", "x.png"}, {Takes::packed, Takes::data, Takes::mesh, Takes::surface}},
    {{"accuracy", "IN", "-o", "x"}, {Takes::packed, Takes::data, Takes::mesh, Takes::surface}},
    {{"validate", "IN", "--iso", "1"}, {Takes::packed, Takes::data, Takes::mesh, Takes::surface}},
    {{"measure", "IN"}, {Takes::packed, Takes::data, Takes::mesh, Takes::surface}},
    {{"bench", "views", "IN"}, {Takes::packed, Takes::data, Takes::mesh, Takes::surface}},
    {{"compare", "IN", "IN"}, {Takes::picture}}};

bool takes(const Command& command, Takes kind) {
  return std::find(command.takes.begin(), command.takes.end(), kind) != command.takes.end();
}

RunResult run(const Workbench& bench, const Command& command, const std::string& input) {
  std::vector<std::string> words = command.words;
  std::replace(words.begin(), words.end(), std::string("IN"), input);
  words.emplace_back("-q");
  return bench.rhoray(words);
}

void expect_code(const Workbench& bench, const Command& command, const std::string& input, int code) {
  const RunResult result = run(bench, command, input);
  EXPECT_EQ(result.exit_code, code) << command.words[0] << " " << input << ": " << result.err;
  EXPECT_LE(std::count(result.err.begin(), result.err.end(), '\n'), 2) << result.err;
}

TEST(InputKinds, that_are_missing_or_folders_are_unreadable) {
  const Workbench bench;
  std::filesystem::create_directory(bench / "folder");
  for (const Command& command : commands)
    for (const char* const input :
         {"missing.rho", "missing.nrrd", "missing.vtu", "missing.stl", "missing.png", "folder"})
      expect_code(bench, command, input, 3);
}

/// A name that no reader knows: text, nothing at all, or samples without a header.
TEST(InputKinds, of_unknown_type_are_unsupported) {
  const Workbench bench;
  bench.make_ball_raw();
  write_file(bench / "notes.txt", "nothing to see");
  write_file(bench / "notes", "nothing to see");
  write_file(bench / "empty.txt", "");
  for (const Command& command : commands)
    for (const char* const input : {"notes.txt", "notes", "empty.txt", "ball.raw"})
      expect_code(bench, command, input, 7);
}

/// Empty, or with other text than the name says: damaged for those that take such files, and of a
/// kind that is not taken for all others.
TEST(InputKinds, that_are_not_what_their_name_says_are_damaged) {
  const Workbench bench;
  const std::pair<const char*, Takes> kinds[] = {{".rho", Takes::packed},
                                                 {".nrrd", Takes::data},
                                                 {".vtu", Takes::mesh},
                                                 {".stl", Takes::surface},
                                                 {".png", Takes::picture}};
  for (const auto& [extension, kind] : kinds)
    for (const auto& [stem, text] : {std::pair{"empty", ""}, {"notes", "nothing to see"}}) {
      const std::string input = std::string(stem) + extension;
      write_file(bench / input, text);
      for (const Command& command : commands) {
        // A picture is a slice of a volume, and compare knows the formats of pictures alone.
        const bool is_taken = takes(command, kind) || (kind == Takes::picture && takes(command, Takes::data));
        expect_code(bench, command, input, is_taken ? 4 : 7);
      }
    }
}

TEST(InputKinds, that_are_sound_are_never_called_damaged) {
  const Workbench bench;
  bench.make_ball();
  bench.make_box();
  bench.make_cube();
  bench.make_photo();
  const auto expect_unsupported = [&](const std::string& input, const std::vector<std::string>& subcommands) {
    for (const Command& command : commands)
      if (std::find(subcommands.begin(), subcommands.end(), command.words[0]) != subcommands.end())
        expect_code(bench, command, input, 7);
  };
  expect_unsupported("ball.rho", {"pack", "import", "tetrahedralize", "resample", "compare"});
  expect_unsupported("box.rho", {"pack", "export", "import", "tetrahedralize", "compare"});
  expect_unsupported("box.vtu", {"verify", "export", "tetrahedralize", "compare"});
  expect_unsupported("cube.off",
                     {"verify", "export", "import", "resample", "accuracy", "validate", "measure", "bench", "compare"});
  expect_unsupported("cube.rho", {"pack", "export", "import", "tetrahedralize", "resample", "accuracy", "validate",
                                  "measure", "bench", "compare"});
  expect_unsupported("photo.rho", {"pack", "export", "import", "tetrahedralize", "resample", "render", "accuracy",
                                   "validate", "measure", "bench", "compare"});
  // A volume of the magnitude of its colours.
  expect_unsupported("photo.nrrd", {"verify", "import", "tetrahedralize", "resample", "compare"});
  for (const Command& command : commands)
    if (command.words[0] == "info" || command.words[0] == "pack" || command.words[0] == "render")
      expect_code(bench, command, "photo.nrrd", 0);
}

}  // namespace
}  // namespace rhoray::tests
