#include "tests/house/include_rules.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <span>
#include <string_view>

namespace rhoray::tests {

namespace {

using Paths = std::vector<std::string_view>;

/// What a room, or a folder inside a room, may include besides itself.
struct Layer {
  std::string_view place;
  Paths may_see;
};
const Layer rooms[] = {{"formats", {}},
                       {"preprocess", {"formats"}},
                       {"render", {"formats"}},
                       {"data", {"preprocess", "formats"}},
                       {"tools", {"preprocess", "render", "formats"}},
                       {"tests", {"tools", "data", "preprocess", "render", "formats"}}};

/// From the lowest layer to the highest. `place` is a folder without its subfolders, or a unit that
/// stands above the folder's subfolders: its file names without their endings. What may be seen are
/// folders and single files; "formats" means its public headers. Files directly in a room's folder
/// may include all of the room. A folder that is not listed is refused.
const Layer layers[] = {
    {"render/traverse", {"formats/base"}},
    {"render/cell", {"formats/base", "render/traverse"}},
    {"render/exact", {"formats/base", "render/traverse", "render/cell"}},
    {"render/grid", {"formats", "render/traverse", "render/cell", "render/query/last_isovalues.h"}},
    {"render/tets", {"formats", "render/traverse", "render/cell"}},
    {"render/triangles", {"formats", "render/traverse", "render/cell", "render/tets", "render/query/last_isovalues.h"}},
    {"render/dataset", {"formats", "render/grid", "render/tets", "render/triangles"}},
    {"render/query", {"formats/base", "render/traverse", "render/cell", "render/dataset", "render/method.h"}},
    {"render/grid/reference", {"formats/base", "render/traverse", "render/cell", "render/exact", "render/query"}},
    {"render/grid/isosurface",
     {"formats", "render/traverse", "render/cell", "render/grid", "render/dataset", "render/query",
      "render/grid/reference"}},
    {"render/grid/all_hits", {"formats", "render/traverse", "render/query", "render/grid/isosurface"}},
    {"render/grid/largest",
     {"formats", "render/traverse", "render/grid", "render/dataset", "render/query", "render/grid/reference"}},
    {"render/tets/reference", {"formats", "render/traverse", "render/cell", "render/exact", "render/query"}},
    {"render/shadow", {"formats", "render/query"}},
    {"render/grid/shadow",
     {"formats", "render/grid", "render/dataset", "render/query", "render/shadow", "render/grid/isosurface"}},
    {"render/grid/intersectors",
     {"render/query", "render/dataset", "render/grid/isosurface", "render/grid/all_hits", "render/grid/largest",
      "render/grid/shadow"}},
    {"render/triangles/shadow", {"formats", "render/traverse", "render/triangles", "render/query", "render/shadow"}},
    {"render/triangles/kernels",
     {"formats", "render/traverse", "render/cell", "render/tets", "render/triangles", "render/dataset", "render/query",
      "render/tets/reference", "render/shadow", "render/triangles/shadow"}},
    {"render/tets/largest",
     {"formats", "render/traverse", "render/tets", "render/query", "render/tets/reference",
      "render/triangles/kernels"}},
    {"render/tets/intersectors", {"render/query", "render/tets", "render/tets/largest", "render/triangles/kernels"}},
    {"render/triangles/intersectors", {"render/query", "render/triangles/kernels"}},
    {"render/shade",
     {"formats", "render/cell", "render/grid/smooth_gradient.h", "render/triangles", "render/dataset", "render/query",
      "render/scene.h", "render/color_map.h", "render/texture.h"}},
    {"render/frame",
     {"formats", "render", "render/traverse", "render/dataset", "render/query", "render/shadow", "render/shade"}},
    {"render/document", {"formats", "render"}},
    {"render/check", {"formats", "render"}},

    {"preprocess/process", {"formats", "preprocess"}},
    {"preprocess/values", {"formats", "preprocess"}},
    {"preprocess/mesh/inspect", {"formats", "preprocess", "preprocess/values"}},
    {"preprocess/mesh/leaf_lists", {"formats", "preprocess", "preprocess/values"}},
    {"preprocess/mesh",
     {"formats", "preprocess", "preprocess/values", "preprocess/mesh/inspect", "preprocess/mesh/leaf_lists"}},
    {"preprocess/mesh/subdivide", {"formats", "preprocess"}},
    {"preprocess/grid/bricks", {"formats", "preprocess", "preprocess/values"}},
    {"preprocess/grid/resample",
     {"formats", "preprocess", "preprocess/values", "preprocess/mesh/inspect", "preprocess/mesh/leaf_lists"}},
    {"preprocess/cache", {"formats", "preprocess"}},
    {"preprocess/export", {"formats", "preprocess", "preprocess/process"}},
    {"preprocess/import/reading", {"formats", "preprocess", "preprocess/process"}},
    {"preprocess/import/volume",
     {"formats", "preprocess", "preprocess/process", "preprocess/export/nifti_header.h", "preprocess/import/reading"}},
    {"preprocess/import/mesh", {"formats", "preprocess", "preprocess/process", "preprocess/import/reading"}},
    {"preprocess/import/surface",
     {"formats", "preprocess", "preprocess/process", "preprocess/import/reading", "preprocess/import/mesh"}},
    {"preprocess/import/vtk",
     {"formats", "preprocess", "preprocess/process", "preprocess/export", "preprocess/import/reading",
      "preprocess/import/mesh", "preprocess/import/surface"}},
    {"preprocess/import/xdmf",
     {"formats", "preprocess", "preprocess/process", "preprocess/import/reading", "preprocess/import/mesh",
      "preprocess/import/vtk"}},
    {"preprocess/import",
     {"formats", "preprocess", "preprocess/process", "preprocess/import/reading", "preprocess/import/mesh",
      "preprocess/import/volume", "preprocess/import/vtk"}},
    {"preprocess/workers/faces", {"formats", "preprocess", "preprocess/mesh/inspect/cut_polygon.h"}},
    {"preprocess/workers/repair", {"formats", "preprocess", "preprocess/process", "preprocess/workers/faces"}},
    {"preprocess/workers/tetgen", {"formats", "preprocess", "preprocess/process", "preprocess/workers/faces"}},
    {"preprocess/workers/vdb",
     {"formats", "preprocess", "preprocess/process", "preprocess/export", "preprocess/import/reading/numbers.h"}}};

/// The programs of tools and the libraries that they share, with their subfolders. Libraries
/// include no program, so that other programs can link them.
const Layer tool_layers[] = {
    {"tools/library/rhoray", {}},
    {"tools/python", {}},
    {"tools/library", {}},
    {"tools/pictures", {}},
    {"tools/validate", {}},
    {"tools/analysis",
     {"tools/pictures", "tools/validate/grid_field.h", "tools/validate/request.h", "tools/validate/shots.h"}},
    {"tools/view", {"tools/pictures", "tools/analysis"}},
    {"tools/rhoray", {"tools/pictures", "tools/analysis", "tools/validate/request.h", "tools/view"}},
    {"tools/lab", {"tools"}}};

/// The folders that include a third-party library. `header` is a pattern for the text between the
/// brackets.
struct Library {
  std::string_view name;
  std::regex header;
  Paths included_in;
};
const Library libraries[] = {
    {"TetGen", std::regex("tetgen\\.h"), {"preprocess/workers/tetgen"}},
    {"CGAL", std::regex("CGAL/.*"), {"preprocess/workers", "tools/validate"}},
    {"Boost", std::regex("boost/.*"), {"preprocess/workers/tetgen", "render/exact", "tools/view"}},
    {"libjpeg", std::regex("jpeglib\\.h"), {"tools/view"}},
    {"VTK", std::regex("vtk\\w*\\.h"), {"preprocess/import", "tools/lab"}},
    {"OpenVDB", std::regex("openvdb/.*"), {"preprocess/workers/vdb", "tools/lab"}},
    {"NanoVDB", std::regex("nanovdb/.*"), {"preprocess/workers/vdb", "render/grid", "tools/lab"}},
    {"Embree", std::regex("embree3/.*"), {"tools/lab"}},
    {"Teem", std::regex("teem/.*"), {"preprocess/import"}},
    {"netCDF", std::regex("netcdf\\.h"), {"preprocess/import"}},
    {"HDF5", std::regex("hdf5\\.h"), {"preprocess/import"}},
    {"zlib, bzip2, LZ4, XZ, minizip", std::regex("(zlib|bzlib|lz4|lzma|minizip/\\w+)\\.h"), {"preprocess/import"}},
    {"GDCM", std::regex("gdcm\\w+\\.h"), {"preprocess/import"}},
    {"oneTBB", std::regex("tbb/.*"), {"preprocess/workers/vdb", "render/frame", "tools/lab"}},
    {"OpenImageIO", std::regex("OpenImageIO/.*"), {"tools", "preprocess/import"}},
    {"FreeType", std::regex("ft2build\\.h|freetype/.*"), {"tools"}},
    {"Eigen", std::regex("Eigen/.*"), {"data"}},
    {"CLI11", std::regex("CLI/.*"), {"data"}},
    {"JSON for Modern C++", std::regex("nlohmann/.*"), {"formats", "tools"}},
    {"xxHash", std::regex("xxhash\\.h"), {"formats", "tools"}},
    {"Highway", std::regex("hwy/.*"), {"render/traverse", "render/grid", "render/tets", "render/triangles"}},
    {"libpng", std::regex("png\\.h"), {"render"}},
    {"Imath", std::regex("Imath/.*"), {"formats"}},
    {"Rhoray, installed", std::regex("rhoray/.*"), {"tools/library/examples", "tools/python"}},
    {"pybind11", std::regex("pybind11/.*"), {"tools/python"}},
    {"Gmsh", std::regex("gmsh\\.h"), {}},
    {"GoogleTest", std::regex("(gtest|gmock)/.*"), {}}};

const std::regex standard_header("[a-z_0-9]+");
const std::regex system_header(
    "(sys/\\w+|arpa/inet|netinet/in|linux/"
    "\\w+|dirent|dlfcn|execinfo|fcntl|malloc|poll|pthread|sched|semaphore|signal|spawn|stdio|stdlib|unistd)\\.h");

/// Headers that the build generates; they are in no room.
const std::string_view generated_headers[] = {"rhoray_commit.h", "rhoray_report_template.h", "rhoray/version.h"};

/// The public headers of the library. They are included as users do: "rhoray/scene.h".
constexpr std::string_view library_headers = "tools/library/rhoray";

/// True when `path` is `place` or lies inside it.
bool is_in(std::string_view path, std::string_view place) {
  return path == place || (path.starts_with(place) && path[place.size()] == '/');
}

bool is_in_any(std::string_view path, const Paths& places) {
  return std::any_of(places.begin(), places.end(), [&](std::string_view place) { return is_in(path, place); });
}

std::string_view room_of(std::string_view path) {
  return path.substr(0, path.find('/'));
}

std::string_view folder_of(std::string_view path) {
  return path.substr(0, path.rfind('/'));
}

bool stands_in_room(std::string_view path) {
  return folder_of(path) == room_of(path);
}

const Layer* find(std::span<const Layer> list, std::string_view place) {
  for (const Layer& layer : list)
    if (layer.place == place) return &layer;
  return nullptr;
}

/// The rules of a file's own unit, or those of its folder.
const Layer* layer_of(std::string_view file) {
  const Layer* unit = find(layers, file.substr(0, file.rfind('.')));
  return unit != nullptr ? unit : find(layers, folder_of(file));
}

/// True when a layer may see a header: the list names the file, or the folder that it belongs to.
bool sees(const Layer& layer, std::string_view header) {
  const Layer* of_header = layer_of(header);
  if (of_header == &layer) return true;
  const bool is_above_folder = of_header != nullptr && of_header->place != folder_of(header);
  return std::any_of(layer.may_see.begin(), layer.may_see.end(), [&](std::string_view place) {
    return header == place || (folder_of(header) == place && !is_above_folder) ||
           (place == "formats" && is_in(folder_of(header), "formats"));
  });
}

/// The path of a header that is included in quotation marks.
std::string own_path(const std::string& header) {
  return header.starts_with("rhoray/") ? "tools/library/" + header : header;
}

/// The rule that `file` breaks by including our own `header`, or nothing.
std::optional<std::string> rule_against_own(const std::filesystem::path& root, std::string_view file,
                                            std::string_view header) {
  if (is_in(file, library_headers) && !is_in(header, library_headers)) return "layers";
  const std::string_view room = room_of(file), target = room_of(header);
  if (!std::filesystem::exists(root / header)) return "names";
  const Layer* in_room = find(rooms, room);
  if (in_room == nullptr || (target != room && !is_in_any(target, in_room->may_see))) return "rooms";
  const bool is_public = stands_in_room(header) || is_in(header, "formats/base");
  if (target != room && room != "tests" && !is_public) return "public headers";
  if ((room == "render" || room == "preprocess") && !stands_in_room(file)) {
    const Layer* layer = layer_of(file);
    if (layer == nullptr || !sees(*layer, header)) return "layers";
  }
  if (room == "tools" && target == room) {
    const Layer* layer = std::find_if(std::begin(tool_layers), std::end(tool_layers),
                                      [&](const Layer& each) { return is_in(file, each.place); });
    if (layer == std::end(tool_layers) || !(is_in(header, layer->place) || is_in_any(header, layer->may_see)))
      return "layers";
  }
  return std::nullopt;
}

bool is_received(std::string_view file, std::string_view header) {
  const std::string text(header);
  if (is_in(file, library_headers)) return std::regex_match(text, standard_header);
  if (std::regex_match(text, standard_header) || std::regex_match(text, system_header)) return true;
  for (const Library& library : libraries)
    if (std::regex_match(text, library.header)) return is_in(file, "tests") || is_in_any(file, library.included_in);
  return false;
}

bool is_source(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".h" || extension == ".cpp";
}

struct Include {
  int line = 0;
  bool is_quoted = false;
  std::string header;
};

std::vector<Include> includes_of(const std::filesystem::path& path) {
  static const std::regex include_line("\\s*#\\s*include\\s*([<\"])([^>\"]+)[>\"].*");
  std::ifstream lines(path);
  std::vector<Include> found;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch parts;
    if (line.find("include") != line.npos && std::regex_match(line, parts, include_line))
      found.push_back({number, parts[1] == "\"", parts[2]});
  }
  return found;
}

void check_file(const std::filesystem::path& root, const std::string& file, std::vector<Breach>& found) {
  for (const auto& [line, is_quoted, header] : includes_of(root / file)) {
    std::optional<std::string> rule;
    if (!is_quoted) {
      if (!is_received(file, header)) rule = "third-party";
    } else if (std::find(std::begin(generated_headers), std::end(generated_headers), header) ==
               std::end(generated_headers)) {
      rule = rule_against_own(root, file, own_path(header));
    }
    if (rule) found.push_back({file, line, is_quoted ? "\"" + header + "\"" : "<" + header + ">", *rule});
  }
}

std::vector<std::string> sources_below(const std::filesystem::path& root) {
  std::vector<std::string> files;
  for (const Layer& room : rooms) {
    const std::filesystem::path folder = root / room.place;
    if (!std::filesystem::is_directory(folder)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      if (entry.is_regular_file() && is_source(entry.path()))
        files.push_back(entry.path().lexically_relative(root).generic_string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string unit_of(const std::string& file) {
  return file.substr(0, file.rfind('.'));
}

/// Tarjan's algorithm: finds the strongly connected sets of units (SIAM J. Comput. 1(2), 1972).
class CircleSearch {
 public:
  explicit CircleSearch(const std::map<std::string, std::set<std::string>>& includes) : includes_(includes) {}

  std::vector<std::string> find() {
    for (const auto& [unit, included] : includes_)
      if (!order_.contains(unit)) visit(unit);
    std::sort(found_.begin(), found_.end());
    return found_;
  }

 private:
  void visit(const std::string& unit) {
    order_[unit] = lowest_[unit] = order_.size();
    path_.push_back(unit), on_path_.insert(unit);
    for (const std::string& next : includes_.at(unit)) {
      if (!order_.contains(next)) visit(next), lowest_[unit] = std::min(lowest_[unit], lowest_[next]);
      if (on_path_.contains(next)) lowest_[unit] = std::min(lowest_[unit], order_[next]);
    }
    if (lowest_[unit] != order_[unit]) return;
    std::set<std::string> circle;
    do {
      circle.insert(path_.back()), on_path_.erase(path_.back()), path_.pop_back();
    } while (!circle.contains(unit));
    if (circle.size() == 1) return;
    std::string line;
    for (const std::string& member : circle) line += (line.empty() ? "" : " ") + member;
    found_.push_back(line);
  }

  const std::map<std::string, std::set<std::string>>& includes_;
  std::map<std::string, std::size_t> order_, lowest_;
  std::vector<std::string> path_, found_;
  std::set<std::string> on_path_;
};

}  // namespace

std::vector<Breach> breaches(const std::filesystem::path& root) {
  std::vector<Breach> found;
  for (const std::string& file : sources_below(root)) check_file(root, file, found);
  return found;
}

std::vector<std::string> circles(const std::filesystem::path& root) {
  const std::vector<std::string> files = sources_below(root);
  std::map<std::string, std::set<std::string>> includes;
  for (const std::string& file : files) includes[unit_of(file)];
  for (const std::string& file : files)
    for (const Include& include : includes_of(root / file)) {
      const std::string target = unit_of(own_path(include.header));
      if (include.is_quoted && target != unit_of(file) && includes.contains(target))
        includes[unit_of(file)].insert(target);
    }
  return CircleSearch(includes).find();
}

}  // namespace rhoray::tests
