#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/text.h"
#include "render/query/all_hits.h"
#include "render/ray_caster.h"
#include "render/render.h"
#include "tests/render/support/ask.h"
#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

// Tests what render/README.md, "Which bytes agree", states about instruction sets, and no more.
// Family X04 of the hard cases.
namespace rhoray::tests {

namespace {

using render::Accuracy;
using render::Hit;
using render::Machine;
using render::Ray;

double waves(const Vec3& p) {
  return std::sin(9 * p.x + 0.3) + std::sin(8 * p.y) * std::cos(7 * p.z + 0.2);
}

struct Data {
  std::string name;
  std::unique_ptr<TracedDataset> traced;
  std::vector<double> isovalues;
  Vec3 size;
};

template <class T>
Data grid_of(const std::string& name, double scale, double offset, const preprocess::PackVolumeOptions& options = {},
             const Field& field = waves) {
  const Index3 count(29, 26, 33);
  const auto dataset = sampled_volume<T>(count, lattice_over({{0, 0, 0}, {1, 1, 1}}, count),
                                         [=](const Vec3& p) { return offset + scale * field(p); });
  return {name,
          std::make_unique<TracedDataset>(dataset, options),
          {offset + 0.21 * scale, offset - 0.7 * scale},
          Vec3(count - Index3(1, 1, 1))};
}

Data mesh_of(const std::string& name, double scale, const preprocess::PackMeshOptions& options = {}) {
  const auto mesh = box_mesh({.cells = {8, 8, 8}, .jitter = 0.12}, [=](const Vec3& p) { return scale * waves(p); });
  return {name, std::make_unique<TracedDataset>(mesh, options), {0.21 * scale, -0.7 * scale}, Vec3(1, 1, 1)};
}

std::vector<Data> all_data() {
  preprocess::PackVolumeOptions sparse;
  sparse.order = preprocess::SampleOrder::sparse;
  const Field with_gaps = [](const Vec3& p) {
    return p.x < 0.2 && p.y < 0.3 ? std::numeric_limits<double>::quiet_NaN() : waves(p);
  };
  std::vector<Data> data;
  data.push_back(grid_of<std::uint8_t>("U8", 50, 120));
  data.push_back(grid_of<std::int16_t>("I16", 900, 0));
  data.push_back(grid_of<float>("F32", 1, 0));
  data.push_back(grid_of<float>("F32 with gaps", 1, 0, {}, with_gaps));
  data.push_back(grid_of<float>("F32 sparse with gaps", 1, 0, sparse, with_gaps));
  data.push_back(grid_of<float>("F32 denormal", 1e-39, 0));
  data.push_back(grid_of<double>("F64", 1, 1000));
  data.push_back(mesh_of("mesh", 1));
  data.push_back(mesh_of("mesh of denormals", 1e-309));
  data.push_back(mesh_of("mesh of 1e-33", 1e-33));
  data.push_back(mesh_of("mesh of 1e30", 1e30));
  data.push_back(grid_of<double>("F64 of 1e-33", 1e-33, 0));
  data.push_back(grid_of<double>("F64 denormal", 1e-309, 0));
  data.push_back(mesh_of("mesh with lists", 1, {.structure = preprocess::MeshStructure::leaves}));
  return data;
}

/// Squares of 8 x 8 neighbouring rays from a camera, then rays in all directions and special ones.
std::vector<Ray> rays_through(const Data& data) {
  const render::Dataset& dataset = data.traced->dataset();
  const render::Camera camera =
      render::fit_camera(dataset.bounds(), {.azimuth_deg = 33, .elevation_deg = 21, .zoom = 1.1}, 1);
  const std::vector<Ray> rows = render::camera_rays(dataset, camera, 64, 64);
  std::vector<Ray> rays;
  for (std::size_t block = 0; block < 64; ++block)
    for (std::size_t i = 0; i < 64; ++i) rays.push_back(rows[(block / 8 * 8 + i / 8) * 64 + block % 8 * 8 + i % 8]);
  for (const Ray& ray : stressful_rays(data.size, 1024, 5)) rays.push_back(ray);
  return rays;
}

enum class Asked { crossing, largest };

std::vector<Hit> answers(const Data& data, Asked asked, const render::Method& method, double isovalue, Machine machine,
                         const std::vector<Ray>& rays) {
  const render::LoadedDataset& dataset = data.traced->dataset().implementation();
  const render::Intersectors kernels = render::choose_intersectors(dataset, {.method = method}, machine);
  render::KernelScratch scratch;
  scratch.queue.reserve(kernels.queue_entries);
  std::vector<Hit> hits(rays.size());
  ask(asked == Asked::crossing ? kernels.first_hit : kernels.largest, dataset,
      {.isovalue = isovalue, .field_range = dataset.field.range, .method = method}, rays, hits, scratch);
  return hits;
}

template <class T>
bool same(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// Compares everything that reaches a picture, bit for bit. Two misses are always the same.
bool are_same(const Hit& a, const Hit& b) {
  if (a.is_miss() || b.is_miss()) return a.is_miss() == b.is_miss();
  return same(a.t, b.t) && same(a.value, b.value) && a.cell == b.cell && same(a.gradient, b.gradient) &&
         (same(a.error, b.error) || (std::isnan(a.error) && std::isnan(b.error)));
}

std::size_t count_different(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  std::size_t different = 0;
  for (std::size_t r = 0; r < a.size(); ++r) different += !are_same(a[r], b[r]);
  return different;
}

std::size_t count_hits(const std::vector<Hit>& hits) {
  return static_cast<std::size_t>(std::count_if(hits.begin(), hits.end(), [](const Hit& h) { return !h.is_miss(); }));
}

std::vector<Machine> all_machines() {
  std::vector<Machine> machines = wide_machines();
  machines.insert(machines.begin(), Machine::scalar);
  return machines;
}

/// Calls act(data, rays, isovalue) for all data sets and isovalues.
template <class Act>
void for_each_query(const Act& act) {
  for (const Data& data : all_data()) {
    const std::vector<Ray> rays = rays_through(data);
    for (const double isovalue : data.isovalues) act(data, rays, isovalue);
  }
}

/// Instruction sets on which the answers of a level are the same bit for bit, as the README lists
/// them.
struct Agreement {
  Asked asked;
  Accuracy accuracy;
  std::vector<Machine> machines;
};

std::vector<Agreement> agreements() {
  using enum Machine;
  const std::vector<Machine> all{scalar, baseline, avx2, avx512}, wide{baseline, avx2, avx512}, fused{avx2, avx512};
  return {{Asked::crossing, Accuracy::preview, fused},   {Asked::crossing, Accuracy::float32, fused},
          {Asked::crossing, Accuracy::certified, fused}, {Asked::crossing, Accuracy::float64, all},
          {Asked::largest, Accuracy::preview, wide},     {Asked::largest, Accuracy::float32, wide},
          {Asked::largest, Accuracy::certified, all},    {Asked::largest, Accuracy::float64, all}};
}

/// The first three crossings of each ray with transparent surfaces, the number that float32 finds
/// in one traversal.
std::vector<Hit> clear_crossings(const Data& data, double isovalue, Machine machine, const std::vector<Ray>& rays) {
  const render::LoadedDataset& dataset = data.traced->dataset().implementation();
  const render::AllHitsKernel kernel =
      render::choose_intersectors(dataset, {.isovalue = isovalue, .method = render::method_of(Accuracy::float32)},
                                  machine)
          .all_hits;
  if (kernel == nullptr) return {};
  constexpr std::size_t first_ones = 3;
  render::RayBatch batch(rays.size());
  for (std::size_t r = 0; r < rays.size(); ++r) batch.set(r, rays[r]);
  batch.count = rays.size();
  render::HitBatch first(rays.size());
  render::CrossingList list(rays.size());
  list.put_first_into(first);
  std::vector<std::uint8_t> complete(rays.size());
  render::Scratch memory;
  render::KernelCounters counters;
  const render::TransparentSurface surface{.isovalue = isovalue, .passing = 0.9F};
  render::CrossingList* const lists[] = {&list};
  kernel(dataset, {.surfaces = std::span(&surface, 1)}, batch, std::span(lists), complete.data(), memory, counters);
  std::vector<Hit> hits;
  for (std::size_t r = 0; r < rays.size(); ++r)
    for (std::size_t k = 0; k < first_ones; ++k) {
      hits.push_back(k < list.count[r] ? list.hits(k)[r] : Hit{});
      // Not written: this level proves no bound.
      hits.back().error = std::numeric_limits<double>::quiet_NaN();
    }
  return hits;
}

struct Shown {
  std::string name;
  render::Dataset dataset;
  render::Scene scene;
  int antialiasing = 1;
  bool asks_from_crossings = false;  ///< traces rays that begin on surfaces, for which every level
                                     ///< uses float32
};

/// Every effect, for a grid and for a mesh, at one level.
std::vector<Shown> pictures_of(const Data& data, Accuracy accuracy) {
  const render::Dataset& dataset = data.traced->dataset();
  render::Scene plain;
  plain.layers[0].isovalue = data.isovalues[0];
  plain.layers[0].window = dataset.field().range;
  plain.layers[0].method = render::method_of(accuracy);
  plain.camera = render::fit_camera(dataset.bounds(), {.azimuth_deg = 33, .elevation_deg = 21, .zoom = 1.1}, 1);
  std::vector<Shown> shown;
  const auto add = [&](const std::string& name) -> Shown& {
    return shown.emplace_back(Shown{data.name + ", " + name, dataset, plain});
  };
  add("highlight").scene.layers[0].material.specular = 0.5;
  Shown& lit = add("shadows and occlusion");
  lit.asks_from_crossings = true;
  lit.scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, 0.4, 0.3}, .casts_shadows = true},
                      {.kind = render::Light::Kind::point, .place = {-3, 2, 5}, .casts_shadows = true, .size = 0.2}};
  lit.scene.occlusion = {.samples = 8, .radius = 0.2};
  Shown& colored = add("colours, samples at edges");
  colored.scene.layers[0].material.color_by = {.field = dataset.field().name, .range = dataset.field().range};
  colored.antialiasing = 16;
  Shown& clear = add("clear surfaces");
  clear.asks_from_crossings = true;
  clear.scene.layers.push_back(plain.layers[0]);
  clear.scene.layers[1].isovalue = data.isovalues[1];
  for (render::Layer& layer : clear.scene.layers) layer.material.opacity = 0.5;
  add("largest values").scene.layers[0].mode = render::Mode::mip;
  return shown;
}

using Pictures = std::vector<std::pair<std::string, std::string>>;

/// The bytes of all pictures of a level, by name, rendered with the instruction set that this
/// process uses.
/// @param from_crossings  whether to include pictures with Shown::asks_from_crossings
Pictures picture_bytes(Accuracy accuracy, bool from_crossings) {
  Pictures all;
  const std::vector<Data> data = all_data();
  for (const Data& of : data) {
    if (of.name != "I16" && of.name != "F32" && of.name != "mesh") continue;
    for (const Shown& shown : pictures_of(of, accuracy)) {
      if (shown.asks_from_crossings && !from_crossings) continue;
      render::Framebuffer picture;
      render::render(shown.dataset, shown.scene,
                     {.width = 80,
                      .height = 64,
                      .channels = {.depth = true, .normal = true, .cell = true, .value = true},
                      .antialiasing = shown.antialiasing,
                      .threads = 1},
                     picture);
      std::string bytes;
      const auto add = [&](const auto& numbers) {
        bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(numbers[0]));
      };
      add(picture.color), add(picture.depth), add(picture.normal), add(picture.cell), add(picture.value);
      all.emplace_back(shown.name, bytes);
    }
  }
  return all;
}

constexpr const char* output_variable = "RHORAY_TEST_MACHINES_OUTPUT";
constexpr const char* level_variable = "RHORAY_TEST_MACHINES_LEVEL";
constexpr const char* crossings_variable = "RHORAY_TEST_MACHINES_CROSSINGS";

/// Like picture_bytes, but in a separate process: a process chooses its instruction set once.
Pictures picture_bytes_on(Machine machine, Accuracy accuracy, bool from_crossings) {
  const TemporaryFolder folder;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command =
      concat("RHORAY_MACHINE=", name_of(machine), " ", output_variable, "=", (folder / "out").string(), " ",
             level_variable, "=", static_cast<int>(accuracy), " ", crossings_variable, "=", int{from_crossings}, " '",
             program, "' --gtest_filter=Machines.draw_pictures_with_the_same_bits_as_far_as_is_promised > ",
             (folder / "log").string(), " 2>&1");
  EXPECT_EQ(std::system(command.c_str()), 0) << read_file(folder / "log");
  Pictures all;
  std::ifstream in(folder / "out", std::ios::binary);
  for (std::string name, size; std::getline(in, name) && std::getline(in, size);) {
    std::string bytes(std::stoull(size), '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    all.emplace_back(name, bytes);
  }
  return all;
}

}  // namespace

TEST(Machines, draw_pictures_with_the_same_bits_as_far_as_is_promised) {
  using enum Machine;
  using enum Accuracy;
  const std::vector<Machine> all{scalar, baseline, avx2, avx512}, fused{avx2, avx512};
  if (const char* const output = std::getenv(output_variable)) {
    std::ofstream out(output, std::ios::binary);
    const bool from_crossings = std::string(std::getenv(crossings_variable)) == "1";
    const auto accuracy = static_cast<Accuracy>(std::atoi(std::getenv(level_variable)));
    for (const auto& [name, bytes] : picture_bytes(accuracy, from_crossings))
      out << name << '\n' << bytes.size() << '\n' << bytes;
    return;
  }
  struct Row {
    Accuracy accuracy;
    const std::vector<Machine>& machines;
    bool from_crossings;
    std::size_t count;
  };
  for (const Row& row : {Row{float64, all, false, 9}, Row{float64, fused, true, 15}, Row{float32, fused, true, 15},
                         Row{certified, fused, true, 15}}) {
    Pictures expected;
    for (const Machine machine : row.machines) {
      if (!render::has_machine(machine)) continue;
      const Pictures found = picture_bytes_on(machine, row.accuracy, row.from_crossings);
      ASSERT_EQ(found.size(), row.count);
      if (expected.empty()) expected = found;
      for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_TRUE(found[i].second == expected[i].second)
            << found[i].first << ", " << name_of(machine) << ", level " << static_cast<int>(row.accuracy);
    }
  }
}

TEST(Machines, answer_rays_with_the_same_bits_as_far_as_is_promised) {
  for_each_query([](const Data& data, const std::vector<Ray>& rays, double isovalue) {
    for (const Agreement& agreement : agreements()) {
      // In meshes, exact arithmetic answers these queries on every instruction set. This takes
      // long.
      const bool is_judged = agreement.asked == Asked::largest && agreement.accuracy == Accuracy::certified;
      if (is_judged && data.traced->dataset().is_mesh()) continue;
      if (agreement.asked == Asked::largest && isovalue != data.isovalues.front()) continue;
      std::vector<Hit> expected;
      for (const Machine machine : agreement.machines) {
        if (!render::has_machine(machine)) continue;
        const std::vector<Hit> found =
            answers(data, agreement.asked, render::method_of(agreement.accuracy), isovalue, machine, rays);
        EXPECT_GT(count_hits(found), 1000U) << data.name;
        if (expected.empty()) expected = found;
        EXPECT_EQ(count_different(expected, found), 0U)
            << data.name << ", " << name_of(machine) << ", level " << static_cast<int>(agreement.accuracy)
            << (agreement.asked == Asked::largest ? ", largest values" : ", isovalue ") << isovalue;
      }
    }
  });
}

TEST(Machines, leave_exact_answers_to_one_judge) {
  for (const Data& data : all_data()) {
    const auto of = [&](Machine machine) {
      return render::choose_intersectors(data.traced->dataset().implementation(),
                                         {.method = render::method_of(Accuracy::exact)}, machine);
    };
    for (const Machine machine : wide_machines()) {
      EXPECT_EQ(of(machine).first_hit, of(Machine::scalar).first_hit) << data.name;
      EXPECT_EQ(of(machine).largest, of(Machine::scalar).largest) << data.name;
    }
  }
}

TEST(Machines, cross_clear_surfaces_with_the_same_bits_where_they_fuse) {
  int compared = 0;
  for_each_query([&](const Data& data, const std::vector<Ray>& rays, double isovalue) {
    std::vector<Hit> expected;
    for (const Machine machine : {Machine::avx2, Machine::avx512}) {
      if (!render::has_machine(machine)) continue;
      const std::vector<Hit> found = clear_crossings(data, isovalue, machine, rays);
      if (expected.empty()) expected = found;
      EXPECT_EQ(count_different(expected, found), 0U) << data.name << ", " << name_of(machine);
      compared += !found.empty() && machine == Machine::avx512;
    }
  });
  // Not compared: grids with gaps, and denormal values, for which float32 has too few digits.
  EXPECT_EQ(compared, render::has_machine(Machine::avx512) ? 18 : 0);
}

// Answers that differ in their last bits must still be decided as exact arithmetic decides them,
// and must lie within their bounds, for values of any magnitude. Rounding bounds were once kept as
// floats, in which the bounds of values below 1e-32 were zero.
TEST(Machines, certified_decide_as_the_judge_and_keep_their_bounds) {
  for (const Data& data : all_data()) {
    std::vector<Ray> rays = rays_through(data);
    for (std::size_t r = 0; 2 * r < rays.size(); ++r) rays[r] = rays[2 * r];
    rays.resize(rays.size() / 2);
    const double isovalue = data.isovalues.front();
    const auto of = [&](Accuracy accuracy, Machine machine) {
      return answers(data, Asked::crossing, render::method_of(accuracy), isovalue, machine, rays);
    };
    const std::vector<Hit> truth = of(Accuracy::exact, Machine::scalar);
    for (const Machine machine : all_machines()) {
      const std::vector<Hit> found = of(Accuracy::certified, machine);
      std::size_t wrong = 0, beyond = 0;
      for (std::size_t r = 0; r < rays.size(); ++r) {
        wrong += found[r].is_miss() != truth[r].is_miss();
        if (found[r].is_miss() || truth[r].is_miss()) continue;
        // The rounding of t itself, which the bounds leave out.
        const double rounding = 0x1p-51 * std::abs(found[r].t);
        beyond += !(std::abs(found[r].t - truth[r].t) <= found[r].error + truth[r].error + rounding);
      }
      EXPECT_EQ(wrong, 0U) << data.name << ", " << name_of(machine);
      EXPECT_EQ(beyond, 0U) << data.name << ", " << name_of(machine);
    }
  }
}

// Without this test, the statement could be about one way of computing under three names.
TEST(Machines, that_do_not_fuse_give_other_last_bits) {
#ifdef RHORAY_BASELINE_KERNELS
  GTEST_SKIP() << "this build has SIMD kernels of the baseline only";
#endif
  if (!render::has_machine(Machine::avx2)) GTEST_SKIP() << "this processor has no AVX2";
  std::size_t different = 0;
  for_each_query([&](const Data& data, const std::vector<Ray>& rays, double isovalue) {
    const auto of = [&](Machine machine) {
      return answers(data, Asked::crossing, render::method_of(Accuracy::float32), isovalue, machine, rays);
    };
    different += count_different(of(Machine::baseline), of(Machine::avx2));
  });
  EXPECT_GT(different, 1000U) << "the README says too little: make it say more";
}

}  // namespace rhoray::tests
