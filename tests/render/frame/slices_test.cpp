#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/pack_surface.h"
#include "render/color_map.h"
#include "render/ray_caster.h"
#include "render/shade/place_lookup.h"
#include "tests/agreement/pictures.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/expect_error.h"
#include "tests/support/surfaces.h"

/// Planes that show a field.
namespace rhoray::tests {
namespace {

using render::Clip;
using render::Framebuffer;
using render::HalfSpace;
using render::Layer;
using render::Mode;
using render::Ray;
using render::Scene;

constexpr int edge = 96;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double no_data = std::numeric_limits<double>::quiet_NaN();
const Box3 cube{{-1, -1, -1}, {1, 1, 1}};
const Field sloping = linear_field({0.4, -0.7, 0.3}, 0.2);

Layer slice(std::size_t dataset, const HalfSpace& plane, double opacity = 1) {
  Layer layer{.dataset = dataset, .mode = Mode::slice};
  layer.plane = plane;
  layer.material.color_by =
      render::FieldColors{.field = "value", .map = render::ColorMap::viridis, .range = {-1.2, 1.6}};
  layer.material.lit = false;
  layer.material.opacity = opacity;
  return layer;
}

Layer isosurface(std::size_t dataset, double isovalue, double opacity = 1) {
  Layer layer{.dataset = dataset, .isovalue = isovalue, .method = render::method_of(render::Accuracy::float64)};
  layer.material = {.color = {1, 0, 0}, .ambient = 1, .specular = 0, .opacity = opacity};
  return layer;
}

Scene scene_of(const std::vector<Layer>& layers, const Vec3& offset = {0, 0, 0}) {
  Scene scene;
  scene.layers = layers;
  scene.camera = render::fit_camera(Box3(cube.min + offset, cube.max + offset),
                                    {.azimuth_deg = 33, .elevation_deg = 21, .zoom = 1.1}, 1);
  scene.background = {0.9, 0.8, 0.7};
  return scene;
}

struct Picture {
  Framebuffer pixels;
  render::FrameStatistics statistics;
};

Picture picture_of(const std::vector<render::Dataset>& datasets, const Scene& scene, unsigned threads = 1,
                   bool use_hierarchy = true, int size = edge) {
  Picture picture;
  picture.statistics = render::render(
      datasets, scene,
      {.width = size, .height = size, .channels = all_channels, .threads = threads, .use_hierarchy = use_hierarchy},
      picture.pixels);
  return picture;
}

/// One field as a grid of floats, a sparse grid, one with axis tables, and meshes of both
/// structures.
struct Shown {
  TemporaryFolder folder;
  std::vector<render::Dataset> datasets;

  explicit Shown(const Field& field = sloping, const Vec3& offset = {0, 0, 0}) {
    const Index3 samples(17, 17, 17);
    const Box3 box(cube.min + offset, cube.max + offset);
    datasets.push_back(packed(folder, "dense.rho", sampled_volume<double>(samples, lattice_over(box, samples), field)));
    datasets.push_back(packed(folder, "sparse.rho", sampled_volume<double>(samples, lattice_over(box, samples), field),
                              {.order = preprocess::SampleOrder::sparse}));
    for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
      preprocess::NeutralMesh mesh = box_mesh({.cells = {9, 10, 11}, .box = box, .jitter = 0.14});
      add_point_field(mesh, "value", field);
      datasets.push_back(packed(folder, concat("mesh", datasets.size(), ".rho"), mesh, {.structure = structure}));
    }
    for (std::size_t v = 0; v < 2; ++v) EXPECT_EQ(datasets[v].field_names().size(), 1U);
  }
};

/// Planes of all kinds: between cells, through cells, in the border of the data, outside the data.
std::vector<HalfSpace> planes() {
  return {{.point = {0, 0, 0}, .normal = {0, 0, 1}},      {.point = {0.3, 0, 0.1}, .normal = {-2, 0, 0}},
          {.point = {0, -1, 0}, .normal = {0, 1, 0}},     {.point = {0, 0, 1}, .normal = {0, 0, -3}},
          {.point = {0.2, 0, 0.1}, .normal = {1, -2, 3}}, {.point = {0, 0, 0}, .normal = {1, -1, 0}}};
}

/// Returns how far a point is inside the cube.
double depth_in_cube(const Vec3& place) {
  return 1 - std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)});
}

Layer of_field(Layer layer, const render::Dataset& dataset) {
  layer.material.color_by->field = dataset.field().name;
  return layer;
}

TEST(Slices, show_a_linear_field_where_the_plane_lies_in_the_data) {
  for (const double offset : {0.0, 3e6}) {
    const Vec3 moved_by(offset, -offset, 2 * offset);
    const Shown shown([&](const Vec3& p) { return sloping(p - moved_by); }, moved_by);
    const double rounding = 1e-14 * (1 + 10 * offset);
    for (std::size_t v = 0; v < shown.datasets.size(); ++v)
      for (HalfSpace plane : planes()) {
        plane.point += moved_by;
        const Scene scene = scene_of({of_field(slice(v, plane), shown.datasets[v])}, moved_by);
        const Picture found = picture_of(shown.datasets, scene);
        const std::vector<Ray> rays = camera_rays(shown.datasets[v], scene.camera, edge, edge);
        const Affine& world = world_from_ray_frame(shown.datasets[v]);
        std::size_t inside = 0, outside = 0;
        for (std::size_t p = 0; p < rays.size(); ++p) {
          const Vec3 origin = world.point(rays[p].origin) - moved_by, direction = world.vector(rays[p].direction);
          const double t = plane.normal.dot(plane.point - moved_by - origin) / plane.normal.dot(direction);
          const Vec3 place = origin + t * direction;
          const bool is_in_border = std::abs(plane.normal.normalized().dot(plane.point - moved_by)) == 1;
          // In the border's plane the depth does not depend on that axis.
          double depth = depth_in_cube(place);
          if (is_in_border) {
            Vec3 along = place;
            for (int axis = 0; axis < 3; ++axis)
              if (plane.normal[axis] != 0) along[axis] = 0;
            depth = depth_in_cube(along);
          }
          if (t > 0 && depth > 1e4 * rounding) {
            ++inside;
            ASSERT_NEAR(static_cast<double>(found.pixels.depth[p]), t, 1e-6 * t + rounding) << v << ' ' << p;
            ASSERT_NEAR(found.pixels.value[p], sloping(place), 1e-12 + 1e4 * rounding) << v << ' ' << p;
          } else if (!(t > 0) || depth < -1e4 * rounding) {
            ++outside;
            ASSERT_TRUE(std::isinf(found.pixels.depth[p])) << v << ' ' << p;
          }
        }
        EXPECT_GT(inside, 500);
        EXPECT_GT(outside, 500);
      }
  }
}

TEST(Slices, have_no_gaps_between_the_cells_of_a_mesh) {
  constexpr int size = 1024;
  const Shown shown;
  for (const std::size_t v : {2, 3})
    for (const HalfSpace& plane : {planes()[0], planes()[4]}) {
      Scene scene = scene_of({of_field(slice(v, plane), shown.datasets[v])});
      // So near that the whole picture is inside the mesh.
      scene.camera = {.position = plane.point + 4.0 * plane.normal.normalized(),
                      .target = plane.point,
                      .up = {1, 0.3, 0.1},
                      .orthographic = true,
                      .orthographic_height = 1};
      const Picture found = picture_of(shown.datasets, scene, 2, true, size);
      EXPECT_EQ(hit_count(found.pixels), std::size_t{size} * size);
      EXPECT_EQ(found.statistics.slice_lookups, std::uint64_t{size} * size);
    }
}

TEST(Slices, find_every_place_on_faces_edges_and_points_of_cells) {
  // Cells that are not perturbed: their faces, edges and points are at multiples of 1/16, as are
  // the points of the picture on the plane.
  const TemporaryFolder folder;
  std::vector<render::Dataset> datasets;
  for (const auto structure : {preprocess::MeshStructure::clusters, preprocess::MeshStructure::leaves}) {
    preprocess::NeutralMesh mesh = box_mesh({.cells = {8, 8, 8}, .box = cube});
    add_point_field(mesh, "value", sloping);
    datasets.push_back(packed(folder, concat("mesh", datasets.size(), ".rho"), mesh, {.structure = structure}));
  }
  std::vector<std::vector<std::uint64_t>> cells;
  for (std::size_t v = 0; v < 2; ++v) {
    const render::PlaceLookup lookup(datasets[v].implementation());
    const Vec3 origin = datasets[v].implementation().world_from_data.origin;
    cells.emplace_back();
    for (int z = 0; z <= 16; ++z)
      for (int y = 0; y <= 16; ++y) {
        render::PlacesInPlane places;
        places.normal = {0, 0, 1};
        places.offset = z / 8.0 - 1 - origin.z;
        for (std::size_t axis = 0; axis < 3; ++axis) places.slack[axis] = 1e-13;
        for (std::size_t i = 0; i < render::PlacesInPlane::size; ++i) {
          const Vec3 place = Vec3(static_cast<double>(i % 17) / 8.0 - 1, y / 8.0 - 1, z / 8.0 - 1) - origin;
          for (int axis = 0; axis < 3; ++axis) places.at[axis][i] = place[axis];
          places.is_asked[i] = i < 17;
        }
        render::PlaceAnswers answers;
        lookup(places, answers);
        for (std::size_t i = 0; i < 17; ++i) {
          const Vec3 place(static_cast<double>(i) / 8.0 - 1, y / 8.0 - 1, z / 8.0 - 1);
          ASSERT_NEAR(answers.value[i], sloping(place), 1e-12);
          cells.back().push_back(answers.cell[i]);
        }
        EXPECT_TRUE(std::isnan(answers.value[17]));
        // A point has the same result with others or alone.
        render::PlacesInPlane alone = places;
        for (std::size_t i = 0; i < render::PlacesInPlane::size; ++i) alone.is_asked[i] = i == 5;
        render::PlaceAnswers answer;
        lookup(alone, answer);
        EXPECT_EQ(answer.value[5], answers.value[5]);
        EXPECT_EQ(answer.cell[5], answers.cell[5]);
      }
  }
  EXPECT_EQ(cells[0], cells[1]);
}

TEST(Slices, show_nothing_where_there_is_no_data) {
  // A quarter of the data is absent, up to planes between cells: those show the data beside them.
  const auto field = [](const Vec3& p) { return p.x > 0 && p.z > 0 ? no_data : sloping(p); };
  const Shown shown(field);
  const Layer across_z = slice(0, {.point = {0, 0, 0}, .normal = {0, 0, 1}});
  for (std::size_t v = 0; v < 2; ++v)
    for (const double z : {0.0, 0.0625, -0.0625, 0.125}) {
      Layer layer = across_z;
      layer.dataset = v;
      layer.plane.point.z = z;
      const Scene scene = scene_of({of_field(layer, shown.datasets[v])});
      const Picture found = picture_of(shown.datasets, scene);
      const std::vector<Ray> rays = camera_rays(shown.datasets[v], scene.camera, edge, edge);
      const Affine& world = world_from_ray_frame(shown.datasets[v]);
      std::size_t shown_count = 0, absent = 0;
      for (std::size_t p = 0; p < rays.size(); ++p) {
        const Vec3 origin = world.point(rays[p].origin), direction = world.vector(rays[p].direction);
        const Vec3 place = origin + (z - origin.z) / direction.z * direction;
        if (std::abs(place.x) < 1e-9 || std::abs(depth_in_cube(place)) < 1e-9) continue;
        // Cells with a corner at x > 0 and z > 0 are absent.
        const bool is_shown = depth_in_cube(place) > 0 && (place.x < 0 || z <= 0);
        ASSERT_EQ(found.pixels.depth[p] < static_cast<float>(infinity), is_shown) << z << ' ' << place.x;
        shown_count += is_shown;
        absent += depth_in_cube(place) > 0 && !is_shown;
      }
      EXPECT_GT(shown_count, 300);
      EXPECT_EQ(absent > 300, z > 0);
    }
}

TEST(Slices, have_the_colours_of_the_map_and_no_others) {
  const Shown shown;
  for (std::size_t v = 0; v < shown.datasets.size(); ++v) {
    Scene scene = scene_of({of_field(slice(v, planes()[4]), shown.datasets[v])});
    scene.lights = {{.kind = render::Light::Kind::directional, .place = {0, 0, 1}, .color = {5, 0, 0}}};
    const Picture found = picture_of(shown.datasets, scene);
    std::size_t hits = 0;
    for (std::size_t p = 0; p < found.pixels.pixel_count(); ++p) {
      if (std::isnan(found.pixels.value[p])) continue;
      ++hits;
      const Vec3 expected = render::color_of(render::ColorMap::viridis, (found.pixels.value[p] + 1.2) / 2.8);
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(static_cast<double>(found.pixels.color[4 * p + static_cast<std::size_t>(c)]), expected[c], 2e-3);
      const Vec3 normal = planes()[4].normal.normalized();
      const Vec3 of_pixel(found.pixels.normal[3 * p], found.pixels.normal[3 * p + 1], found.pixels.normal[3 * p + 2]);
      ASSERT_NEAR(std::abs(normal.dot(of_pixel)), 1, 1e-6);
    }
    EXPECT_GT(hits, 1000);
    scene.layers[0].material.lit = true;
    const Picture lit = picture_of(shown.datasets, scene);
    EXPECT_NE(lit.pixels.color, found.pixels.color);
    EXPECT_EQ(lit.pixels.depth, found.pixels.depth);
  }
}

TEST(Slices, lie_among_surfaces_by_their_depth) {
  const Shown shown;
  for (std::size_t v = 0; v < shown.datasets.size(); ++v)
    for (const double slice_opacity : {1.0, 0.5})
      for (const double surface_opacity : {1.0, 0.4}) {
        Layer plane = of_field(slice(v, planes()[4], slice_opacity), shown.datasets[v]);
        const Layer surface = isosurface(v, 0.25, surface_opacity);
        const Picture of_plane = picture_of(shown.datasets, scene_of({plane})),
                      of_surface = picture_of(shown.datasets, scene_of({surface})),
                      both = picture_of(shown.datasets, scene_of({surface, plane}), 3);
        Layer opaque = plane;
        opaque.material.opacity = 1;
        const Picture colors = picture_of(shown.datasets, scene_of({opaque}));
        std::size_t slice_first = 0, surface_first = 0;
        for (std::size_t p = 0; p < both.pixels.pixel_count(); ++p) {
          const float at_plane = of_plane.pixels.depth[p], at_surface = of_surface.pixels.depth[p];
          if (std::abs(at_plane - at_surface) < 1e-5F) continue;
          const bool slice_is_first = at_plane < at_surface;
          slice_first += slice_is_first && std::isfinite(at_surface);
          surface_first += !slice_is_first && std::isfinite(at_plane);
          for (std::size_t c = 0; c < 3; ++c) {
            const float slice_color = colors.pixels.color[4 * p + c], surface_color = c == 0 ? 1.0F : 0.0F;
            float color = 0, through = 1;
            const auto add = [&](float depth, float what, double opacity) {
              if (!std::isfinite(depth)) return;
              color += through * static_cast<float>(opacity) * what;
              through *= 1 - static_cast<float>(opacity);
            };
            if (slice_is_first) add(at_plane, slice_color, slice_opacity);
            add(at_surface, surface_color, surface_opacity);
            if (!slice_is_first) add(at_plane, slice_color, slice_opacity);
            color += through * std::array{0.9F, 0.8F, 0.7F}[c];
            ASSERT_NEAR(both.pixels.color[4 * p + c], color, 1e-5) << p;
          }
        }
        EXPECT_GT(slice_first, 300);
        EXPECT_GT(surface_first, 300);
      }
}

TEST(Slices, are_the_caps_of_what_a_clip_region_cuts_open) {
  const Shown shown;
  const Vec3 normal = Vec3(1, -2, 3).normalized(), in_plane = normal.cross({0, 0, 1}).normalized();
  for (const bool cuts_away : {false, true})
    for (const double sign : {1.0, -1.0})
      for (std::size_t v = 0; v < shown.datasets.size(); ++v) {
        // The same plane, given by another point and with the normal in either direction; the
        // surface passes through it.
        const HalfSpace face{.point = {0.1, 0.2, 0.05}, .normal = normal};
        const HalfSpace told{.point = face.point + 0.7 * in_plane, .normal = sign * 3.7 * normal};
        const Layer cap = of_field(slice(v, told), shown.datasets[v]);
        Scene scene = scene_of({isosurface(v, 0.25), cap});
        scene.clip = Clip{.planes = {{face.point, cuts_away ? normal : -normal}}, .cuts_away = cuts_away};
        scene.camera.position = {1, -6, 9};
        scene.camera.target = {0, 0, 0};
        const Picture found = picture_of(shown.datasets, scene);
        Scene alone = scene_of({cap});
        alone.camera = scene.camera;
        const Picture plane = picture_of(shown.datasets, alone);
        std::size_t caps = 0;
        for (std::size_t p = 0; p < found.pixels.pixel_count(); ++p) {
          if (std::isnan(plane.pixels.value[p])) continue;
          ++caps;
          // What is in front of the plane is clipped, so every pixel of the plane is visible.
          ASSERT_NEAR(found.pixels.depth[p], plane.pixels.depth[p], 1e-5) << p;
          for (std::size_t c = 0; c < 4; ++c)
            ASSERT_NEAR(found.pixels.color[4 * p + c], plane.pixels.color[4 * p + c], 1e-5) << p;
        }
        EXPECT_GT(caps, 1500);
      }
}

TEST(Slices, win_over_surfaces_at_the_same_t) {
  // A field that is z, seen along z: its isosurface is in the slice, bit for bit.
  const TemporaryFolder folder;
  std::vector<render::Dataset> datasets;
  datasets.push_back(packed(folder, "ramp.rho", sampled_volume<double>({9, 9, 9}, Affine(), linear_field({0, 0, 1}))));
  for (const double opacity : {1.0, 0.5})
    for (const double surface_opacity : {1.0, 0.5}) {
      const Layer plane = of_field(slice(0, {.point = {0, 0, 4.5}, .normal = {0, 0, 1}}, opacity), datasets[0]);
      Scene scene = scene_of({isosurface(0, 4.5, surface_opacity), plane});
      scene.camera = {
          .position = {4, 4, 16}, .target = {4, 4, 0}, .up = {0, 1, 0}, .orthographic = true, .orthographic_height = 7};
      Scene alone = scene;
      alone.layers = {plane};
      alone.background = surface_opacity < 1 ? Vec3(0.5) * (Vec3(1, 0, 0) + scene.background) : Vec3(1, 0, 0);
      const Picture found = picture_of(datasets, scene), expected = picture_of(datasets, alone);
      for (std::size_t p = 0; p < found.pixels.pixel_count(); ++p) {
        ASSERT_EQ(found.pixels.depth[p], expected.pixels.depth[p]);
        ASSERT_EQ(found.pixels.value[p], expected.pixels.value[p]);
        ASSERT_EQ(found.pixels.normal[3 * p + 2], 1.0F);
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(found.pixels.color[4 * p + c], expected.pixels.color[4 * p + c], 1e-6);
      }
    }
}

TEST(Slices, show_values_within_a_threshold_only) {
  const Shown shown;
  for (std::size_t v = 0; v < shown.datasets.size(); ++v) {
    Layer layer = of_field(slice(v, planes()[4]), shown.datasets[v]);
    const Picture whole = picture_of(shown.datasets, scene_of({layer}));
    layer.threshold = {-0.1, 0.4};
    const Picture part = picture_of(shown.datasets, scene_of({layer}));
    std::size_t in = 0, out = 0;
    for (std::size_t p = 0; p < whole.pixels.pixel_count(); ++p) {
      const double value = whole.pixels.value[p];
      const bool is_shown = value >= -0.1 && value <= 0.4;
      ASSERT_EQ(std::isfinite(part.pixels.depth[p]), is_shown);
      in += is_shown, out += !is_shown && !std::isnan(value);
    }
    EXPECT_GT(in, 300);
    EXPECT_GT(out, 300);
  }
}

TEST(Slices, are_clipped_unless_they_are_to_be_whole) {
  const Shown shown;
  const Clip region{.box = Box3({-0.4, -3, -3}, {0.5, 3, 3})};
  Layer layer = of_field(slice(0, planes()[4]), shown.datasets[0]);
  const Picture whole = picture_of(shown.datasets, scene_of({layer}));
  Scene scene = scene_of({layer});
  scene.clip = region;
  const Picture part = picture_of(shown.datasets, scene);
  EXPECT_LT(hit_count(part.pixels), hit_count(whole.pixels) * 2 / 3);
  scene.clip->cuts_away = true;
  EXPECT_EQ(hit_count(part.pixels) + hit_count(picture_of(shown.datasets, scene).pixels), hit_count(whole.pixels));
  scene.layers[0].clipped = false;
  EXPECT_EQ(picture_of(shown.datasets, scene).pixels.color, whole.pixels.color);
}

TEST(Slices, are_counted_and_looked_up_only_where_they_are_met) {
  const Shown shown;
  const Picture without = picture_of(shown.datasets, scene_of({isosurface(0, 0.25)}));
  EXPECT_EQ(without.statistics.slice_lookups, 0);
  for (std::size_t v = 0; v < shown.datasets.size(); ++v) {
    Scene scene = scene_of({of_field(slice(v, planes()[4]), shown.datasets[v])});
    scene.camera = render::fit_camera(cube, {.azimuth_deg = 33, .elevation_deg = 21, .zoom = 0.8}, 1);
    const Picture found = picture_of(shown.datasets, scene), slow = picture_of(shown.datasets, scene, 1, false);
    EXPECT_EQ(found.pixels.color, slow.pixels.color);
    EXPECT_EQ(found.pixels.cell, slow.pixels.cell);
    EXPECT_GE(found.statistics.slice_lookups, hit_count(found.pixels));
    EXPECT_LT(found.statistics.slice_lookups, slow.statistics.slice_lookups);
    EXPECT_GT(found.statistics.rays_ruled_out, 500);
    EXPECT_EQ(found.statistics.colors_looked_up, 0);
    // A plane outside the data is not traced.
    const Scene beside = scene_of({of_field(slice(v, {.point = {0, 0, 1.5}, .normal = {0, 0, 1}}), shown.datasets[v])});
    EXPECT_EQ(picture_of(shown.datasets, beside).statistics.slice_lookups, 0);
  }
}

TEST(Slices, are_the_same_bytes_for_any_number_of_threads_in_passes_and_on_every_machine) {
  const Shown shown([](const Vec3& p) { return std::sin(5 * p.x) + p.y * p.z; });
  for (std::size_t v = 0; v < shown.datasets.size(); ++v) {
    const Scene scene = scene_of({of_field(slice(v, planes()[4], 0.7), shown.datasets[v]), isosurface(v, 0.25, 0.5),
                                  of_field(slice(v, planes()[0]), shown.datasets[v])});
    const Picture one = picture_of(shown.datasets, scene), three = picture_of(shown.datasets, scene, 3);
    EXPECT_EQ(one.pixels.color, three.pixels.color);
    EXPECT_EQ(one.statistics.slice_lookups, three.statistics.slice_lookups);
    Framebuffer refined;
    render::RenderContext memory;
    render::refine(shown.datasets, scene, {.width = edge, .height = edge, .channels = all_channels, .threads = 2},
                   {.first_spacing = 4}, refined, memory);
    EXPECT_EQ(one.pixels.color, refined.color);
    EXPECT_EQ(one.pixels.cell, refined.cell);

    const render::LoadedDataset& dataset = shown.datasets[v].implementation();
    render::PlacesInPlane places;
    places.normal = {0, 0, 1}, places.offset = dataset.bounds_data.center().z;
    for (std::size_t i = 0; i < render::PlacesInPlane::size; ++i) {
      const Vec3 low = dataset.bounds_data.min, size = dataset.bounds_data.size();
      places.at[0][i] = low.x + size.x * 0.0157 * static_cast<double>(i);
      places.at[1][i] = low.y + size.y * 0.0113 * static_cast<double>(i);
      places.at[2][i] = places.offset;
      places.is_asked[i] = true;
    }
    for (double& slack : places.slack) slack = 1e-13;
    render::PlaceAnswers plain;
    render::PlaceLookup(dataset, render::Machine::scalar)(places, plain);
    for (const render::Machine machine : wide_machines()) {
      render::PlaceAnswers wide;
      render::PlaceLookup(dataset, machine)(places, wide);
      for (std::size_t i = 0; i < render::PlacesInPlane::size; ++i) {
        ASSERT_EQ(plain.value[i], wide.value[i]);
        ASSERT_EQ(plain.cell[i], wide.cell[i]);
      }
    }
  }
}

TEST(Slices, refuse_what_cannot_be_sliced) {
  const Shown shown;
  const Layer good = of_field(slice(0, planes()[0]), shown.datasets[0]);
  const auto refuse = [&](const auto& spoil, const char* what) {
    Layer layer = good;
    spoil(layer);
    expect_error(ErrorCode::usage, what, [&] { picture_of(shown.datasets, scene_of({layer})); });
  };
  refuse([](Layer& layer) { layer.plane.normal = {0, 0, 0}; }, "expected finite numbers and a direction");
  refuse([](Layer& layer) { layer.plane.point.x = no_data; }, "expected finite numbers and a direction");
  refuse([](Layer& layer) { layer.material.color_by.reset(); }, "a slice without colours");
  refuse([](Layer& layer) { layer.threshold = {2, 1}; }, "a slice of values from 2 to 1");
  const TemporaryFolder folder;
  preprocess::pack_surface(round_surface(2), folder / "ball.rho");
  std::vector<render::Dataset> ball;
  ball.push_back(render::Dataset::load(folder / "ball.rho"));
  expect_error(ErrorCode::usage, "holds triangles", [&] { picture_of(ball, scene_of({good})); });
}

}  // namespace
}  // namespace rhoray::tests
