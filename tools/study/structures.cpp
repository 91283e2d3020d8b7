#include "tools/study/structures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "formats/tet_mesh.h"
#include "preprocess/import_mesh.h"
#include "preprocess/pack_mesh.h"
#include "render/render.h"
#include "tools/rhoray/cpu_meter.h"
#include "tools/rhoray/data_choice.h"
#include "tools/rhoray/input_file.h"
#include "tools/rhoray/interrupt.h"
#include "tools/rhoray/picture_hash.h"
#include "tools/rhoray/progress_display.h"
#include "tools/rhoray/views.h"
#include "tools/study/study_run.h"
#include "tools/study/warped_box.h"

namespace rhoray::study {
namespace {

using preprocess::MeshStructure;
using preprocess::NeutralMesh;
using preprocess::PackMeshOptions;
using tools::Json;

struct Wishes {
  tools::CommonOptions common;
  std::vector<std::string> inputs;
  std::uint64_t cells = 200'000;
  std::string isovalue = "auto";
  tools::PictureSize size{256, 256};
  int repeat = 3;
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

struct Structure {
  const char* name;
  PackMeshOptions pack;
};

std::vector<Structure> all_structures() {
  return {{"leaf lists, a leaf for each cell", {.structure = MeshStructure::leaves}},
          {"leaf lists, a leaf for 8 cells", {.structure = MeshStructure::leaves, .leaf_cells_per_tetrahedron = 0.125}},
          {"clusters of 64", {}},
          {"clusters of 32", {.cluster_size = 32}},
          {"clusters of 8", {.cluster_size = 8}}};
}

/// Along each axis cubes' edges become a geometric series, so that volumes go over so many orders of magnitude.
NeutralMesh graded(NeutralMesh mesh, double orders) {
  const double last_over_first = std::pow(10, orders / 3);
  for (auto& point : mesh.points)
    for (double& x : point) x = (std::pow(last_over_first, x) - 1) / (last_over_first - 1);
  return mesh;
}

/// Layers that are a thousandth as thick as they were, between layers as they were.
NeutralMesh with_slivers(NeutralMesh mesh, std::int64_t edge) {
  for (auto& point : mesh.points) {
    const double layers = point[2] * static_cast<double>(edge), pairs = std::floor(layers / 2);
    const double rest = layers - 2 * pairs;
    point[2] = (pairs * 1.001 + (rest <= 1 ? rest : 1 + (rest - 1) * 1e-3)) / static_cast<double>(edge);
  }
  return mesh;
}

struct NamedMesh {
  std::string name;
  std::function<NeutralMesh()> make;
};

std::vector<NamedMesh> meshes_of(const Wishes& wishes) {
  const std::int64_t edge = edge_for(wishes.cells);
  std::vector<NamedMesh> meshes{{"uniform", [=] { return warped_box(edge); }}};
  for (const int orders : {2, 4, 6})
    meshes.push_back({concat("graded over 10^", orders), [=] { return graded(warped_box(edge), orders); }});
  meshes.push_back({"slivers", [=] { return with_slivers(warped_box(edge), edge); }});
  for (const std::filesystem::path input : wishes.inputs)
    meshes.push_back({input.stem().string(), [=] { return preprocess::import_mesh(input); }});
  return meshes;
}

/// Bytes of the file beside points, fields and envelope.
std::uint64_t structure_bytes(const formats::PackedFile& file) {
  std::uint64_t bytes = 0;
  for (const formats::ArrayEntry& entry : file.arrays())
    if (entry.name != "points" && !entry.name.starts_with("field.") && !entry.name.starts_with('_'))
      bytes += entry.byte_count;
  return bytes;
}

double per(double amount, std::uint64_t count) {
  return amount / static_cast<double>(count);
}

/// One structure of one mesh: packed, then shown `repeat` times by the scalar kernels in double precision.
Json row_of(const Wishes& wishes, const NamedMesh& mesh, const NeutralMesh& source, const Structure& structure,
            const std::filesystem::path& file) {
  tools::CpuMeter meter;
  PackMeshOptions pack = structure.pack;
  pack.replace_existing = true;
  formats::TetMeshDescription packed;
  const double pack_s = meter.measure([&] { packed = preprocess::pack_mesh(source, file, pack).description; }).cpu_s;
  const render::Volume volume = render::Volume::load(file);
  render::Scene scene;
  scene.layers[0].isovalue = tools::choose_isovalue(wishes.isovalue, volume.field()).value;
  scene.camera = tools::study_camera(tools::study_view_named("front"), volume, scene.layers[0].isovalue,
                                     double{1} * wishes.size.width / wishes.size.height);
  render::Framebuffer picture;
  render::FrameMemory memory;
  render::FrameStatistics statistics;
  std::vector<double> cpu_ms;
  for (int round = 0; round < wishes.repeat; ++round)
    cpu_ms.push_back(1e3 * meter
                               .measure([&] {
                                 statistics = render::render(
                                     volume, scene,
                                     {.width = wishes.size.width, .height = wishes.size.height, .threads = 1}, picture,
                                     memory);
                               })
                               .cpu_s);
  std::sort(cpu_ms.begin(), cpu_ms.end());
  const std::uint64_t named = packed.clusters ? packed.cell_count : packed.leaf_item_count;
  return {{"mesh", mesh.name},
          {"cells", packed.cell_count},
          {"structure", structure.name},
          {"bytes_per_cell", per(static_cast<double>(structure_bytes(volume.file())), packed.cell_count)},
          {"times_named", per(static_cast<double>(named), packed.cell_count)},
          {"pack_cells_per_cpu_s", static_cast<double>(packed.cell_count) / pack_s},
          {"nodes_per_ray", per(static_cast<double>(statistics.macrocells_visited), statistics.rays)},
          {"regions_per_ray", per(static_cast<double>(statistics.cells_visited), statistics.rays)},
          {"tested_per_ray", per(static_cast<double>(statistics.cells_solved), statistics.rays)},
          {"cpu_us_per_ray", 1e3 * per(cpu_ms[cpu_ms.size() / 2], statistics.rays)},
          {"machine", statistics.machine},
          {"picture", tools::picture_hash(picture)}};
}

int run(const Wishes& wishes) {
  tools::require_within("--cells", static_cast<double>(wishes.cells), 6, 1e9);
  tools::require_within("--repeat", wishes.repeat, 1, 10'000);
  for (const std::string& input : wishes.inputs) tools::require_input(input);
  const tools::ScratchFolder scratch(wishes.scratch);
  tools::Table table{"structures", "How rays find tetrahedra: bytes, packing, and isosurfaces on one thread", {}, {}};
  bool is_same_everywhere = true;
  {
    tools::ProgressDisplay display(wishes.common);
    for (const NamedMesh& mesh : meshes_of(wishes)) {
      display.show(concat("making ", mesh.name));
      const NeutralMesh source = mesh.make();
      const std::size_t first = table.rows.size();
      for (const Structure& structure : all_structures()) {
        display.show(concat(mesh.name, ", ", structure.name));
        table.rows.push_back(row_of(wishes, mesh, source, structure, scratch.path() / "packed.rho"));
        is_same_everywhere &= table.rows.back()["picture"] == table.rows[first]["picture"];
      }
    }
  }
  table.context = context_with({{"isovalue", wishes.isovalue},
                                {"size", {wishes.size.width, wishes.size.height}},
                                {"threads", 1},
                                {"repeat", wishes.repeat}});
  publish(table, wishes.common);
  if (!is_same_everywhere)
    throw Error(Trouble::outside_limit, "structures: one mesh gives different pictures; see column 'picture'");
  return 0;
}

}  // namespace

tools::Subcommand structures() {
  const auto wishes = std::make_shared<Wishes>();
  return {
      .name = "structures",
      .summary = "How rays find tetrahedra, and what that costs: leaf lists beside clusters",
      .examples = "  rhoray-study structures --cells 1000000 -o results\n",
      .options = tools::all_options(
          {tools::output_options(wishes->common, "FOLDER for structures.csv and .json"),
           {tools::value_option("--meshes", "FILE[,FILE]", "Beside those that are made", wishes->inputs),
            tools::value_option("--cells", "N", "Tetrahedra of those that are made; default 200000", wishes->cells),
            tools::value_option("--iso", "V", "Isovalue, as in render; default auto", wishes->isovalue),
            tools::value_option("--size", "WxH", "Pixels; default 256x256", wishes->size),
            tools::value_option("--repeat", "N", "Pictures of each; default 3", wishes->repeat),
            tools::value_option("--scratch", "FOLDER", "For the packed meshes", wishes->scratch),
            tools::value_option("--progress", "STYLE", "auto, bar, plain, json or none", wishes->common.progress)}}),
      .run = [wishes] { return run(*wishes); }};
}

}  // namespace rhoray::study
