#include <openvdb/tools/LevelSetSphere.h>

#include <cmath>
#include <limits>
#include <random>

#include "formats/vdb_grid.h"
#include "preprocess/export_grid.h"
#include "render/all_crossings.h"
#include "tests/agreement/pictures.h"
#include "tests/preprocess/workers/vdb/support.h"
#include "tests/support/expect_error.h"
#include "tests/support/memory_file.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

/// The same hits, depths to 1e-6 of themselves, the same values; cells too, where the grids begin
/// at the same sample.
void expect_same_picture(const render::Framebuffer& a, const render::Framebuffer& b) {
  EXPECT_EQ(a.cell, b.cell);
  ASSERT_EQ(a.depth.size(), b.depth.size());
  for (std::size_t p = 0; p < a.depth.size(); ++p) {
    if (a.cell[p] == render::Framebuffer::no_cell) continue;
    ASSERT_NEAR(a.depth[p], b.depth[p], 1e-6 * static_cast<double>(a.depth[p]));
    ASSERT_NEAR(a.value[p], b.value[p], 1e-9 * (1 + std::abs(a.value[p])));
  }
}

/// Rays that pass the edges of what holds light back may be decided by rounding.
void expect_same_light(const render::Framebuffer& a, const render::Framebuffer& b) {
  std::size_t differing = 0;
  for (std::size_t i = 0; i < a.color.size(); ++i) differing += std::abs(a.color[i] - b.color[i]) > 1e-4F;
  EXPECT_LT(differing, a.color.size() / 200);
}

class NanoVdbData : public Vdb {
 protected:
  static std::uint64_t shadow_rays_of(const render::Dataset& volume, const render::Scene& scene) {
    render::Framebuffer framebuffer;
    return render::render(volume, scene, {.width = 96, .height = 96}, framebuffer).shadow_rays;
  }

  /// The same samples as a packed grid and as .vdb, drawn both ways.
  void expect_agreement(const NeutralVolume& volume, double isovalue) {
    pack_volume(volume, folder_ / "a.rho");
    export_vdb(folder_ / "a.rho", folder_ / "a.vdb");
    const render::Dataset packed = render::Dataset::load(folder_ / "a.rho"), sparse = loaded(folder_ / "a.vdb");
    EXPECT_EQ(sparse.bounds(), packed.bounds());
    EXPECT_EQ(sparse.field().range, packed.field().range);
    EXPECT_EQ(sparse.field().no_data_count, packed.field().no_data_count);
    for (render::Scene scene : {oblique_scene(packed, isovalue), straight_scene(packed, isovalue)}) {
      const std::vector<render::Light> lights = scene.lights;
      const render::Framebuffer expected = picture(packed, scene);
      EXPECT_GT(hit_count(expected), 500U);
      expect_same_picture(picture(sparse, scene), expected);
      expect_same_picture(picture(sparse, scene, {.use_hierarchy = false}), expected);
      for (const render::Accuracy accuracy : {render::Accuracy::float32, render::Accuracy::certified}) {
        scene.layers[0].method = render::method_of(accuracy);
        expect_same_bits(picture(sparse, scene), picture(packed, scene));
      }
      scene.layers[0].method = render::method_of(render::Accuracy::float32);
      scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, -2, 3}, .casts_shadows = true}};
      EXPECT_EQ(shadow_rays_of(sparse, scene), shadow_rays_of(packed, scene));
      expect_same_bits(picture(sparse, scene), picture(packed, scene));
      scene.lights = lights;
      scene.layers[0].material.opacity = 0.5;
      scene.layers.push_back(scene.layers[0]);
      scene.layers[1].isovalue += 1;
      expect_same_bits(picture(sparse, scene), picture(packed, scene));
      scene.layers.pop_back();
      scene.layers[0].material.opacity = 1;
      scene.layers[0].method = {};
      scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, -2, 3}, .casts_shadows = true}, {}};
      scene.occlusion = {.samples = 2, .radius = packed.bounds().size().length() / 8};
      expect_same_light(picture(sparse, scene), picture(packed, scene));
      scene.layers[0].mode = render::Mode::mip;
      const render::Framebuffer brightest = picture(packed, scene);
      EXPECT_GT(hit_count(brightest), 500U);
      expect_same_picture(picture(sparse, scene), brightest);
      const render::HalfSpace plane{.point = packed.bounds().center(), .normal = {1, -2, 3}};
      scene.clip = render::Clip{.planes = {plane}};
      expect_same_picture(picture(sparse, scene), picture(packed, scene));
      scene.layers[0].mode = render::Mode::slice;
      scene.layers[0].plane = plane;
      scene.layers[0].material.color_by =
          render::FieldColors{.field = packed.field().name, .range = packed.field().range};
      const render::Framebuffer sliced = picture(packed, scene);
      EXPECT_GT(hit_count(sliced), 250U);
      expect_same_picture(picture(sparse, scene), sliced);
    }
  }
};

const Affine turned{{0.1, 2, 0}, {3, 0, 0.1}, {0, 0.2, -0.7}, {10, 20, 30}};

TEST_F(NanoVdbData, shows_the_same_as_the_packed_grid_of_the_same_samples) {
  expect_agreement(noise_volume<float>({37, 21, 30}, 100, 7, turned), 60);
}

// A linear field is that of a mesh, too: one scene, three ways to hold its field.
TEST_F(NanoVdbData, shows_of_a_linear_field_what_a_grid_and_tetrahedra_show) {
  const Box3 box{{-2, 1, 5}, {1, 3, 9}};
  const Index3 count(31, 21, 41);
  const Field field = linear_field({0.3, -0.4, 0.9}, 0.7);
  const render::Dataset grid = packed(folder_, "a.rho", sampled_volume<float>(count, lattice_over(box, count), field));
  export_vdb(folder_ / "a.rho", folder_ / "a.vdb");
  const render::Dataset sparse = loaded(folder_ / "a.vdb");
  const render::Dataset mesh =
      packed(folder_, "m.rho", box_mesh({.cells = {7, 6, 5}, .box = box, .jitter = 0.15}, field));
  render::Scene scene = oblique_scene(grid, field(box.center()) + 0.01);
  scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, -2, 3}, .casts_shadows = true}, {}};
  scene.occlusion = {.samples = 2, .radius = 1};
  scene.fog = render::Fog{.color = {0, 0, 1}, .range = {.lo = 5, .hi = 25}};
  const render::Framebuffer expected = picture(grid, scene);
  EXPECT_GT(hit_count(expected), 500U);
  for (const render::Dataset* volume : {&sparse, &mesh}) {
    const render::Framebuffer found = picture(*volume, scene);
    for (std::size_t p = 0; p < expected.depth.size(); ++p) {
      const bool is_hit = expected.cell[p] != render::Framebuffer::no_cell;
      ASSERT_EQ(found.cell[p] != render::Framebuffer::no_cell, is_hit) << p;
      // Samples are numbers of single precision: the plane is off by 1e-7 of them, seen at a slant.
      if (is_hit) {
        ASSERT_NEAR(found.depth[p], expected.depth[p], 1e-5);
      }
    }
    expect_same_light(found, expected);
  }
}

TEST_F(NanoVdbData, shows_the_same_where_most_of_it_is_constant) {
  const auto sample = [](const Index3& s) {
    const auto far = [](std::int64_t a) { return static_cast<double>(a - 40); };
    return static_cast<float>(
        std::max(0.0, 30 - std::sqrt(far(s.x) * far(s.x) + far(s.y) * far(s.y) + far(s.z) * far(s.z))));
  };
  expect_agreement(volume_of<float>({90, 70, 81}, sample), 5);
}

TEST_F(NanoVdbData, has_no_surface_at_the_border_of_samples_without_data) {
  const auto sample = [](const Index3& s) {
    const bool is_missing = (s.x * s.x + 3 * s.y + s.z) % 11 == 0 || (s.x > 12 && s.x < 25);
    return is_missing ? std::numeric_limits<float>::quiet_NaN()
                      : static_cast<float>((s.x * 7 + s.y * 5 + s.z * 3) % 32);
  };
  expect_agreement(volume_of<float>({40, 33, 29}, sample, turned), 16);
}

TEST_F(NanoVdbData, has_the_crossings_of_the_packed_grid) {
  pack_volume(noise_volume<float>({19, 16, 17}, 100, 7), folder_ / "a.rho");
  export_vdb(folder_ / "a.rho", folder_ / "a.vdb");
  const render::Dataset packed = render::Dataset::load(folder_ / "a.rho"), sparse = loaded(folder_ / "a.vdb");
  std::size_t found = 0;
  for (int r = 0; r < 50; ++r) {
    const render::Ray ray{{-1, 0.3 * r, 8.5}, {1, 0.2 - 0.01 * r, 0.125}};
    const auto expected = render::all_crossings(packed, 50, ray, 100),
               same = render::all_crossings(sparse, 50, ray, 100);
    ASSERT_EQ(same.crossings.size(), expected.crossings.size()) << r;
    for (std::size_t c = 0; c < expected.crossings.size(); ++c) {
      EXPECT_EQ(same.crossings[c].t, expected.crossings[c].t) << r;
      EXPECT_EQ(same.crossings[c].cell, expected.crossings[c].cell) << r;
      EXPECT_EQ(same.crossings[c].to_inside, expected.crossings[c].to_inside) << r;
    }
    found += expected.crossings.size();
  }
  EXPECT_GT(found, 150U);
}

TEST_F(NanoVdbData, draws_a_level_set_where_its_distance_is_zero) {
  const double radius = 10, voxel = 0.25;
  const openvdb::Vec3f center(3, -4, 5);
  const auto sphere = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(static_cast<float>(radius), center,
                                                                               static_cast<float>(voxel));
  sphere->setName("ls");
  const render::Dataset volume = loaded(write("sphere.vdb", {sphere}));
  EXPECT_TRUE(volume.is_level_set());
  const render::Scene scene = oblique_scene(volume, 0);
  const render::Framebuffer found = picture(volume, scene);
  const Box3 box = volume.isosurface_bounds(0);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(box.min[axis], static_cast<double>(center[axis]) - radius, 9 * voxel);
    EXPECT_NEAR(box.max[axis], static_cast<double>(center[axis]) + radius, 9 * voxel);
  }
  // Between samples of the distance the surface lies inside by at most a cell's sagitta, 3 (voxel /
  // 2)^2 / (2 radius).
  const double sagitta = 3 * (voxel / 2) * (voxel / 2) / (2 * radius) + 1e-4;
  const Vec3 forward = (scene.camera.target - scene.camera.position).normalized();
  std::size_t hits = 0, missed = 0;
  for (int y = 0; y < found.height; ++y)
    for (int x = 0; x < found.width; ++x) {
      const double tan_half = std::tan(scene.camera.vertical_fov_deg * std::numbers::pi / 360);
      const Vec3 right = forward.cross(scene.camera.up).normalized(), down = forward.cross(right);
      const Vec3 ray =
          (forward + tan_half * (((2 * x + 1.0) / found.width - 1) * right + ((2 * y + 1.0) / found.height - 1) * down))
              .normalized();
      const Vec3 to_center = Vec3(center[0], center[1], center[2]) - scene.camera.position;
      const double closest = (to_center - ray.dot(to_center) * ray).length();
      const auto pixel = static_cast<std::size_t>(y * found.width + x);
      const bool is_hit = found.cell[pixel] != render::Framebuffer::no_cell;
      EXPECT_FALSE(is_hit && closest > radius + 1e-4);
      if (closest > radius - 2 * sagitta) continue;
      if (!is_hit) {
        ++missed;
        continue;
      }
      ++hits;
      const Vec3 at = static_cast<double>(found.depth[pixel]) * ray - to_center;
      ASSERT_NEAR(at.length(), radius, sagitta);
    }
  EXPECT_EQ(missed, 0U);
  EXPECT_GT(hits, 1000U);
}

// Leaf nodes begin at multiples of 8 voxels, the box of active voxels and so the blocks of cells do
// not; and some leaf nodes are tiles of one value.
TEST_F(NanoVdbData, is_answered_wide_where_its_box_begins_anywhere) {
  const auto grid = named_grid<openvdb::FloatGrid>("f", 2);
  std::mt19937 random(5);
  const openvdb::CoordBBox noisy(openvdb::Coord(-13, 3, 5), openvdb::Coord(17, 29, 38));
  for (auto at = noisy.begin(); at; ++at) grid->tree().setValueOn(*at, static_cast<float>(random() % 6));
  grid->fill(openvdb::CoordBBox(openvdb::Coord(-8, 8, 8), openvdb::Coord(7, 15, 23)), 4.0F, true);
  grid->fill(openvdb::CoordBBox(openvdb::Coord(20, 3, 5), openvdb::Coord(36, 12, 20)), 3.0F, true);
  grid->tree().prune();
  const render::Dataset volume = loaded(write("anywhere.vdb", {grid}));
  EXPECT_EQ(render::default_method(volume, render::Mode::isosurface), render::method_of(render::Accuracy::float32));
  for (render::Scene scene : {oblique_scene(volume, 2.6), straight_scene(volume, 2.6)}) {
    const render::Framebuffer expected = picture(volume, scene);
    EXPECT_GT(hit_count(expected), 2000U);
    for (const render::Accuracy accuracy : {render::Accuracy::float32, render::Accuracy::certified}) {
      scene.layers[0].method = render::method_of(accuracy);
      const render::Framebuffer found = picture(volume, scene);
      std::size_t elsewhere = 0;
      for (std::size_t p = 0; p < found.depth.size(); ++p) {
        ASSERT_EQ(std::isfinite(found.depth[p]), std::isfinite(expected.depth[p])) << p;
        if (std::isfinite(found.depth[p])) elsewhere += std::abs(found.depth[p] - expected.depth[p]) > 1e-4F;
      }
      // Along tangents single precision may find the next crossing.
      EXPECT_LE(elsewhere, 2U);
    }
  }
}

TEST_F(NanoVdbData, skips_space_in_which_nothing_is_stored) {
  const auto grid = named_grid<openvdb::FloatGrid>("f", 0);
  for (const int at : {0, 2100})
    grid->fill(openvdb::CoordBBox(openvdb::Coord(at), openvdb::Coord(at + 30)), 1.0F, true);
  const render::Dataset volume = loaded(write("far.vdb", {grid}));
  const render::Scene scene = oblique_scene(volume, 0.5);
  render::Framebuffer framebuffer;
  const render::FrameStatistics statistics = render::render(volume, scene, {.width = 256, .height = 256}, framebuffer);
  EXPECT_GT(statistics.hits, 0U);
  EXPECT_LT(statistics.cells_visited, 100 * statistics.hits);
}

TEST_F(NanoVdbData, refuses_a_buffer_whose_nodes_lie_outside) {
  const auto grid = named_grid<openvdb::FloatGrid>("f", 0);
  for (int i = 0; i < 40; ++i) grid->tree().setValueOn(openvdb::Coord(i, 2 * i, i), 1);
  const formats::VdbGrid good(open_vdb(write("a.vdb", {grid}), ""));
  std::vector<std::uint8_t> buffer(good.buffer().size());
  std::memcpy(buffer.data(), good.buffer().data(), buffer.size());
  const auto load = [&](const std::vector<std::uint8_t>& bytes) {
    const MemoryFile file;
    formats::PackedFileWriter writer(
        file.descriptor(), formats::describe(good.description()),
        {{.name = formats::VdbGrid::buffer_array, .type = formats::ElementType::U8, .shape = {bytes.size()}}});
    writer.write_all(formats::VdbGrid::buffer_array, std::span<const std::uint8_t>(bytes));
    writer.commit();
    return render::Dataset::load(formats::PackedFile::from_descriptor(file.descriptor(), "memory"));
  };
  EXPECT_EQ(load(buffer).field().name, "f");
  const auto short_one = std::vector<std::uint8_t>(buffer.begin(), buffer.end() - 64);
  expect_error(ErrorCode::invalid, "memory", [&] { load(short_one); });
  expect_error(ErrorCode::invalid, "memory", [&] { load(std::vector<std::uint8_t>(100)); });
  // Wherever eight bytes may be an offset, a wild one is refused or was no offset; nothing reads
  // outside.
  int refused = 0;
  for (std::size_t at = 0; at + 8 <= buffer.size(); at += 8 * (at < 2000 ? 1 : 997)) {
    std::vector<std::uint8_t> changed = buffer;
    for (std::size_t byte = 0; byte < 8; ++byte) changed[at + byte] = static_cast<std::uint8_t>(byte < 6 ? 0x55 : 0);
    try {
      picture(load(changed), oblique_scene(load(changed), 0.5), {.width = 8, .height = 8});
    } catch (const Error& error) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 5);
}

}  // namespace
}  // namespace rhoray::preprocess
