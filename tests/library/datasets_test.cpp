// Handles of data, and files that are wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/resealed.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

constexpr Size size{40, 30};

TEST(Datasets, live_as_long_as_a_scene_a_caster_or_a_sampler_holds_them) {
  const TemporaryFolder folder;
  gyroid_grid({.file = folder / "grid.rho"});
  const Picture expected = rendered(certified_scene(gyroid_grid(), 0.1, size), {.size = size});
  const MadeRays rays = random_rays(gyroid_grid().bounds(), 50);
  std::vector<double> t(50), again(50), value(50);
  RayScratch scratch;
  RayCaster(gyroid_grid(), Isosurface{0.1}, Accuracy::exact).first_hits(rays.rays(), {.t = t}, scratch);
  std::optional<Dataset> handle = Dataset::open(folder / "grid.rho");
  const Scene scene = certified_scene(*handle, 0.1, size);
  const RayCaster caster(*handle, Isosurface{0.1}, Accuracy::exact);
  const FieldSampler sampler(*handle);
  handle.reset();
  std::filesystem::remove(folder / "grid.rho");
  EXPECT_TRUE(bits_of(rendered(scene, {.size = size})) == bits_of(expected));
  caster.first_hits(rays.rays(), {.t = again}, scratch);
  EXPECT_EQ(again, t);
  std::vector<double> expected_value(50);
  FieldSampler(gyroid_grid()).at(rays.rays().origins, expected_value);
  sampler.at(rays.rays().origins, value);
  EXPECT_TRUE(std::equal(value.begin(), value.end(), expected_value.begin(),
                         [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }));
}

TEST(Datasets, and_what_holds_them_can_be_used_after_they_were_moved_from) {
  Dataset data = gyroid_grid();
  const Dataset other = std::move(data);
  EXPECT_EQ(data.id(), other.id());  // NOLINT: a move is a copy
  RayCaster caster(data, Isosurface{0.1}, Accuracy::exact);
  FieldSampler sampler(data);
  const RayCaster moved_caster = std::move(caster);
  const FieldSampler moved_sampler = std::move(sampler);
  const MadeRays rays = random_rays(data.bounds(), 5);
  std::vector<double> t(5), again(5), value(5);
  RayScratch scratch;
  caster.first_hits(rays.rays(), {.t = t}, scratch);  // NOLINT
  moved_caster.first_hits(rays.rays(), {.t = again}, scratch);
  EXPECT_EQ(t, again);
  sampler.at(rays.rays().origins, value);  // NOLINT
}

TEST(Datasets, of_names_that_the_system_refuses_are_refused) {
  const TemporaryFolder folder;
  std::filesystem::create_symlink("loop.rho", folder / "loop.rho");
  for (const std::string& name : {std::string(300, 'x'), std::string("loop.rho"), std::string("grid.rho/inside")}) {
    expect_refused(ErrorCode::unreadable, name, [&] { Dataset::open(folder / name); });
    expect_refused(ErrorCode::unreadable, name, [&] { Texture::open(folder / name); });
  }
  const Dataset grid = gyroid_grid();
  expect_refused(ErrorCode::usage, std::string(300, 'x'), [&] { grid.save(folder / std::string(300, 'x')); });
}

TEST(Datasets, have_a_path_that_another_process_can_open) {
  const TemporaryFolder folder;
  const Dataset in_memory = gyroid_grid();
  EXPECT_EQ(run_program({RHORAY_PROGRAM, "info", in_memory.path().string()}).exit_code, 0);
  EXPECT_EQ(gyroid_grid({.file = folder / "grid.rho"}).path(), folder / "grid.rho");
  const Dataset boundary = ball_mesh().boundary();
  expect_refused(ErrorCode::usage, "boundary of a mesh in memory", [&] { boundary.path(); });
  expect_refused(ErrorCode::usage, "save: this is the boundary of a mesh", [&] { boundary.save(folder / "b.rho"); });
  expect_refused(ErrorCode::usage, ": no array 'nothing'; it has ", [&] { in_memory.array("nothing"); });
}

TEST(Datasets, open_and_close_two_hundred_times) {
  const TemporaryFolder folder;
  gyroid_grid({.file = folder / "grid.rho"});
  const Samples<float> samples = samples_of<float>(24, 20, 16, [](auto i, auto, auto) { return i % 5; });
  pack({.fields = {samples.field("gyroid")}, .spacing = {0.5, 0.5, 0.75}, .origin = {-3, 1, 2}}, AxisOrder::zyx,
       {.file = folder / "other.rho"});
  const auto open_files = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
  };
  // One context for files that alternate, mapped at the same addresses: it never shows the other.
  RenderContext context;
  Picture picture;
  std::set<std::uint64_t> ids;
  std::string bits[2];
  std::ptrdiff_t files = 0;
  for (int turn = 0; turn < 200; ++turn) {
    const Dataset data = Dataset::open(folder / (turn % 2 == 0 ? "grid.rho" : "other.rho"));
    EXPECT_TRUE(ids.insert(data.id()).second);
    Scene scene{.layers = {{.data = data, .show = MaximumProjection{}}}};
    if (turn % 4 >= 2) scene.layers[0].show = Isosurface{0.3};
    scene.camera = fit_camera(data.bounds(), size);
    context.render(scene, {.size = size}, picture);
    if (turn % 4 >= 2) continue;
    if (bits[turn % 2].empty()) bits[turn % 2] = bits_of(picture);
    ASSERT_TRUE(bits_of(picture) == bits[turn % 2]) << turn;
    if (turn == 4) files = open_files();
    EXPECT_LE(open_files(), turn < 4 ? 1000 : files);
  }
  EXPECT_TRUE(bits[0] != bits[1]);
}

TEST(Datasets, have_ids_that_differ_and_handles_that_share_one) {
  const Dataset mesh = ball_mesh(2), copy = mesh, other = ball_mesh(2);
  EXPECT_EQ(mesh.id(), copy.id());
  EXPECT_EQ((std::set{mesh.id(), other.id(), mesh.boundary().id(), octahedron().id()}.size()), 4U);
}

TEST(Datasets, show_any_of_their_fields) {
  const Dataset mesh = ball_mesh();
  const auto bits = [&](const std::string& field, double isovalue) {
    Scene scene{.layers = {{.data = mesh, .show = Isosurface{isovalue}, .field = field}}};
    scene.camera = fit_camera(mesh.bounds(), size);
    return bits_of(rendered(scene, {.size = size}));
  };
  EXPECT_TRUE(bits("", 0.5) == bits("radius", 0.5));
  EXPECT_TRUE(bits("x", 0.5) != bits("radius", 0.5));
  expect_refused(ErrorCode::usage, "no field 'radios'; it has radius, x, part", [&] { mesh.field("radios"); });
  try {
    mesh.field("radios");
  } catch (const Error& error) {
    EXPECT_THAT(error.hint(), testing::HasSubstr("radius"));
  }
  expect_refused(ErrorCode::usage, "a surface has no fields", [] { octahedron().field(); });
}

TEST(Datasets, give_the_boundary_of_a_mesh_and_of_its_parts) {
  const Dataset mesh = ball_mesh();
  EXPECT_EQ(mesh.boundary().kind(), DataKind::triangles);
  EXPECT_EQ(mesh.boundary().bounds(), mesh.bounds());
  // Rays along x through each part: they enter and leave it where it ends.
  MadeRays rays;
  rays.add({-5, 0.3, 0.2}, {1, 0, 0});
  rays.add({5, 0.3, 0.2}, {-1, 0, 0});
  const double entered[2][2] = {{4, 5}, {5, 4}};
  for (const int label : {1, 2}) {
    double t[2];
    RayScratch scratch;
    RayCaster(mesh.boundary("part", label), Triangles{}, Accuracy::float64).first_hits(rays.rays(), {.t = t}, scratch);
    EXPECT_NEAR(t[0], entered[label - 1][0], 1e-6);
    EXPECT_NEAR(t[1], entered[label - 1][1], 1e-6);
  }
  expect_refused(ErrorCode::invalid, "3", [&] { mesh.boundary("part", 3); });
  expect_refused(ErrorCode::usage, "parts", [&] { mesh.boundary("parts", 1); });
  expect_refused(ErrorCode::usage, "radius", [&] { mesh.boundary("radius", 1); });
  expect_refused(ErrorCode::usage, "", [] { gyroid_grid().boundary(); });
  expect_refused(ErrorCode::usage, "", [] { octahedron().boundary(); });
  expect_refused(ErrorCode::usage, "", [&] { mesh.boundary().boundary(); });
}

TEST(Files, that_are_damaged_say_where) {
  const TemporaryFolder folder;
  ball_mesh(8, {.file = folder / "mesh.rho"});
  EXPECT_TRUE(Dataset::open(folder / "mesh.rho").damaged_blocks().empty());
  EXPECT_TRUE(ball_mesh().damaged_blocks(1).empty());
  std::string bytes = read_file(folder / "mesh.rho");
  // A value near the end: memory safety does not depend on it.
  const std::size_t at = bytes.size() - 9;
  bytes[at] = static_cast<char>(bytes[at] ^ 1);
  write_file(folder / "damaged.rho", bytes);
  std::optional<Dataset> damaged;
  try {
    damaged = Dataset::open(folder / "damaged.rho");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::invalid);
  }
  if (damaged) {
    const std::vector<DamagedBlock> blocks = damaged->damaged_blocks(2);
    ASSERT_EQ(blocks.size(), 1U);
    EXPECT_LE(blocks[0].first_byte, at);
    EXPECT_GT(blocks[0].first_byte + blocks[0].byte_count, at);
  }
  write_file(folder / "short.rho", bytes.substr(0, bytes.size() / 2));
  expect_refused(ErrorCode::invalid, "short.rho", [&] { Dataset::open(folder / "short.rho"); });
  write_file(folder / "header.rho", bytes.substr(0, 40));
  expect_refused(ErrorCode::invalid, "header.rho", [&] { Dataset::open(folder / "header.rho"); });
  write_file(folder / "empty.rho", "");
  expect_refused(ErrorCode::invalid, "empty.rho", [&] { Dataset::open(folder / "empty.rho"); });
  bytes[at] = static_cast<char>(bytes[at] ^ 1);
  for (const std::size_t spoilt : {std::size_t{2}, std::size_t{60}, std::size_t{200}}) {
    std::string header = bytes;
    header[spoilt] = static_cast<char>(header[spoilt] ^ 4);
    write_file(folder / "header.rho", header);
    expect_refused(ErrorCode::invalid, "header.rho", [&] { Dataset::open(folder / "header.rho"); });
  }
}

TEST(Files, that_are_missing_or_not_packed_are_refused) {
  const TemporaryFolder folder;
  expect_refused(ErrorCode::unreadable, "none.rho", [&] { Dataset::open(folder / "none.rho"); });
  expect_refused(ErrorCode::unreadable, folder.path().string(), [&] { Dataset::open(folder.path()); });
  expect_refused(ErrorCode::unreadable, "", [] { Dataset::open(""); });
  write_file(folder / "head.nrrd", "NRRD0004\n");
  try {
    Dataset::open(folder / "head.nrrd");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unsupported);
    EXPECT_THAT(error.what(), testing::EndsWith("head.nrrd: is not a packed file"));
    EXPECT_THAT(error.hint(), testing::StartsWith("pack it first: rhoray pack "));
  }
  write_file(folder / "text.rho", "no packed file");
  expect_refused(ErrorCode::invalid, "text.rho", [&] { Dataset::open(folder / "text.rho"); });
}

TEST(Files, of_a_newer_version_are_refused) {
  const TemporaryFolder folder;
  octahedron({.file = folder / "o.rho"});
  const std::string version = "\"version\":\"1.";
  write_file(folder / "newer.rho", with_header_change(read_file(folder / "o.rho"), version, "\"version\":\"9."));
  expect_refused(ErrorCode::unsupported, "newer.rho", [&] { Dataset::open(folder / "newer.rho"); });
}

}  // namespace
}  // namespace rhoray::tests
