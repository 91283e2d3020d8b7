#include "preprocess/resample.h"
#include "formats/base/parallel.h"
#include "preprocess/unpack_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "preprocess/pack_mesh.h"
#include "tests/support/expect_error.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using formats::BrickGrid;
using formats::PackedFile;

const tests::Field wave = [](const Vec3& p) { return std::sin(4 * p.x) + p.y * p.z; };

/// A ball in a box: most bricks of its lattice's corners stay empty.
NeutralMesh ball_mesh() {
  NeutralMesh mesh = tests::box_mesh({.cells = {12, 12, 12}, .box = Box3({-1, -1, -1}, {1, 1, 1})}, wave, true);
  Array<std::array<std::uint64_t, 4>> kept;
  for (const auto& cell : mesh.cells)
    if (std::all_of(cell.begin(), cell.end(),
                    [&](std::uint64_t v) { return tests::to_vec3(mesh.points[v]).length() < 1.1; }))
      kept.push_back(cell);
  mesh.cells = kept;
  return mesh;
}

class Resample : public testing::Test {
 protected:
  ResampleReport run(const NeutralMesh& mesh, const ResampleOptions& options, const char* name = "grid.rho") {
    return resample(mesh, folder_ / name, options);
  }
  BrickGrid grid(const char* name = "grid.rho") { return BrickGrid(PackedFile::open(folder_ / name)); }

  tests::TemporaryFolder folder_;
};

TEST_F(Resample, writes_a_sound_sparse_grid_with_certificates) {
  NeutralMesh mesh = ball_mesh();
  tests::add_point_field(mesh, "height", [](const Vec3& p) { return p.z; });
  const ResampleReport report = run(mesh, {.lattice = {.longest_axis = 60}, .source_name = "ball.vtu"});
  const BrickGrid written = grid();
  EXPECT_EQ(formats::deep_findings(written), std::vector<std::string>{});
  EXPECT_TRUE(written.file().damaged_blocks().empty());
  const formats::GridDescription& description = written.description();
  ASSERT_EQ(description.fields.size(), 2U);
  EXPECT_EQ(description.fields[0].name, "value");
  EXPECT_EQ(description.fields[0].type, formats::ElementType::F32);
  EXPECT_EQ(description.fields[1].name, "height");
  EXPECT_EQ(description.fields[1].type, formats::ElementType::F64);
  // A plane across an axis: its gradient of 1 counts 1.5 times (IsosurfaceProfile).
  ASSERT_EQ(description.fields[1].mean_gradient.size(), description.fields[1].histogram.size());
  EXPECT_NEAR(description.fields[1].mean_gradient[128], 1.5, 0.01);
  EXPECT_TRUE(description.layout.is_sparse);
  EXPECT_LT(description.layout.stored_brick_count, 8U * 8 * 8 - 8) << "bricks in the corners hold nothing";
  EXPECT_EQ(description.fields[0].no_data_count, report.outside_count - report.extended_count);
  EXPECT_GT(report.extended_count, 1000U);
  EXPECT_EQ(report.inside_count + report.outside_count, 60U * 60 * 60);
  ASSERT_EQ(description.certificates.size(), 2U);
  EXPECT_EQ(description.certificates.at(0).max_error, report.errors[0].max_error);
  EXPECT_GE(report.errors[0].max_error, report.errors[0].attained);
  EXPECT_GT(report.errors[0].rms_error, 0);
  const auto max = written.errors<float>(0, "max");
  EXPECT_EQ(static_cast<double>(*std::max_element(max.begin(), max.end())), report.errors[0].max_error);
}

TEST_F(Resample, puts_samples_where_the_grid_says) {
  NeutralMesh mesh = tests::box_mesh({.cells = {3, 4, 5}, .box = Box3({1e6, 2, -3}, {1e6 + 1, 4, 0})},
                                     tests::linear_field({1, 10, 100}));
  run(mesh, {.lattice = {.spacing = {0.25, 0.25, 0.5}}});
  const BrickGrid written = grid();
  const formats::GridDescription& description = written.description();
  EXPECT_EQ(description.layout.sample_count, Index3(5, 9, 7));
  const auto samples = written.samples<double>();
  const formats::SparseAddress address(description.layout, written.tables(), written.brick_slots());
  for (std::int64_t k = 0; k < 7; ++k)
    for (std::int64_t j = 0; j < 9; ++j)
      for (std::int64_t i = 0; i < 5; ++i) {
        const Vec3 p = description.world_from_grid.point(Vec3(Index3(i, j, k)));
        EXPECT_NEAR(samples[address(i, j, k)], p.x + 10 * p.y + 100 * p.z, 1e-8);
      }
}

TEST_F(Resample, writes_the_same_bytes_with_one_thread_and_two) {
  NeutralMesh mesh = ball_mesh();
  for (const unsigned threads : {1, 2}) {
    const ThreadLimit limit(threads);
    run(mesh, {.lattice = {.longest_axis = 50}}, threads == 1 ? "one.rho" : "two.rho");
  }
  EXPECT_EQ(tests::read_file(folder_ / "one.rho"), tests::read_file(folder_ / "two.rho"));
}

TEST_F(Resample, makes_the_same_grid_of_a_packed_mesh_as_of_its_source) {
  NeutralMesh mesh =
      tests::box_mesh({.cells = {6, 6, 6}, .box = Box3({3e6, 1, 1}, {3e6 + 1, 2, 2}), .jitter = 0.1}, wave);
  run(mesh, {.lattice = {.longest_axis = 20}}, "source.rho");
  pack_mesh(mesh, folder_ / "mesh.rho");
  const formats::TetMesh packed(PackedFile::open(folder_ / "mesh.rho"));
  run(unpack_mesh(packed), {.lattice = {.longest_axis = 20}}, "packed.rho");
  EXPECT_EQ(tests::read_file(folder_ / "source.rho"), tests::read_file(folder_ / "packed.rho"));
}

TEST_F(Resample, refines_until_the_certificate_holds) {
  const NeutralMesh mesh = tests::box_mesh({.cells = {6, 6, 6}}, wave);
  const ResampleReport report = run(mesh, {.max_error = 0.01});
  EXPECT_LE(report.errors[0].max_error, 0.01);
  EXPECT_GT(report.errors[0].max_error, 0.002) << "far finer than asked for";
  ASSERT_GE(report.attempts.size(), 2U);
  for (std::size_t a = 1; a < report.attempts.size(); ++a) {
    EXPECT_GT(report.attempts[a - 1].max_error, 0.01);
    EXPECT_LE(report.attempts[a].sample_count.x, 2 * report.attempts[a - 1].sample_count.x);
  }
  EXPECT_EQ(report.attempts.back().sample_count, report.description.layout.sample_count);
}

TEST_F(Resample, takes_the_largest_error_as_a_share_of_the_range) {
  NeutralMesh mesh = tests::box_mesh({.cells = {6, 6, 6}}, wave);
  for (double& value : mesh.point_fields[0].values) value *= 1000;
  const ResampleReport report = run(mesh, {.max_error = 0.01, .max_error_is_share = true});
  const Interval<double> range = report.description.fields[0].range;
  EXPECT_LE(report.errors[0].max_error, 0.0101 * (range.hi - range.lo));
  EXPECT_GT(report.errors[0].max_error, 0.002 * (range.hi - range.lo));
}

TEST_F(Resample, refuses_a_first_lattice_that_does_not_fit_into_memory) {
  const NeutralMesh mesh = tests::box_mesh({.cells = {6, 6, 6}}, wave);
  for (const std::optional<double> max_error : {std::optional<double>(), std::optional<double>(1e-5)})
    tests::expect_error(ErrorCode::resource, "900 x 900 x 900 samples need", [&] {
      run(mesh,
          {.lattice = {.longest_axis = 900}, .max_error = max_error, .memory_limit_bytes = std::uint64_t{4} << 20});
    });
  EXPECT_FALSE(std::filesystem::exists(folder_ / "grid.rho"));
}

TEST_F(Resample, writes_the_last_grid_that_fits_when_memory_does_not_reach_for_the_error) {
  const NeutralMesh mesh = tests::box_mesh({.cells = {6, 6, 6}}, wave);
  const ResampleReport report = run(mesh, {.max_error = 1e-5, .memory_limit_bytes = std::uint64_t{4} << 20});
  EXPECT_THAT(report.why_not_reached, testing::HasSubstr("samples need"));
  const BrickGrid written = grid();
  EXPECT_EQ(formats::deep_findings(written), std::vector<std::string>{});
  const formats::Certificate& certificate = written.description().certificates.at(0);
  EXPECT_EQ(certificate.requested_error, 1e-5);
  EXPECT_FALSE(certificate.meets_request());
  EXPECT_GT(certificate.max_error, 1e-5);
  EXPECT_LT(certificate.max_error, 0.05) << "the finest that fits";
  EXPECT_EQ(written.description().layout.sample_count, report.attempts.back().sample_count);
  EXPECT_GE(report.attempts.size(), 2U);
}

/// Two boxes that meet in the plane z = 0.53, with the value 0 below and 1 above.
NeutralMesh two_boxes() {
  NeutralMesh mesh = tests::box_mesh({.cells = {3, 3, 3}, .box = Box3({0, 0, 0}, {1, 1, 0.53})});
  const NeutralMesh upper = tests::box_mesh({.cells = {3, 3, 3}, .box = Box3({0, 0, 0.53}, {1, 1, 1})});
  const std::size_t count = mesh.points.size();
  for (const auto& cell : upper.cells)
    mesh.cells.push_back({cell[0] + count, cell[1] + count, cell[2] + count, cell[3] + count});
  mesh.points.insert(mesh.points.end(), upper.points.begin(), upper.points.end());
  tests::add_point_field(mesh, "value", [](const Vec3&) { return 0.0; });
  for (std::size_t p = count; p < mesh.points.size(); ++p) mesh.point_fields[0].values[p] = 1;
  return mesh;
}

TEST_F(Resample, writes_the_coarsest_grid_that_finer_ones_do_not_better_where_the_field_jumps) {
  const ResampleReport report = run(two_boxes(), {.max_error = 0.1});
  EXPECT_THAT(report.why_not_reached, testing::HasSubstr("the field jumps"));
  const formats::Certificate certificate = grid().description().certificates.at(0);
  EXPECT_GE(certificate.max_error, 0.5);
  EXPECT_EQ(certificate.coverage, 1);
  EXPECT_FALSE(certificate.meets_request());
  EXPECT_LT(grid().description().layout.sample_count.x, report.attempts.back().sample_count.x);
  EXPECT_LT(report.attempts.back().sample_count.x, 200) << "and stops early";
}

TEST_F(Resample, writes_the_best_grid_not_the_last_when_memory_does_not_reach_for_the_error) {
  int last_was_not_best = 0;
  for (std::uint64_t kibibytes = 32; kibibytes <= 512; kibibytes += 32) {
    const ResampleReport report =
        run(two_boxes(), {.max_error = 0.1, .memory_limit_bytes = kibibytes << 10, .replace_existing = true});
    double smallest = 2;
    for (const ResampleReport::Attempt& attempt : report.attempts)
      if (attempt.coverage == 1) smallest = std::min(smallest, attempt.max_error);
    EXPECT_LE(0.95 * report.errors[0].max_error, smallest)
        << kibibytes << " KiB: by less than a twentieth is not better";
    if (report.attempts.back().max_error * 0.95 > report.errors[0].max_error) ++last_was_not_best;
  }
  EXPECT_GT(last_was_not_best, 0) << "the last grid that fits was the best one in every case: nothing was tested";
}

TEST_F(Resample, keeps_bounds_of_errors_of_values_of_any_size) {
  for (const double size : {1e-300, 1e-60, 1e-38, 1.0, 1e60, 1e300}) {
    NeutralMesh mesh = tests::box_mesh({.cells = {3, 3, 3}, .jitter = 0.1});
    tests::add_point_field(mesh, "value", [&](const Vec3& p) { return size * wave(p); });
    const ResampleReport report = run(mesh, {.lattice = {.longest_axis = 10}, .replace_existing = true});
    EXPECT_EQ(formats::deep_findings(grid()), std::vector<std::string>{}) << size;
    const formats::Certificate certificate = grid().description().certificates.at(0);
    EXPECT_GE(certificate.max_error, report.errors[0].attained) << size;
    EXPECT_LE(certificate.max_error, 1.051 * report.errors[0].attained + 1e-6 * 2 * size) << size;
    EXPECT_GT(certificate.rms_error, 0) << size;
  }
}

TEST_F(Resample, takes_a_share_of_a_field_that_does_not_vary_as_reached) {
  for (const double value : {0.0, 0.1, -1e30}) {
    NeutralMesh mesh = tests::box_mesh({.cells = {3, 3, 3}, .jitter = 0.1});
    tests::add_point_field(mesh, "value", [&](const Vec3&) { return value; });
    const ResampleReport report = run(mesh, {.max_error = 0.01, .max_error_is_share = true, .replace_existing = true});
    EXPECT_EQ(report.why_not_reached, "") << value;
    EXPECT_EQ(report.attempts.size(), 1U) << value;
  }
}

/// A plate of 1 x 1 x 0.02, tilted against all axes.
NeutralMesh thin_plate(const tests::Field& field) {
  NeutralMesh mesh = tests::box_mesh({.cells = {12, 12, 1}});
  const Vec3 u = Vec3(2, 1, 0.5).normalized(), w = u.cross(Vec3(-0.3, 1, 0.4)).normalized(), v = w.cross(u);
  for (auto& p : mesh.points) p = tests::to_array(p[0] * u + p[1] * v + 0.02 * p[2] * w);
  tests::add_point_field(mesh, "value", field);
  return mesh;
}

TEST_F(Resample, calls_an_error_reached_only_when_it_holds_in_all_of_the_mesh) {
  // It once called this a success with 98 % of the plate in cells without a value.
  const ResampleReport report = run(thin_plate([](const Vec3& p) { return std::sin(5 * p.x) + p.y; }),
                                    {.max_error = 0.01, .max_error_is_share = true});
  EXPECT_EQ(report.why_not_reached, "");
  EXPECT_GE(report.errors[0].coverage, 1 - 1e-9);
  EXPECT_GT(report.extended_count, 2 * report.inside_count) << "is the plate thin for these steps?";
  const BrickGrid written = grid();
  EXPECT_EQ(formats::deep_findings(written), std::vector<std::string>{});
  const formats::Certificate& certificate = written.description().certificates.at(0);
  EXPECT_EQ(certificate.coverage, report.errors[0].coverage);
  EXPECT_EQ(certificate.requested_error, report.requested_error);
  EXPECT_TRUE(certificate.meets_request());
}

TEST_F(Resample, stores_bricks_that_hold_only_values_beside_the_mesh) {
  // The mesh ends between the samples 7 and 8 of every axis but x: what leaf cell 7 needs of
  // samples 8 is in other bricks.
  NeutralMesh mesh = tests::box_mesh({.cells = {16, 4, 4}, .box = Box3({0, 0, 0}, {16, 7.5, 7.25})}, wave);
  const NeutralMesh beyond = tests::box_mesh({.cells = {1, 1, 1}, .box = Box3({0, 0, 20}, {1, 16, 21})}, wave);
  const std::size_t count = mesh.points.size();
  for (const auto& cell : beyond.cells)
    mesh.cells.push_back({cell[0] + count, cell[1] + count, cell[2] + count, cell[3] + count});
  mesh.points.insert(mesh.points.end(), beyond.points.begin(), beyond.points.end());
  const auto& values = beyond.point_fields[0].values;
  mesh.point_fields[0].values.insert(mesh.point_fields[0].values.end(), values.begin(), values.end());
  const ResampleReport report = run(mesh, {.lattice = {.spacing = {1, 1, 1}}});
  EXPECT_GE(report.errors[0].coverage, 1 - 1e-9);
  const BrickGrid written = grid();
  EXPECT_EQ(formats::deep_findings(written), std::vector<std::string>{});
  const auto slot = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    const Index3 bricks = written.description().layout.brick_count();
    return written.brick_slots()[static_cast<std::size_t>((z * bricks.y + y) * bricks.x + x)];
  };
  for (const std::int64_t x : {0, 1, 2}) {
    EXPECT_NE(slot(x, 1, 0), BrickGrid::no_brick) << x;
    EXPECT_NE(slot(x, 0, 1), BrickGrid::no_brick) << x;
    EXPECT_NE(slot(x, 1, 1), BrickGrid::no_brick) << x;
  }
  const formats::SparseAddress address(written.description().layout, written.tables(), written.brick_slots());
  const auto samples = written.samples<double>();
  EXPECT_FALSE(std::isnan(samples[address(3, 8, 2)]));
  EXPECT_TRUE(std::isnan(samples[address(3, 9, 2)]));
}

TEST_F(Resample, counts_samples_in_overlapping_cells) {
  NeutralMesh mesh = tests::box_mesh({.cells = {2, 2, 2}}, wave);
  const NeutralMesh shifted = tests::box_mesh({.cells = {2, 2, 2}, .box = Box3({0.75, 0, 0}, {1.75, 1, 1})}, wave);
  for (const auto& cell : shifted.cells) mesh.cells.push_back({cell[0] + 27, cell[1] + 27, cell[2] + 27, cell[3] + 27});
  mesh.points.insert(mesh.points.end(), shifted.points.begin(), shifted.points.end());
  for (const double value : shifted.point_fields[0].values) mesh.point_fields[0].values.push_back(value);
  const ResampleReport report = run(mesh, {.lattice = {.sample_count = {36, 21, 21}}});
  EXPECT_GT(report.overlap_count, 4U * 19 * 19 / 2) << "four planes of samples lie inside both";
  EXPECT_EQ(report.outside_count, 0U);
  EXPECT_NE(report.notes.back().find("overlap"), std::string::npos);
}

TEST_F(Resample, refuses_a_request_without_a_lattice) {
  tests::expect_error(ErrorCode::usage, "expected one", [&] { run(ball_mesh(), {}); });
}

}  // namespace
}  // namespace rhoray::preprocess
