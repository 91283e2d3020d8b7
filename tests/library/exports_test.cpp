// The symbols and headers that other programs see.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <sstream>

#include "rhoray/rhoray.h"
#include "tests/support/run_program.h"

namespace rhoray::tests {
namespace {

std::vector<std::string> lines_of(const std::vector<std::string>& words) {
  const RunResult run = run_program(words);
  EXPECT_EQ(run.exit_code, 0) << words[0] << ": " << run.err;
  std::vector<std::string> lines;
  std::istringstream text(run.out);
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::vector<std::filesystem::path> public_headers() {
  std::vector<std::filesystem::path> headers;
  for (const auto& entry : std::filesystem::directory_iterator(RHORAY_SOURCE_DIR "/tools/library/rhoray"))
    if (entry.path().extension() == ".h") headers.push_back(entry.path().filename());
  headers.emplace_back("version.h");
  std::sort(headers.begin(), headers.end());
  return headers;
}

/// Runs the compiler on a text, with the library's include paths only.
RunResult compiled(const std::string& text, const std::vector<std::string>& options) {
  const TemporaryFolder folder;
  write_file(folder / "user.cpp", text);
  std::vector<std::string> words{RHORAY_COMPILER, "-std=c++20", "-I" RHORAY_SOURCE_DIR "/tools/library",
                                 "-I" RHORAY_BINARY_DIR "/tools/library"};
  words.insert(words.end(), options.begin(), options.end());
  words.push_back(folder / "user.cpp");
  return run_program(words);
}

TEST(Exports, belong_to_one_namespace) {
  // Address and kind come before the name.
  const std::regex line_form(R"([0-9a-f]+ [A-Za-z] (.*))");
  std::size_t functions = 0;
  for (const std::string& line : lines_of({"nm", "-DC", "--defined-only", RHORAY_LIBRARY_FILE})) {
    std::smatch parts;
    ASSERT_TRUE(std::regex_match(line, parts, line_form)) << line;
    const std::string name = parts[1];
    EXPECT_THAT(name, testing::MatchesRegex("((typeinfo|typeinfo name|vtable) for )?rhoray::v0_1::.*"));
    EXPECT_THAT(name, testing::Not(testing::HasSubstr("::inside::")));
    EXPECT_THAT(name, testing::Not(testing::HasSubstr("Implementation::")));
    EXPECT_THAT(name, testing::Not(testing::HasSubstr("guard variable")));
    ++functions;
  }
  EXPECT_GT(functions, 80U);
}

TEST(Exports, are_declared_in_public_headers) {
  std::string headers;
  for (const std::filesystem::path& header : public_headers())
    if (header != "version.h")
      headers += read_file(std::filesystem::path(RHORAY_SOURCE_DIR "/tools/library/rhoray") / header);
  headers += read_file(RHORAY_BINARY_DIR "/tools/library/rhoray/version.h");
  const std::regex last_name(R"(rhoray::v0_1::(?:\w+::)?(~?\w+|operator[^(]+)(?:\[abi:cxx11\])?(?:\(.*)?)");
  for (const std::string& line : lines_of({"nm", "-DC", "--defined-only", RHORAY_LIBRARY_FILE})) {
    const std::string name = line.substr(line.find("rhoray::"));
    std::smatch parts;
    ASSERT_TRUE(std::regex_match(name, parts, last_name) || std::regex_search(name, parts, last_name)) << name;
    EXPECT_NE(headers.find(parts[1].str()), headers.npos) << name;
  }
}

TEST(Exports, need_nothing_that_acts_on_the_whole_process) {
  const std::set<std::string> forbidden{
      "exit",    "_exit",        "quick_exit",    "abort",    "getenv", "secure_getenv", "setenv",
      "putenv",  "signal",       "sigaction",     "fork",     "vfork",  "system",        "setlocale",
      "printf",  "fprintf",      "vprintf",       "vfprintf", "fputs",  "fputc",         "puts",
      "putchar", "__printf_chk", "__fprintf_chk", "chdir",    "fchdir", "umask",         "atexit"};
  std::size_t needed = 0;
  for (const std::string& line : lines_of({"nm", "-D", "--undefined-only", RHORAY_LIBRARY_FILE})) {
    std::istringstream words(line);
    std::string kind, name;
    words >> kind >> name;
    EXPECT_FALSE(forbidden.contains(name.substr(0, name.find('@')))) << line;
    EXPECT_THAT(name, testing::Not(testing::MatchesRegex("_ZSt4(cout|cerr|clog).*")));
    ++needed;
  }
  EXPECT_GT(needed, 50U);
}

TEST(Exports, link_no_library_of_the_importers) {
  std::set<std::string> allowed{"libtbb",    "libgmp", "libpng16", "libhwy", "libImath-3_1",    "libxxhash",
                                "libstdc++", "libm",   "libgcc_s", "libc",   "ld-linux-x86-64", "ld-linux-aarch64"};
#ifdef __SANITIZE_THREAD__
  allowed.insert("libtsan");
#endif
  for (const std::string& line : lines_of({"objdump", "-p", RHORAY_LIBRARY_FILE})) {
    std::istringstream words(line);
    std::string key, name;
    words >> key >> name;
    EXPECT_TRUE(key != "NEEDED" || allowed.contains(name.substr(0, name.find(".so")))) << name;
    EXPECT_TRUE(key != "SONAME" || name == "librhoray.so.0.1") << name;
  }
}

TEST(Headers, compile_alone_with_warnings) {
  const std::vector<std::filesystem::path> headers = public_headers();
  EXPECT_GE(headers.size(), 14U);
  for (const std::filesystem::path& header : headers) {
    const RunResult run =
        compiled("#include <rhoray/" + header.string() + ">\n",
                 {"-fsyntax-only", "-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Wpedantic", "-Werror"});
    EXPECT_EQ(run.exit_code, 0) << header << '\n' << run.err;
  }
}

TEST(Headers, let_users_leave_members_out_without_a_warning) {
  const RunResult run = compiled(R"(#include <rhoray/rhoray.h>
using namespace rhoray;
void use(const Dataset& data) {
  Scene scene{.layers = {{.data = data, .show = Slice{.plane = {.normal = {1, 0, 0}}}}}};
  scene.clip = Clip{.planes = {{.normal = {0, 0, 1}}}};
  scene.layers[0].material = Material{.opacity = 0.5};
  scene.camera = Camera{.position = {1, 2, 3}};
  const GridArrays grid{.fields = {{.name = "f", .values = {}}}, .world_from_grid = Affine{.x_axis = {2, 0, 0}}};
  const MeshArrays mesh{.points = {}, .tetrahedra = {}};
  const Rays rays{.origins = {}, .directions = {}};
  const Hits hits{.cell = {}};
  const PackOptions pack{.replace_existing = true};
  const RenderOptions options{.window = Rect{.x = 1}};
  const Passes passes{.first_spacing = 4};
  const ContextOptions context{.machine = Machine::scalar};
  const PackOptions wrap{.memory = Memory::wrap};
  const Goal goal{.machine = Machine::baseline};
  static_cast<void>(context), static_cast<void>(wrap), static_cast<void>(goal);
  static_cast<void>(grid), static_cast<void>(mesh), static_cast<void>(rays), static_cast<void>(hits);
  static_cast<void>(pack), static_cast<void>(options), static_cast<void>(passes);
}
)",
                                 {"-fsyntax-only", "-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Werror"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST(Headers, include_no_more_than_they_need) {
  const RunResult run = compiled("#include <rhoray/rhoray.h>\n", {"-E"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LE(std::count(run.out.begin(), run.out.end(), '\n'), 97000);
  for (const char* const other : {"/Imath/", "/tbb/", "/nlohmann/", "/hwy/", "/png.h", "/formats/", "/render/"})
    EXPECT_THAT(run.out, testing::Not(testing::HasSubstr(other)));
  const RunResult names = compiled("#include <rhoray/fwd.h>\n", {"-E"});
  EXPECT_LE(std::count(names.out.begin(), names.out.end(), '\n'), 200);
}

#define RHORAY_TEXT_OF(...) #__VA_ARGS__
#define RHORAY_TEXT(...) RHORAY_TEXT_OF(__VA_ARGS__)

TEST(Headers, have_the_projects_version) {
  const std::string minor = std::to_string(RHORAY_VERSION_MAJOR) + "_" + std::to_string(RHORAY_VERSION_MINOR);
  EXPECT_EQ(RHORAY_TEXT(RHORAY_ABI), "inline v" + minor);
  EXPECT_STREQ(RHORAY_VERSION, RHORAY_PROJECT_VERSION);
  EXPECT_STREQ(library_version(), RHORAY_VERSION);
}

TEST(Errors, are_caught_as_they_are_thrown) {
  const Error error(ErrorCode::invalid, "found", "mend it");
  const Error copy = error;
  EXPECT_STREQ(copy.what(), "found");
  EXPECT_EQ(copy.hint(), "mend it");
  EXPECT_EQ(copy.code(), ErrorCode::invalid);
  EXPECT_THROW(Dataset::open("none.rho"), std::runtime_error);
}

}  // namespace
}  // namespace rhoray::tests
