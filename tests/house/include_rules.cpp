#include "tests/house/include_rules.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <regex>
#include <span>
#include <string_view>

namespace rhoray::tests {

namespace {

using Paths = std::vector<std::string_view>;

/// Which rooms a room may look into.
struct Floor {
  std::string_view room;
  Paths may_see;
};
const Floor floors[] = {{"formats", {"formats"}},
                        {"preprocess", {"preprocess", "formats"}},
                        {"render", {"render", "formats"}},
                        {"data", {"data", "preprocess", "formats"}},
                        {"tools", {"tools", "preprocess", "render", "formats"}},
                        {"tests", {"tests", "tools", "data", "preprocess", "render", "formats"}}};

/// What the rooms inside render may look into: folders, or single files of the porch. A room that is not listed is
/// refused. The porch itself and `frame` may see all of the room.
const Floor rooms_of_render[] = {
    {"render/march", {"formats/base", "render/march", "render/cells"}},
    {"render/cells", {"formats/base", "render/cells", "render/march"}},
    {"render/judge", {"formats/base", "render/judge", "render/cells", "render/march"}},
    {"render/volumes", {"formats", "render/volumes", "render/cells", "render/march"}},
    {"render/kernels",
     {"formats", "render/kernels", "render/volumes", "render/judge", "render/cells", "render/march",
      "render/method.h"}},
    {"render/effects", {"formats/base", "render/effects", "render/kernels", "render/scene.h", "render/color_map.h"}},
    {"render/diary", {"formats/base", "render/diary", "render/diary.h", "render/framebuffer.h", "render/color_map.h"}},
    {"render/frame", {"formats", "render"}}};

/// Where a third-party library is received. `header` is a pattern for what stands between the brackets.
struct Guest {
  std::string_view name;
  std::regex header;
  Paths received_in;
};
const Guest guests[] = {
    {"TetGen", std::regex("tetgen\\.h"), {"preprocess/tetrahedralize"}},
    {"CGAL", std::regex("CGAL/.*"), {"preprocess/tetrahedralize", "preprocess/repair", "tools/validate"}},
    {"Boost", std::regex("boost/.*"), {"preprocess/tetrahedralize", "render/judge"}},
    {"VTK", std::regex("vtk\\w*\\.h"), {"preprocess/import", "tools/study"}},
    {"OpenVDB", std::regex("openvdb/.*"), {"preprocess/vdb", "tools/study"}},
    {"NanoVDB", std::regex("nanovdb/.*"), {"preprocess/vdb", "render/volumes", "tools/study"}},
    {"Embree", std::regex("embree3/.*"), {"tools/study"}},
    {"Teem", std::regex("teem/.*"), {"preprocess/import"}},
    {"netCDF", std::regex("netcdf\\.h"), {"preprocess/import"}},
    {"zlib, bzip2, minizip", std::regex("(zlib|bzlib|minizip/\\w+)\\.h"), {"preprocess/import"}},
    {"GDCM", std::regex("gdcm\\w+\\.h"), {"preprocess/import"}},
    {"oneTBB", std::regex("tbb/.*"), {"render/frame", "tools/study"}},
    {"OpenImageIO", std::regex("OpenImageIO/.*"), {"tools", "preprocess/import"}},
    {"FreeType", std::regex("ft2build\\.h|freetype/.*"), {"tools"}},
    {"Eigen", std::regex("Eigen/.*"), {"data"}},
    {"CLI11", std::regex("CLI/.*"), {"tools", "data"}},
    {"JSON for Modern C++", std::regex("nlohmann/.*"), {"formats", "tools"}},
    {"xxHash", std::regex("xxhash\\.h"), {"formats", "tools"}},
    {"Highway", std::regex("hwy/.*"), {"render/kernels/wide"}},
    {"libpng", std::regex("png\\.h"), {"render"}},
    {"Imath", std::regex("Imath/.*"), {"formats"}},
    {"Gmsh", std::regex("gmsh\\.h"), {}},
    {"GoogleTest", std::regex("(gtest|gmock)/.*"), {}}};

const std::regex standard_header("[a-z_0-9]+");
const std::regex system_header(
    "(sys/\\w+|linux/"
    "\\w+|dirent|dlfcn|execinfo|fcntl|malloc|poll|pthread|sched|semaphore|signal|spawn|stdio|stdlib|unistd)\\.h");

/// Headers that the build writes; they stand in no room.
const std::string_view generated_headers[] = {"rhoray_commit.h"};

/// True when `path` is `place` or lies in it.
bool is_in(std::string_view path, std::string_view place) {
  return path == place || (path.starts_with(place) && path[place.size()] == '/');
}

bool is_in_any(std::string_view path, const Paths& places) {
  return std::any_of(places.begin(), places.end(), [&](std::string_view place) { return is_in(path, place); });
}

std::string_view room_of(std::string_view path) {
  return path.substr(0, path.find('/'));
}

/// "render/march" of "render/march/ray.h"; nothing for what stands directly in the room.
std::optional<std::string_view> inner_room_of(std::string_view path) {
  const std::size_t first = path.find('/');
  const std::size_t second = first == path.npos ? path.npos : path.find('/', first + 1);
  if (second == path.npos) return std::nullopt;
  return path.substr(0, second);
}

const Floor* find(std::span<const Floor> list, std::string_view room) {
  for (const Floor& floor : list)
    if (floor.room == room) return &floor;
  return nullptr;
}

/// The rule that `file` breaks by including our own `header`, or nothing.
std::optional<std::string> rule_against_own(const std::filesystem::path& root, std::string_view file,
                                            std::string_view header) {
  const std::string_view room = room_of(file), target = room_of(header);
  if (!std::filesystem::exists(root / header)) return "names";
  const Floor* floor = find(floors, room);
  if (floor == nullptr || !is_in_any(header, floor->may_see)) return "floors";
  const bool on_porch = !inner_room_of(header) || is_in(header, "formats/base");
  if (target != room && room != "tests" && !on_porch) return "porches";
  if (room == "render")
    if (const auto inner = inner_room_of(file)) {
      const Floor* rules = find(rooms_of_render, *inner);
      if (rules == nullptr || !is_in_any(header, rules->may_see)) return "rooms of render";
    }
  return std::nullopt;
}

bool is_received(std::string_view file, std::string_view header) {
  const std::string text(header);
  if (std::regex_match(text, standard_header) || std::regex_match(text, system_header)) return true;
  for (const Guest& guest : guests)
    if (std::regex_match(text, guest.header)) return is_in(file, "tests") || is_in_any(file, guest.received_in);
  return false;
}

bool is_source(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".h" || extension == ".cpp";
}

void check_file(const std::filesystem::path& root, const std::string& file, std::vector<Breach>& found) {
  static const std::regex include_line("\\s*#\\s*include\\s*([<\"])([^>\"]+)[>\"].*");
  std::ifstream lines(root / file);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch parts;
    if (!std::regex_match(line, parts, include_line)) continue;
    const bool quoted = parts[1] == "\"";
    const std::string header = parts[2];
    std::optional<std::string> rule;
    if (!quoted) {
      if (!is_received(file, header)) rule = "guests";
    } else if (std::find(std::begin(generated_headers), std::end(generated_headers), header) ==
               std::end(generated_headers)) {
      rule = rule_against_own(root, file, header);
    }
    if (rule) found.push_back({file, number, quoted ? "\"" + header + "\"" : "<" + header + ">", *rule});
  }
}

}  // namespace

std::vector<Breach> breaches(const std::filesystem::path& root) {
  std::vector<std::string> files;
  for (const Floor& floor : floors) {
    const std::filesystem::path room = root / floor.room;
    if (!std::filesystem::is_directory(room)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(room))
      if (entry.is_regular_file() && is_source(entry.path()))
        files.push_back(entry.path().lexically_relative(root).generic_string());
  }
  std::sort(files.begin(), files.end());
  std::vector<Breach> found;
  for (const std::string& file : files) check_file(root, file, found);
  return found;
}

}  // namespace rhoray::tests
