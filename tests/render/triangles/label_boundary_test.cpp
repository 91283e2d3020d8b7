#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "formats/base/error.h"
#include "render/dataset/loaded_dataset.h"
#include "render/document.h"
#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/expect_error.h"

/// The boundaries of a mesh's cells with one label.
namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::Hit;
using render::Ray;

/// The box from 0 to 4 x 3 x 3 in cubes of edge 1/2: label 3 from 2 to 3 in x and from 1 to 2 in y
/// and z, which is inside; label 1 below x = 1; label 2 elsewhere.
int label_at(const Vec3& p) {
  if (p.x > 2 && p.x < 3 && p.y > 1 && p.y < 2 && p.z > 1 && p.z < 2) return 3;
  return p.x < 1 ? 1 : 2;
}

struct Labelled {
  TemporaryFolder folder;
  preprocess::NeutralMesh neutral;
  render::Dataset mesh;

  explicit Labelled(double jitter = 0, preprocess::MeshStructure structure = preprocess::MeshStructure::clusters)
      : neutral(box_mesh({.cells = {8, 6, 6}, .box = {{0, 0, 0}, {4, 3, 3}}})), mesh(made(jitter, structure)) {}

  render::Dataset surface(int label) const { return mesh.boundary("region", label); }

 private:
  render::Dataset made(double jitter, preprocess::MeshStructure structure) {
    preprocess::NeutralField regions{.name = "region", .unit = {}, .was_single_precision = true, .values = {}};
    for (const auto& cell : neutral.cells) {
      Vec3 middle(0, 0, 0);
      for (const std::uint64_t v : cell) middle += 0.25 * to_vec3(neutral.points[v]);
      regions.values.push_back(label_at(middle));
    }
    neutral.cell_fields.push_back(regions);
    add_point_field(neutral, "height", [](const Vec3& p) { return p.z; });
    if (jitter > 0) {
      const preprocess::NeutralMesh moved =
          box_mesh({.cells = {8, 6, 6}, .box = {{0, 0, 0}, {4, 3, 3}}, .jitter = jitter});
      neutral.points = moved.points;
    }
    return packed(folder, "m.rho", neutral, {.structure = structure});
  }
};

render::MeshBoundary boundary_in(const render::Dataset& dataset) {
  return *std::get<render::TriangleData>(dataset.implementation().view).boundary();
}

TEST(LabelBoundary, has_the_area_and_the_volume_of_its_cells) {
  const Labelled labelled;
  const std::map<int, std::pair<double, double>> expected{
      {1, {2 * 9 + 4 * 3, 9}}, {2, {2 * 9 + 4 * 9 + 6, 27 - 1}}, {3, {6, 1}}};
  for (const auto& [label, measures] : expected) {
    const render::MeshBoundary surface = boundary_in(labelled.surface(label));
    double area = 0, volume = 0;
    for (const auto& triangle : surface.triangles) {
      const Vec3 a = to_vec3(surface.points[triangle[0]]), b = to_vec3(surface.points[triangle[1]]),
                 c = to_vec3(surface.points[triangle[2]]);
      area += (b - a).cross(c - a).length() / 2;
      volume += a.dot(b.cross(c)) / 6;
    }
    EXPECT_NEAR(area, measures.first, 1e-9) << label;
    EXPECT_NEAR(volume, measures.second, 1e-9) << label << ": corners are counter-clockwise seen from outside";
  }
}

TEST(LabelBoundary, is_closed) {
  for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
    const Labelled labelled(0.1, structure);
    for (const int label : {1, 2, 3}) {
      const render::MeshBoundary surface = boundary_in(labelled.surface(label));
      std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
      for (const auto& triangle : surface.triangles)
        for (std::size_t c = 0; c < 3; ++c) ++edges[{triangle[c], triangle[(c + 1) % 3]}];
      for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1) << label;
        EXPECT_TRUE(edges.contains({edge.second, edge.first})) << label;
      }
    }
  }
}

TEST(LabelBoundary, of_all_labels_are_the_boundary_and_the_faces_between_labels_twice) {
  const Labelled labelled(0.1);
  std::map<std::set<std::array<double, 3>>, int> faces;
  for (const int label : {1, 2, 3}) {
    const render::MeshBoundary surface = boundary_in(labelled.surface(label));
    for (const auto& t : surface.triangles) ++faces[{surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]}];
  }
  std::size_t once = 0, twice = 0;
  for (const auto& [face, count] : faces) (count == 1 ? once : twice) += 1;
  EXPECT_EQ(once, boundary_in(labelled.mesh.boundary()).triangles.size());
  EXPECT_EQ(twice, 2U * 36 + 2U * 4 * 6) << "36 squares at x = 1, and 24 around label 3";
}

TEST(LabelBoundary, without_a_neighbour_leaves_out_the_faces_between_them) {
  const Labelled labelled(0.1);
  const auto count = [&](int label, const std::vector<int>& without) {
    return boundary_in(labelled.mesh.boundary("region", label, without)).triangles.size();
  };
  EXPECT_EQ(count(1, {2}), count(1, {}) - 2 * 36);
  EXPECT_EQ(count(2, {1}), count(2, {}) - 2 * 36);
  EXPECT_EQ(count(2, {3, 1}), count(2, {}) - 2 * 36 - 2 * 24);
  EXPECT_EQ(count(1, {3}), count(1, {})) << "they do not touch";
  EXPECT_EQ(count(3, {2}), 0U);
}

TEST(LabelBoundary, of_a_transparent_layer_leaves_faces_to_a_more_opaque_one_or_else_the_first) {
  const Labelled labelled(0.1);
  const auto counts = [&](const std::vector<double>& opacities) {
    render::SceneSpec scene;
    for (std::size_t i = 0; i < opacities.size(); ++i) {
      const std::string name = concat("part ", i);
      scene.data.push_back({.name = name, .file = "m.rho", .field = "region", .label = static_cast<int>(i) + 1});
      scene.layers.push_back({.type = render::LayerType::boundary, .data = name, .opacity = opacities[i]});
    }
    const render::ResolvedScene plan =
        render::resolve_layers(scene, [&](const render::DataSpec&, formats::Space) { return labelled.mesh; });
    std::vector<std::size_t> triangles;
    for (const render::Layer& layer : plan.scene.layers)
      triangles.push_back(boundary_in(plan.datasets[layer.dataset]).triangles.size());
    return triangles;
  };
  const std::vector<std::size_t> whole = counts({1, 1, 1});
  constexpr std::size_t between_1_and_2 = 2 * 36, between_2_and_3 = 2 * 24;
  EXPECT_EQ(whole[2], between_2_and_3);
  EXPECT_EQ(counts({0.5, 0.5, 1}), (std::vector{whole[0], whole[1] - between_1_and_2 - between_2_and_3, whole[2]}));
  EXPECT_EQ(counts({0.2, 0.5, 0.3}), (std::vector{whole[0] - between_1_and_2, whole[1], std::size_t{0}}));
}

/// Rays from around a place, in directions that are parallel to nothing.
std::vector<Ray> rays_from(const Vec3& middle, const Affine& world_from_data) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> shift(-0.2, 0.2), direction(-1, 1);
  std::vector<Ray> rays;
  for (int i = 0; i < 4096; ++i) {
    Ray ray;
    ray.origin = middle + Vec3(shift(random), shift(random), shift(random)) - world_from_data.origin;
    ray.direction = Vec3(direction(random), direction(random), direction(random));
    rays.push_back(ray);
  }
  return rays;
}

std::vector<Hit> hits_of(const render::Dataset& dataset, const std::vector<Ray>& rays, render::Machine machine,
                         render::Accuracy accuracy) {
  const render::LoadedDataset& loaded = dataset.implementation();
  const render::Method method = render::method_of(accuracy);
  render::KernelScratch scratch;
  std::vector<Hit> hits(rays.size());
  ask(render::choose_intersectors(loaded, {.method = method}, machine).first_hit, loaded, {.method = method}, rays,
      hits, scratch);
  return hits;
}

std::vector<render::Machine> scalar_and_wide_machines() {
  std::vector<render::Machine> machines = wide_machines();
  machines.push_back(render::Machine::scalar);
  return machines;
}

TEST(LabelBoundary, is_hit_where_the_analytic_box_is) {
  const Labelled labelled;
  const render::Dataset inner = labelled.surface(3);
  const Affine& world_from_data = labelled.mesh.implementation().world_from_data;
  const std::vector<Ray> rays = rays_from({2.5, 1.5, 1.5}, world_from_data);
  for (const render::Machine machine : scalar_and_wide_machines())
    for (const render::Accuracy accuracy : {render::Accuracy::float32, render::Accuracy::float64}) {
      const std::vector<Hit> hits = hits_of(inner, rays, machine, accuracy);
      for (std::size_t r = 0; r < rays.size(); ++r) {
        const Vec3 from = world_from_data.point(rays[r].origin) - Vec3(2.5, 1.5, 1.5);
        double leaves = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
          const double d = rays[r].direction[axis];
          leaves = std::min(leaves, ((d > 0 ? 0.5 : -0.5) - from[axis]) / d);
        }
        ASSERT_NEAR(hits[r].t, leaves, 1e-6 * (1 + leaves)) << name_of(machine) << ' ' << r;
      }
    }
}

TEST(LabelBoundary, is_hit_at_the_same_t_as_that_of_the_neighbour) {
  const Labelled labelled(0.1);
  const render::Dataset inner = labelled.surface(3), outer = labelled.surface(2);
  const std::vector<Ray> rays = rays_from({2.5, 1.5, 1.5}, labelled.mesh.implementation().world_from_data);
  for (const render::Machine machine : scalar_and_wide_machines())
    for (const render::Accuracy accuracy : {render::Accuracy::float32, render::Accuracy::float64}) {
      const std::vector<Hit> a = hits_of(inner, rays, machine, accuracy), b = hits_of(outer, rays, machine, accuracy);
      for (std::size_t r = 0; r < rays.size(); ++r) {
        ASSERT_TRUE(std::isfinite(a[r].t)) << r;
        ASSERT_EQ(a[r].t, b[r].t) << name_of(machine) << ' ' << r;
        EXPECT_EQ(labelled.neutral.cell_fields[0].values[a[r].cell], 3);
        EXPECT_EQ(labelled.neutral.cell_fields[0].values[b[r].cell], 2);
      }
    }
}

/// Label 3 seen through an opening in label 2.
Framebuffer opened(const Labelled& labelled, const std::vector<int>& labels, const std::vector<double>& opacities) {
  std::vector<render::Dataset> datasets;
  render::Scene scene;
  scene.layers.clear();
  for (std::size_t i = 0; i < labels.size(); ++i) {
    datasets.push_back(labelled.surface(labels[i]));
    render::Layer layer{.dataset = i, .mode = render::Mode::triangles};
    layer.method = render::default_method(datasets[i], layer.mode);
    layer.material.opacity = opacities[i];
    layer.material.ambient = 1;
    layer.material.specular = 0;
    layer.material.color = labels[i] == 3 ? Vec3(1, 0, 0) : Vec3(0, 0, 1);
    layer.clipped = labels[i] == 2;
    scene.layers.push_back(layer);
  }
  scene.lights.clear();
  scene.clip = render::Clip{.planes = {{.point = {2.6, 0, 0}, .normal = {-1, 0, 0}}}};
  scene.camera = render::fit_camera({{2, 1, 1}, {3, 2, 2}}, {.azimuth_deg = 70, .elevation_deg = 21}, 1);
  Framebuffer out;
  render::render(datasets, scene, {.width = 96, .height = 96, .channels = all_channels}, out);
  return out;
}

/// Numbers of pixels that show label 3, label 2, and other colours than that of one or the other.
std::array<std::size_t, 3> counts_of(const Framebuffer& picture) {
  std::array<std::size_t, 3> counts{};
  for (std::size_t p = 0; p < picture.pixel_count(); ++p) {
    if (!std::isfinite(picture.depth[p])) continue;
    const float red = picture.color[4 * p], blue = picture.color[4 * p + 2];
    ++counts[red > 0.9F && blue < 0.1F ? 0 : blue > 0.9F && red < 0.1F ? 1 : 2];
  }
  return counts;
}

TEST(LabelBoundary, between_labels_shows_the_layer_that_comes_first) {
  const Labelled labelled(0.1);
  const auto [inner_first, outer_beside, mixed] = counts_of(opened(labelled, {3, 2}, {1, 1}));
  const auto [inner_last, outer_first, mixed_too] = counts_of(opened(labelled, {2, 3}, {1, 1}));
  EXPECT_EQ(mixed, 0U);
  EXPECT_EQ(mixed_too, 0U);
  EXPECT_GT(inner_first, 2000U);
  // The part of label 3 that stands out of label 2 is seen in both.
  EXPECT_GT(inner_last, 500U);
  EXPECT_GE(inner_first, inner_last);
  EXPECT_EQ(inner_first + outer_beside, inner_last + outer_first);
}

TEST(LabelBoundary, refuses_what_is_not_there) {
  const Labelled labelled;
  expect_error(ErrorCode::invalid, "no cell has label 4 in field 'region'", [&] { (void)labelled.surface(4); });
  expect_error(ErrorCode::usage, "no field 'height' of cells; it has 'region'",
               [&] { (void)labelled.mesh.boundary("height", 1); });
  expect_error(ErrorCode::usage, "has no boundary", [&] { (void)labelled.surface(1).boundary("region", 1); });
}

}  // namespace
}  // namespace rhoray::tests
