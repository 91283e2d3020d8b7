// Isosurfaces of one mesh of tetrahedra, by this renderer and by other programs' libraries, in one
// run: the same cells, cameras and pixels, one thread, and every picture compared with the exact
// answer.

#include "tools/lab/peers_tets.h"

#include <cmath>

#include "formats/base/error.h"
#include "formats/tet_mesh.h"
#include "preprocess/unpack_mesh.h"
#include "tools/lab/contest.h"
#include "tools/lab/peers/ours.h"
#include "tools/lab/peers/triangles.h"
#ifdef RHORAY_WITH_EMBREE
#include "tools/lab/peers/embree_cells.h"
#include "tools/lab/peers/embree_triangles.h"
#endif
#ifdef RHORAY_WITH_VTK_RENDERING
#include "tools/lab/peers/vtk_rendering.h"
#endif

namespace rhoray::study {

namespace {

const std::vector<std::string> system_words{"ours", "embree", "vtk"};

Contest isosurface_contest(const ContestSettings& settings) {
  Contest contest;
  if (settings.wants("ours"))
    for (const char* level : {"float", "double", "certified", "exact"}) contest.add(own_isosurface(level));
  const std::shared_ptr<Triangles> triangles = linear_grid_contour(false), with_tree = linear_grid_contour(true);
#ifdef RHORAY_WITH_EMBREE
  if (settings.wants("embree")) {
    constexpr auto wide = CellCallback::sixteen_rays, plain = CellCallback::ray_by_ray;
    for (const auto& scene : {embree_triangles(triangles), embree_cells(true, wide), embree_cells(false, wide)}) {
      contest.add(embree_packets(scene));
      contest.add(embree_single_rays(scene));
    }
    for (const bool only_crossed : {true, false}) contest.add(embree_packets(embree_cells(only_crossed, plain)));
  }
#else
  if (settings.wants("embree")) contest.left_out["Embree"] = "not built: install libembree-dev";
#endif
#ifdef RHORAY_WITH_VTK_RENDERING
  if (settings.wants("vtk")) {
    if (const std::string reason = no_display(); !reason.empty())
      contest.left_out["VTK, drawing"] = reason;
    else
      for (const auto& surface : {triangles, with_tree}) contest.add(vtk_drawing(surface));
  }
#else
  if (settings.wants("vtk")) contest.left_out["VTK, drawing"] = "not built: install libvtk9-dev with its rendering";
#endif
  return contest;
}

/// No other library offers largest values for tetrahedra: VTK's unstructured ray caster shows
/// something else.
Contest largest_value_contest(const ContestSettings& settings) {
  Contest contest;
  if (settings.wants("ours"))
    for (const char* level : {"float", "double", "certified"}) contest.add(own_largest_values(level));
  return contest;
}

/// Cells of a packed mesh with the field that is shown.
preprocess::NeutralMesh mesh_of(const std::filesystem::path& path, const std::string& field) {
  formats::PackedFile file = formats::PackedFile::open(path);
  if (file.description().kind != "tets")
    throw Error(ErrorCode::usage, concat(path.string(), ": found a packed file of kind '", file.description().kind,
                                         "'; expected tetrahedra"));
  const formats::TetMesh packed(std::move(file));
  const std::optional<std::size_t> index = field.empty() ? 0 : packed.find_field(field);
  if (!index) throw Error(ErrorCode::usage, concat(path.string(), ": found no field '", field, "'"));
  preprocess::NeutralMesh mesh = preprocess::unpack_mesh(packed);
  std::swap(mesh.point_fields[0], mesh.point_fields[*index]);
  mesh.point_fields.erase(mesh.point_fields.begin() + 1, mesh.point_fields.end());
  return mesh;
}

/// The cube root of a cell's mean volume.
double mean_size(const preprocess::NeutralMesh& mesh) {
  double volume = 0;
  const auto point = [&](std::uint64_t p) { return Vec3(mesh.points[p][0], mesh.points[p][1], mesh.points[p][2]); };
  for (const auto& c : mesh.cells) {
    const Vec3 a = point(c[0]);
    volume += std::abs((point(c[1]) - a).dot((point(c[2]) - a).cross(point(c[3]) - a))) / 6;
  }
  return std::cbrt(volume / static_cast<double>(mesh.cells.size()));
}

int run(const ContestSettings& settings) {
  prepare_contest(settings, system_words, "peers_tets");
  const preprocess::NeutralMesh mesh = mesh_of(settings.input, settings.field);
  PeerData data;
  data.mesh = &mesh;
  data.packed_file = settings.input;
  data.field = settings.field;
  Subject subject(settings, data, mean_size(mesh), "cell");
  subject.about = {{"points", mesh.points.size()}, {"cells", mesh.cells.size()}};
  run_contest(
      settings, subject, "peers_tets", [&] { return isosurface_contest(settings); },
      [&] { return largest_value_contest(settings); });
  return 0;
}

}  // namespace

tools::Subcommand peers_tets() {
  const auto settings = std::make_shared<ContestSettings>();
  return {
      .name = "peers-tets",
      .summary = "A mesh's isosurfaces by this renderer and by others, in one run",
      .examples = {"rhoray-study peers-tets torso.rho --iso 0.3 --mip -o results",
                   "xvfb-run -a rhoray-study peers-tets torso.rho --views close-up --systems ours,vtk"},
      .sections = {{.heading = "Notes",
                    .entries = {{"", "VTK's drawing needs an X display; xvfb-run brings one where there is none."}}}},
      .options =
          tools::all_options({{tools::file_option("FILE", "Packed mesh of tetrahedra", settings->input)},
                              contest_options(*settings, system_words, "peers_tets_isosurface and peers_tets_mip")}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study
