#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "formats/base/text.h"
#include "preprocess/inspect_mesh.h"
#include "preprocess/resample.h"
#include "render/ray_caster.h"
#include "tests/agreement/pictures.h"
#include "tests/support/equal_bytes.h"
#include "tests/support/host_floating_point.h"

// A host program may have enabled flushing of denormal numbers, or may have set another rounding
// mode. It may do so for its own arithmetic, or because one of its libraries was built with
// -ffast-math. Our proofs hold for the default floating-point environment. Therefore everything
// that computes sets the default environment and restores the host's afterwards. Families D05, X02
// and X03 of the hard cases.
namespace rhoray::tests {

namespace {

struct Data {
  std::string name;
  std::filesystem::path path;
  double isovalue;
};

double waves(const Vec3& p) {
  return std::sin(5 * p.x + 0.3) + std::sin(4 * p.y) * std::cos(6 * p.z + 0.2);
}

/// Grids and meshes of ordinary values, of values whose differences are denormal, and of denormal
/// values.
std::vector<Data> data_in(const TemporaryFolder& folder) {
  const Index3 count(13, 13, 13);
  const Affine lattice = lattice_over({{0, 0, 0}, {1, 1, 1}}, count);
  const auto scaled = [](double scale) { return [=](const Vec3& p) { return scale * waves(p); }; };
  constexpr double isovalue = 0.21;
  std::vector<Data> data;
  const auto add_grid = [&](const std::string& name, const preprocess::NeutralVolume& volume, double scale) {
    preprocess::pack_volume(volume, folder / name);
    data.push_back({name, folder / name, isovalue * scale});
  };
  const auto add_mesh = [&](const std::string& name, double scale, bool is_single) {
    preprocess::pack_mesh(box_mesh({.cells = {5, 5, 5}, .jitter = 0.1}, scaled(scale), is_single), folder / name);
    data.push_back({name, folder / name, isovalue * scale});
  };
  add_grid("grid", sampled_volume<float>(count, lattice, scaled(1)), 1);
  add_grid("grid of denormal floats", sampled_volume<float>(count, lattice, scaled(1e-39)), 1e-39);
  add_grid("grid of denormal doubles", sampled_volume<double>(count, lattice, scaled(1e-309)), 1e-309);
  add_mesh("mesh", 1, false);
  add_mesh("mesh of denormal floats", 1e-39, true);
  add_mesh("mesh of denormal doubles", 1e-309, false);
  return data;
}

struct Asked {
  std::string name;
  render::Mode mode;
  render::Accuracy accuracy;
  bool has_shadows = false;
};

std::vector<Asked> queries() {
  using enum render::Accuracy;
  const auto iso = render::Mode::isosurface, mip = render::Mode::mip;
  return {{"isosurface, float", iso, float32},
          {"isosurface, double", iso, float64},
          {"isosurface, certified", iso, certified},
          {"isosurface, exact", iso, exact},
          {"largest values, double", mip, float64},
          {"largest values, certified", mip, certified},
          {"shadows", iso, float32, true}};
}

/// Loads the file and renders it, as a host program does.
render::Framebuffer picture_of(const Data& data, const Asked& asked, unsigned threads) {
  const render::Dataset volume = render::Dataset::load(data.path);
  render::Scene scene = oblique_scene(volume, data.isovalue);
  scene.layers[0].mode = asked.mode;
  scene.layers[0].method = render::method_of(asked.accuracy);
  if (asked.has_shadows)
    scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, 0.4, 0.3}, .casts_shadows = true}};
  render::FrameOptions options{.width = 48, .height = 40, .channels = all_channels, .threads = threads};
  options.channels.error = render::proves(scene.layers[0].method);
  render::Framebuffer picture;
  render::render(volume, scene, options, picture);
  return picture;
}

/// Calls act() in a new thread with that environment. The thread is new, so oneTBB knows no other
/// environment for it.
/// @return  whether the thread was still in that environment afterwards
template <class Act>
bool in_a_thread_of(const HostFloatingPoint& environment, const Act& act) {
  bool is_kept = false;
  std::thread([&] {
    const InHostFloatingPoint host(environment);
    act();
    is_kept = host.is_kept();
  }).join();
  return is_kept;
}

bool are_same(const render::Framebuffer& a, const render::Framebuffer& b) {
  return equal_bytes(a.color, b.color) && equal_bytes(a.depth, b.depth) && equal_bytes(a.normal, b.normal) &&
         equal_bytes(a.cell, b.cell) && equal_bytes(a.value, b.value) && equal_bytes(a.error, b.error);
}

}  // namespace

TEST(FloatingPoint, of_the_host_does_not_change_pictures_and_is_kept) {
  const TemporaryFolder folder;
  for (const Data& data : data_in(folder))
    for (const Asked& asked : queries()) {
      const render::Framebuffer expected = picture_of(data, asked, 1);
      EXPECT_GT(hit_count(expected), 200U) << data.name << ", " << asked.name << ": shows too little";
      for (const HostFloatingPoint& environment : host_environments())
        for (const unsigned threads : {1U, 2U}) {
          render::Framebuffer found;
          const bool is_kept = in_a_thread_of(environment, [&] { found = picture_of(data, asked, threads); });
          EXPECT_TRUE(are_same(expected, found))
              << data.name << ", " << asked.name << ", " << environment.name << ", " << threads << " threads";
          EXPECT_TRUE(is_kept) << data.name << ", " << asked.name << ", " << environment.name;
        }
    }
}

// Threads of a pool may have been started in the host's environment, and keep it.
TEST(FloatingPoint, of_threads_that_began_in_the_hosts_does_not_change_pictures) {
  const TemporaryFolder folder;
  const std::vector<Data> all = data_in(folder);
  for (const HostFloatingPoint& environment : host_environments()) {
    render::RenderContext memory;
    for (const Data& data : all) {
      const render::Dataset volume = render::Dataset::load(data.path);
      render::Scene scene = oblique_scene(volume, data.isovalue);
      scene.layers[0].method = render::method_of(render::Accuracy::certified);
      render::FrameOptions options{.width = 96, .height = 96, .channels = all_channels, .threads = 4};
      render::Framebuffer expected, first, found;
      render::render(volume, scene, options, expected);
      {
        const InHostFloatingPoint host(environment);
        render::render(volume, scene, options, first, memory);
      }
      render::render(volume, scene, options, found, memory);
      EXPECT_TRUE(are_same(expected, first)) << data.name << ", " << environment.name;
      EXPECT_TRUE(are_same(expected, found)) << data.name << ", " << environment.name;
    }
  }
}

TEST(FloatingPoint, of_the_host_does_not_change_answers_to_rays_and_is_kept) {
  const TemporaryFolder folder;
  for (const Data& data : data_in(folder)) {
    const auto answers = [&](render::Accuracy accuracy, bool is_largest) {
      const render::Dataset volume = render::Dataset::load(data.path);
      const render::Camera camera = oblique_scene(volume, data.isovalue).camera;
      const std::vector<render::Ray> rays = render::camera_rays(volume, camera, 24, 24);
      std::vector<render::Hit> hits(rays.size());
      render::RayCaster queries(volume, data.isovalue, render::method_of(accuracy), 1);
      if (is_largest)
        queries.largest_values(rays, hits);
      else
        queries.first_crossings(rays, hits);
      const Box3 bounds = volume.isosurface_bounds(data.isovalue);
      hits.push_back(
          {.t = bounds.min.x, .value = bounds.max.z, .gradient = {bounds.min.y, bounds.min.z, bounds.max.y}});
      return hits;
    };
    for (const render::Accuracy accuracy : {render::Accuracy::float64, render::Accuracy::certified})
      for (const bool is_largest : {false, true}) {
        const std::vector<render::Hit> expected = answers(accuracy, is_largest);
        for (const HostFloatingPoint& environment : host_environments()) {
          std::vector<render::Hit> found;
          const bool is_kept = in_a_thread_of(environment, [&] { found = answers(accuracy, is_largest); });
          std::size_t different = 0;
          for (std::size_t r = 0; r < found.size(); ++r)
            different += std::memcmp(&expected[r].t, &found[r].t, sizeof(double)) != 0 ||
                         std::memcmp(&expected[r].value, &found[r].value, sizeof(double)) != 0 ||
                         std::memcmp(&expected[r].gradient, &found[r].gradient, sizeof(Vec3)) != 0 ||
                         expected[r].cell != found[r].cell;
          EXPECT_EQ(different, 0U) << data.name << ", " << environment.name << ", largest " << is_largest;
          EXPECT_TRUE(is_kept) << data.name << ", " << environment.name;
        }
      }
  }
}

// Three results are checked. The structures of packed files are proven to hold the cells. Samples
// on a lattice are decided exactly. A resampled grid keeps a proven error bound.
TEST(FloatingPoint, of_the_host_does_not_change_packed_files_and_findings_and_is_kept) {
  const TemporaryFolder folder;
  for (const double scale : {1.0, 1e-309}) {
    const preprocess::NeutralMesh mesh =
        box_mesh({.cells = {5, 5, 5}, .jitter = 0.1}, [=](const Vec3& p) { return scale * waves(p); });
    const Index3 count(13, 13, 13);
    const auto volume = sampled_volume<double>(count, lattice_over({{0, 0, 0}, {1, 1, 1}}, count),
                                               [=](const Vec3& p) { return scale * waves(p); });
    int number = 0;
    const auto made = [&] {
      const auto path = [&](const char* name) { return folder / concat(name, scale, number++); };
      const std::filesystem::path of_mesh = path("mesh"), lists = path("lists"), grid = path("grid"),
                                  resampled = path("resampled");
      preprocess::pack_mesh(mesh, of_mesh);
      preprocess::pack_mesh(mesh, lists, {.structure = preprocess::MeshStructure::leaves});
      preprocess::pack_volume(volume, grid);
      preprocess::ResampleOptions options;
      options.lattice.sample_count = Index3(20, 20, 20);
      preprocess::resample(mesh, resampled, options);
      std::vector<std::string> all{read_file(of_mesh), read_file(lists), read_file(grid), read_file(resampled)};
      for (const preprocess::Finding& finding : preprocess::inspect_mesh(mesh))
        all.push_back(concat(finding.name, finding.count));
      return all;
    };
    const std::vector<std::string> expected = made();
    for (const HostFloatingPoint& environment : host_environments()) {
      std::vector<std::string> found;
      const bool is_kept = in_a_thread_of(environment, [&] { found = made(); });
      ASSERT_EQ(expected.size(), found.size());
      for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_TRUE(expected[i] == found[i]) << "part " << i << ", " << environment.name << ", scale " << scale;
      EXPECT_TRUE(is_kept) << environment.name;
    }
  }
}

}  // namespace rhoray::tests
