#include "data/recipes/torso_surface.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "data/recipes/torso_scene.h"
#include "formats/base/error.h"
#include "formats/base/pending_file.h"

namespace rhoray::recipes {

namespace {

struct Body {
  std::string name;
  StarSurface shape;
  double longest_edge;  ///< keeps coarse triangles of neighbouring bodies apart
};

std::vector<Body> bodies() {
  return {{"skin", {torso::skin, torso::body_centre, 420}, 80},
          {"heart", {torso::heart, torso::heart_centre, 90}, 30},
          {"left_lung", {torso::left_lung, torso::left_lung_centre, 190}, 38},
          {"right_lung", {torso::right_lung, torso::right_lung_centre, 190}, 38}};
}

/// Number of tetrahedra that TetGen 1.5.0 made of the torso with quality 1.4, by edge length in the
/// heart.
struct Calibration {
  double cell_count, finest_mm;
};
constexpr Calibration calibration[] = {{4309, 40},     {5083, 23.392},  {8688, 14.736},  {27767, 8.618},
                                       {95062, 5.429}, {279761, 3.420}, {849305, 2.201}, {4229810, 1.2004}};

/// Edge length in the heart that gives about this many tetrahedra: linear interpolation of measured
/// values in logarithms.
double finest_size(std::uint64_t cell_count) {
  const auto count = static_cast<double>(cell_count);
  std::size_t i = 1;
  while (i + 1 < std::size(calibration) && calibration[i].cell_count < count) ++i;
  const Calibration &a = calibration[i - 1], &b = calibration[i];
  const double share = std::log(count / a.cell_count) / std::log(b.cell_count / a.cell_count);
  return a.finest_mm * std::pow(b.finest_mm / a.finest_mm, share);
}

void append(const Triangulation& part, double finest, preprocess::NeutralSurface& surface) {
  const std::uint64_t first = surface.points.size();
  for (const Vec3& p : part.points) {
    surface.points.push_back({p.x, p.y, p.z});
    surface.point_sizes.push_back(wanted_size(p, finest));
  }
  for (const auto& t : part.triangles) {
    for (const std::uint32_t corner : t) surface.facet_corners.push_back(first + corner);
    surface.facet_offsets.push_back(surface.facet_corners.size());
  }
}

preprocess::NeutralSurface::Region region(const Vec3& seed, Tissue tissue) {
  return {.seed = {seed.x, seed.y, seed.z}, .attribute = static_cast<double>(tissue), .max_volume = 0};
}

}  // namespace

double wanted_size(const Vec3& p, double finest) {
  constexpr double coarsest = 9, far_mm = 170;  // 9 times as coarse at 170 mm from the heart
  const double far = std::clamp(torso::heart(p) / far_mm, 0.0, 1.0);
  return finest * (1 + (coarsest - 1) * far);
}

TorsoSurface make_torso_surface(std::uint64_t cell_count) {
  if (cell_count < 4'500 || cell_count > 20'000'000)
    throw Error(ErrorCode::usage, concat("torso of ", cell_count, " tetrahedra; expected 4500 to 20000000"));
  const double finest = finest_size(cell_count);
  TorsoSurface made;
  for (const Body& body : bodies()) {
    const auto edge_length = [&](const Vec3& p) { return std::min(body.longest_edge, wanted_size(p, finest)); };
    made.parts.push_back({body.name, triangulate(body.shape, edge_length)});
    append(made.parts.back().triangulation, finest, made.surface);
  }
  const Vec3 belly(0, 0, 150);
  made.surface.regions = {region(belly, Tissue::torso), region(torso::heart_centre, Tissue::heart),
                          region(torso::left_lung_centre, Tissue::lungs),
                          region(torso::right_lung_centre, Tissue::lungs)};
  return made;
}

namespace {

std::string ply_text(const Triangulation& part) {
  std::string text = concat("ply\nformat ascii 1.0\nelement vertex ", part.points.size(),
                            "\nproperty double x\nproperty double y\nproperty double z\nelement face ",
                            part.triangles.size(), "\nproperty list uchar int vertex_indices\nend_header\n");
  for (const Vec3& p : part.points) text += concat(p.x, " ", p.y, " ", p.z, "\n");
  for (const auto& t : part.triangles) text += concat("3 ", t[0], " ", t[1], " ", t[2], "\n");
  return text;
}

std::string smesh_text(const preprocess::NeutralSurface& surface) {
  std::string text =
      concat("# A torso with heart and lungs, millimetres. Part 1: points\n", surface.points.size(), " 3 0 0\n");
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    text += concat(i, " ", surface.points[i][0], " ", surface.points[i][1], " ", surface.points[i][2], "\n");
  text += concat("# Part 2: facets\n", surface.facet_offsets.size() - 1, " 0\n");
  for (std::size_t c = 0; c < surface.facet_corners.size(); c += 3)
    text += concat("3 ", surface.facet_corners[c], " ", surface.facet_corners[c + 1], " ", surface.facet_corners[c + 2],
                   "\n");
  text += concat("# Part 3: holes\n0\n# Part 4: regions: 1 torso, 2 heart, 3 lungs\n", surface.regions.size(), "\n");
  for (std::size_t i = 0; i < surface.regions.size(); ++i) {
    const auto& region = surface.regions[i];
    text +=
        concat(i + 1, " ", region.seed[0], " ", region.seed[1], " ", region.seed[2], " ", region.attribute, " -1\n");
  }
  return text;
}

std::string sizes_text(const preprocess::NeutralSurface& surface) {
  std::string text = concat(surface.point_sizes.size(), " 1\n");
  for (const double size : surface.point_sizes) text += concat(size, "\n");
  return text;
}

}  // namespace

void write_torso_surface(const TorsoSurface& torso, const std::filesystem::path& path, bool each_as_ply,
                         bool replace_existing) {
  if (path.extension() != ".smesh")
    throw Error(ErrorCode::usage, concat(path.string(), ": the name of the surface must end in .smesh"));
  std::vector<std::pair<std::filesystem::path, std::string>> texts{
      {std::filesystem::path(path).replace_extension(".mtr"), sizes_text(torso.surface)},
      {path, smesh_text(torso.surface)}};
  if (each_as_ply)
    for (const TorsoSurface::Part& part : torso.parts) {
      const std::string name = concat(path.stem().string(), "_", part.name, ".ply");
      texts.emplace_back(path.parent_path() / name, ply_text(part.triangulation));
    }
  PendingFiles files(replace_existing);
  for (const auto& [name, text] : texts) files.add(name, text);
  files.publish();
}

}  // namespace rhoray::recipes
