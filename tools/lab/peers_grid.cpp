// Isosurfaces and largest values of one grid, by this renderer and by other programs' libraries, in
// one run: the same samples, cameras and pixels, one thread, and every picture compared with the
// exact answer.

#include "tools/lab/peers_grid.h"

#include <cmath>

#include "preprocess/pack_volume.h"
#include "tools/lab/contest.h"
#include "tools/lab/peers/ours.h"
#include "tools/lab/peers/triangles.h"
#include "tools/lab/peers/vdb.h"
#include "tools/lab/plain_grid.h"
#include "tools/rhoray/cli/interrupt.h"
#ifdef RHORAY_WITH_EMBREE
#include "tools/lab/peers/embree_triangles.h"
#endif
#ifdef RHORAY_WITH_VTK_RENDERING
#include "tools/lab/peers/vtk_rendering.h"
#endif

namespace rhoray::study {

namespace {

struct Settings : ContestSettings {
  std::filesystem::path scratch = std::filesystem::temp_directory_path();
};

const std::vector<std::string> system_words{"ours", "embree", "nanovdb", "openvdb", "vtk"};

Contest isosurface_contest(const Settings& settings) {
  Contest contest;
  if (settings.wants("ours"))
    for (const char* level : {"preview", "float", "double", "certified", "exact"}) contest.add(own_isosurface(level));
  const std::shared_ptr<Triangles> triangles = flying_edges();
#ifdef RHORAY_WITH_EMBREE
  if (settings.wants("embree")) {
    const auto scene = embree_triangles(triangles);
    contest.add(embree_packets(scene));
    contest.add(embree_single_rays(scene));
  }
#else
  if (settings.wants("embree")) contest.left_out["Embree"] = "not built: install libembree-dev";
#endif
  if (settings.wants("nanovdb")) {
    contest.add(nanovdb_dense());
    contest.add(nanovdb_narrow());
  }
  if (settings.wants("openvdb")) contest.add(openvdb_level_set());
#ifdef RHORAY_WITH_VTK_RENDERING
  if (settings.wants("vtk")) {
    if (const std::string reason = no_display(); !reason.empty())
      contest.left_out["VTK, drawing"] = reason;
    else
      contest.add(vtk_drawing(triangles));
  }
#else
  if (settings.wants("vtk")) contest.left_out["VTK, drawing"] = "not built: install libvtk9-dev with its rendering";
#endif
  return contest;
}

Contest largest_value_contest(const Settings& settings) {
  Contest contest;
  if (settings.wants("ours"))
    for (const char* level : {"float", "double", "certified"}) contest.add(own_largest_values(level));
#ifdef RHORAY_WITH_VTK_RENDERING
  if (settings.wants("vtk"))
    for (const double step : {1.0, 0.5, 0.1}) contest.add(vtk_largest_values(step));
#else
  if (settings.wants("vtk"))
    contest.left_out["VTK, largest values"] = "not built: install libvtk9-dev with its rendering";
#endif
  return contest;
}

int run(const Settings& settings) {
  prepare_contest(settings, system_words, "peers");
  const tools::ScratchFolder scratch(settings.scratch);
  preprocess::NeutralVolume grid = plain_grid(settings.input, settings.field);
  const std::filesystem::path file = scratch.path() / "grid.rho";
  preprocess::pack_volume(grid, file);
  grid.samples = grid.owned_samples;
  const Vec3 spacing = spacing_of(grid);
  PeerData data;
  data.grid = &grid;
  data.packed_file = file;
  Subject subject(settings, data, std::cbrt(spacing.x * spacing.y * spacing.z), "voxel");
  const Index3 n = grid.sample_count;
  subject.about = {{"samples", {n.x, n.y, n.z}}, {"type", formats::element_name(grid.type)}};
  run_contest(
      settings, subject, "peers", [&] { return isosurface_contest(settings); },
      [&] { return largest_value_contest(settings); });
  return 0;
}

}  // namespace

tools::Subcommand peers_grid() {
  const auto settings = std::make_shared<Settings>();
  return {
      .name = "peers-grid",
      .summary = "A grid's isosurfaces and largest values by this renderer and by others, in one run",
      .examples = {"rhoray-study peers-grid smooth.rho --iso 600.5,2200.5 --mip -o results",
                   "xvfb-run -a rhoray-study peers-grid smooth.rho --views front --systems ours,vtk"},
      .sections = {{.heading = "Notes",
                    .entries = {{"", "VTK's drawing needs an X display; xvfb-run brings one where there is none."}}}},
      .options =
          tools::all_options({{tools::file_option("FILE", "Packed grid", settings->input)},
                              contest_options(*settings, system_words, "peers_isosurface and peers_mip"),
                              {tools::value_option("--scratch", "FOLDER", "For the packed grid", settings->scratch)}}),
      .run = [settings] { return run(*settings); }};
}

}  // namespace rhoray::study
