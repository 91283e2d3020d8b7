#include "formats/range_proof.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "formats/details/range_checks.h"
#include "tests/support/expect_error.h"
#include "tests/support/made_grid.h"
#include "tests/support/narrowed.h"
#include "tests/support/packed_samples.h"
#include "tests/support/temporary_folder.h"

// Compares the data that let a ray skip cells with the samples, points and cells themselves: each
// kind of file, and each level.

namespace rhoray::formats {
namespace {

using testing::HasSubstr;
using tests::expect_error;
using tests::IntervalStep;
using tests::MadeGrid;
using tests::narrowed;
using tests::TemporaryFolder;
using tests::TetSample;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

float wavy(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<float>((i * 7 + j * 13 + k * 29) % 31);
}
float with_gaps(std::int64_t i, std::int64_t j, std::int64_t k) {
  return (i + 2 * j + 3 * k) % 11 == 0 ? nan : wavy(i, j, k);
}
float half(std::int64_t i, std::int64_t j, std::int64_t k) {
  return i < 10 ? nan : wavy(i, j, k);
}

constexpr Index3 count{23, 18, 9};
const tests::MacroChoice macro{.factor = 4, .level_count = 3};

MadeGrid grid(float (*value)(std::int64_t, std::int64_t, std::int64_t), bool is_sparse = false,
              bool is_rectilinear = false) {
  tests::MadeGridChoice choice{.sample_count = count, .is_sparse = is_sparse, .macro = macro};
  if (is_rectilinear)
    for (int axis = 0; axis < 3; ++axis)
      for (std::int64_t i = 0; i < count[axis]; ++i)
        choice.axes[static_cast<std::size_t>(axis)].push_back(static_cast<double>(i * i));
  return made_grid(choice, {{"density", value}});
}

TetSample mesh() {
  return tests::sample_tets(4,
                            {{"height", [](const Vec3& p) { return p.z; }},
                             {"far", [](const Vec3& p) { return p.x > 0.9 ? std::nan("") : p.x * p.y - 100; }}},
                            {5, 4, 3}, {1, 1, 1}, {.factor = 2, .level_count = 2});
}

std::string bytes_of(const TetSample& sample) {
  const tests::MemoryFile memory;
  PackedFileWriter writer(memory.descriptor(), describe(sample.description), tet_mesh_arrays(sample.description));
  sample.write_into(writer).commit();
  return memory.content();
}

/// Opens the file again from memory.
template <class Data>
Data opened(const std::string& file) {
  const tests::MemoryFile memory(file);
  return Data(PackedFile::from_descriptor(memory.descriptor(), "x.rho"));
}

struct Case {
  std::string name;
  std::string file;
  std::vector<std::pair<std::string, IntervalStep>> arrays;
  std::function<std::uint64_t(const std::string&, unsigned, const std::stop_token&)> prove_or_stop;
  /// Runs the checks of a proof one by one; each must end by a stop request. Returns their
  /// findings.
  std::function<std::vector<std::string>(const std::string&, const details::CheckOptions&)> checks_stopped;
  std::function<std::vector<std::string>(const std::string&)> deep;

  std::uint64_t prove(const std::string& bytes, unsigned threads) const { return prove_or_stop(bytes, threads, {}); }
};

void expect_stopped(const std::function<void()>& act) {
  expect_error(ErrorCode::interrupted, "interrupted", act);
}

std::vector<std::string> checks_stopped(const BrickGrid& grid, std::size_t field,
                                        const details::CheckOptions& options) {
  details::Findings findings;
  expect_stopped([&] { details::check_ranges(grid, field, options, findings); });
  with_element_type(grid.description().fields[field].type, [&]<class T>(T) {
    expect_stopped([&] { details::check_levels_upward(grid.macro_levels<T>(field), "levels", options, findings); });
  });
  return findings.sentences();
}

std::vector<std::string> checks_stopped(const TetMesh& mesh, std::size_t field, const details::CheckOptions& options) {
  details::Findings findings;
  expect_stopped([&] { details::check_boxes_and_lists(mesh, options, findings); });
  expect_stopped([&] { details::check_ranges(mesh, field, options, findings); });
  return findings.sentences();
}

template <class Data>
Case case_of(const std::string& name, const std::string& file,
             const std::vector<std::pair<std::string, IntervalStep>>& arrays, std::size_t field = 0) {
  return {name,
          file,
          arrays,
          [field](const std::string& bytes, unsigned threads, const std::stop_token& stop) {
            return prove_ranges(opened<Data>(bytes), field, threads, stop);
          },
          [field](const std::string& bytes, const details::CheckOptions& options) {
            return checks_stopped(opened<Data>(bytes), field, options);
          },
          [](const std::string& bytes) { return deep_findings(opened<Data>(bytes)); }};
}

std::vector<Case> all_cases() {
  using enum IntervalStep;
  const std::vector<std::pair<std::string, IntervalStep>> levels{
      {"macro.1", macro_levels}, {"macro.2", macro_levels}, {"macro.3", macro_levels}};
  const std::vector<std::pair<std::string, IntervalStep>> leaf_levels{
      {"range.0.0", macro_levels}, {"range.0.1", macro_levels}, {"range.0.2", macro_levels}};
  const std::vector<std::pair<std::string, IntervalStep>> cluster_levels{
      {"range.0.0", cluster_ranges},      {"range.0.1", cluster_ranges},      {"range.0.2", cluster_ranges},
      {"cluster.boxes.0", cluster_boxes}, {"cluster.boxes.1", cluster_boxes}, {"cluster.boxes.2", cluster_boxes}};
  const TemporaryFolder folder;
  packed(tests::sample_grid<std::uint8_t>(
             BrickLayout::bricked(count),
             [](std::int64_t i, std::int64_t j, std::int64_t k) { return static_cast<std::uint8_t>(wavy(i, j, k)); },
             macro),
         folder / "bytes.rho");
  packed(tests::sample_grid<double>(
             BrickLayout::linear(count),
             [](std::int64_t i, std::int64_t j, std::int64_t k) { return static_cast<double>(with_gaps(i, j, k)); },
             macro),
         folder / "doubles.rho");
  return {case_of<BrickGrid>("bytes", tests::read_file(folder / "bytes.rho"), levels),
          case_of<BrickGrid>("doubles with gaps", tests::read_file(folder / "doubles.rho"), levels),
          case_of<BrickGrid>("dense", grid(wavy).file(), levels),
          case_of<BrickGrid>("dense with gaps", grid(with_gaps).file(), levels),
          case_of<BrickGrid>("rectilinear", grid(wavy, false, true).file(), levels),
          case_of<BrickGrid>("sparse", grid(half, true).file(), levels),
          case_of<TetMesh>("leaf lists", bytes_of(mesh()), leaf_levels),
          case_of<TetMesh>("clusters", bytes_of(clustered(mesh(), 4)), cluster_levels),
          case_of<TetMesh>("clusters with gaps", bytes_of(clustered(mesh(), 4)),
                           {{"range.1.0", cluster_ranges}, {"range.1.1", cluster_ranges}}, 1),
          case_of<TetMesh>("leaf lists with gaps", bytes_of(mesh()), {{"range.1.0", macro_levels}}, 1)};
}

TEST(RangeProof, holds_for_files_that_are_sound_on_any_number_of_threads) {
  for (const Case& sound : all_cases())
    for (const unsigned threads : {1U, 2U, 3U}) {
      SCOPED_TRACE(sound.name);
      const std::uint64_t bytes = sound.prove(sound.file, threads);
      EXPECT_GT(bytes, sound.file.size() / 20);
      EXPECT_LT(bytes, sound.file.size());
      EXPECT_THAT(sound.deep(sound.file), testing::IsEmpty());
    }
}

TEST(RangeProof, refuses_each_level_that_is_narrower_than_what_lies_below) {
  for (const Case& one : all_cases())
    for (const auto& [array, step] : one.arrays)
      for (const bool all : {false, true}) {
        SCOPED_TRACE(one.name + ", " + array);
        const std::string file = narrowed(one.file, array, step, all);
        EXPECT_THAT(one.deep(file), testing::Not(testing::IsEmpty()));
        for (const unsigned threads : {1U, 3U})
          expect_error(ErrorCode::invalid, "x.rho: ", [&] { one.prove(file, threads); });
      }
}

TEST(RangeProof, refuses_levels_that_all_tell_the_same_lie) {
  for (const Case& one : all_cases()) {
    SCOPED_TRACE(one.name);
    std::string file = one.file;
    for (const auto& [array, step] : one.arrays) file = narrowed(file, array, step, true);
    expect_error(ErrorCode::invalid, "x.rho: ", [&] { one.prove(file, 0); });
  }
}

TEST(RangeProof, says_where_what_was_found_and_what_was_needed) {
  const auto refuses = [](const Case& one, const std::string& array, IntervalStep step, const std::string& words) {
    expect_error(ErrorCode::invalid, words, [&] { one.prove(narrowed(one.file, array, step), 0); });
  };
  using enum IntervalStep;
  const std::vector<Case> cases = all_cases();
  refuses(cases[2], "macro.1", macro_levels,
          "x.rho: an interval that lacks a value of its macrocell: (0, 0, 0) of level 1 has [0, 0], its samples need "
          "[0, 30]");
  refuses(cases[2], "macro.2", macro_levels,
          "x.rho: macro levels: a macrocell does not match the level below: (0, 0, 0) of level 2 has [0, 0], below it "
          "[0, 30]");
  refuses(cases[6], "range.0.0", macro_levels,
          "x.rho: macro levels of field 'height': an interval lacks a value of its leaf cell: leaf 0 has [0, 0], the "
          "cells of its list need [0, 0.5]");
  refuses(cases[7], "range.0.0", cluster_ranges,
          "x.rho: ranges of field 'height': a cluster's lacks a value of its cells: cluster 0 has [0, 0], its cells "
          "need [0, 0.25]");
  refuses(
      cases[7], "cluster.boxes.0", cluster_boxes,
      "x.rho: a cluster that reaches out of its box: cluster 0 has [0, 0] x [0, 0.25] x [0, 0.25], its point 1 lies "
      "at (0.25, 0, 0)");
  refuses(cases[7], "cluster.boxes.1", cluster_boxes,
          "x.rho: a box that does not hold those below it: entry 0 of level 1 has [0, 0] x ");
}

TEST(RangeProof, refuses_a_cluster_that_reaches_out_of_its_box_on_any_axis) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const bool from_above : {false, true}) {
      SCOPED_TRACE(concat("axis ", axis, from_above ? ", high side" : ", low side"));
      TetSample sample = clustered(mesh(), 4);
      // The array begins with eight clusters: their low sides on x, y and z, then their high sides.
      std::vector<float>& boxes = sample.clusters.boxes[0];
      const std::size_t low = 8 * axis, high = 8 * (axis + 3);
      ASSERT_LT(boxes[low], boxes[high]);
      boxes[from_above ? high : low] = (boxes[low] + boxes[high]) / 2;
      expect_error(ErrorCode::invalid, "a cluster that reaches out of its box: cluster 0",
                   [&] { prove_ranges(opened<TetMesh>(bytes_of(sample)), 0); });
    }
}

TEST(RangeProof, takes_no_range_of_nan_for_one_that_contains) {
  MadeGrid spoilt = grid(wavy);
  std::memcpy(spoilt.arrays["macro.1"].data(), &nan, sizeof nan);
  expect_error(ErrorCode::invalid, "(0, 0, 0) of level 1 has [nan, 30]",
               [&] { prove_ranges(opened<BrickGrid>(spoilt.file()), 0); });
  TetSample sample = clustered(mesh(), 4);
  sample.clusters.boxes[0][0] = nan;
  expect_error(ErrorCode::invalid, "x.rho: a box", [&] { prove_ranges(opened<TetMesh>(bytes_of(sample)), 0); });
  EXPECT_THAT(deep_findings(opened<TetMesh>(bytes_of(sample))),
              testing::Contains(HasSubstr("a cluster that reaches out of its box: cluster 0 has [nan, 0.25] x ")));
}

TEST(RangeProof, refuses_a_field_that_has_values_beyond_its_range_or_gaps_that_it_denies) {
  const auto refused = [](MadeGrid spoilt, const std::string& words, const std::function<void(FieldSummary&)>& spoil) {
    spoil(spoilt.description.fields[0]);
    expect_error(ErrorCode::invalid, words, [&] { prove_ranges(opened<BrickGrid>(spoilt.file()), 0); });
  };
  refused(grid(wavy), "the range of field 'density' lacks a value: it is [0, 29], its values need [0, 30]",
          [](FieldSummary& field) { field.range.hi = 29; });
  for (const bool is_sparse : {false, true})
    refused(grid(is_sparse ? half : with_gaps, is_sparse), "field 'density' has no data somewhere",
            [](FieldSummary& field) { field.no_data_count = 0; });
  TetSample sample = mesh();
  sample.description.fields[1].no_data_count = 0;
  expect_error(ErrorCode::invalid, "field 'far' has no data somewhere",
               [&] { prove_ranges(opened<TetMesh>(bytes_of(sample)), 1); });
  sample.description.fields[0].range.hi = 0.5;
  expect_error(ErrorCode::invalid, "the range of field 'height' lacks a value: it is [0, 0.5], its values need [0, 1]",
               [&] { prove_ranges(opened<TetMesh>(bytes_of(sample)), 0); });
}

TEST(RangeProof, refuses_an_infinite_sample_that_is_denied) {
  // Infinity is not below infinity: a range of all numbers contains it, and yet its cells have no
  // data.
  MadeGrid spoilt = grid([](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i == 5 && j == 5 && k == 5 ? std::numeric_limits<float>::infinity() : wavy(i, j, k);
  });
  EXPECT_EQ(spoilt.description.fields[0].no_data_count, 1U);
  EXPECT_NO_THROW(prove_ranges(opened<BrickGrid>(spoilt.file()), 0));
  spoilt.description.fields[0].no_data_count = 0;
  expect_error(ErrorCode::invalid, "no data somewhere", [&] { prove_ranges(opened<BrickGrid>(spoilt.file()), 0); });
}

TEST(RangeProof, is_of_one_field_and_does_not_ask_about_others) {
  const MadeGrid two =
      tests::made_grid({.sample_count = count, .macro = macro}, {{"density", wavy}, {"pressure", with_gaps}});
  const std::string file = narrowed(two.file(), "field.1.macro.1", IntervalStep::macro_levels);
  EXPECT_NO_THROW(prove_ranges(opened<BrickGrid>(file), 0));
  expect_error(ErrorCode::invalid, "an interval of field 'pressure' that lacks a value",
               [&] { prove_ranges(opened<BrickGrid>(file), 1); });
}

// ---- stop requests ------------------------------------------------------------------------------

TEST(RangeProof, that_was_stopped_before_looks_at_nothing_and_finds_nothing) {
  std::stop_source stop;
  stop.request_stop();
  for (const Case& one : all_cases()) {
    SCOPED_TRACE(one.name);
    std::string file = one.file;
    for (const auto& [array, step] : one.arrays) file = narrowed(file, array, step, true);
    for (const unsigned threads : {1U, 3U}) {
      EXPECT_THAT(one.checks_stopped(file, {.threads = threads, .watch = stop.get_token()}), testing::IsEmpty());
      for (const std::string& each : {one.file, file})
        expect_stopped([&] { one.prove_or_stop(each, threads, stop.get_token()); });
    }
  }
}

TEST(RangeProof, that_could_be_stopped_and_was_not_is_whole) {
  const std::stop_source stop;
  for (const Case& one : all_cases())
    for (const unsigned threads : {1U, 3U}) {
      SCOPED_TRACE(one.name);
      EXPECT_EQ(one.prove_or_stop(one.file, threads, stop.get_token()), one.prove(one.file, threads));
      // The last level is compared last.
      const std::string file = narrowed(one.file, one.arrays.back().first, one.arrays.back().second);
      expect_error(ErrorCode::invalid, "x.rho: ", [&] { one.prove_or_stop(file, threads, stop.get_token()); });
    }
}

// ---- leaf lists ---------------------------------------------------------------------------------

/// The leaf cell that contains a point, in the sample's lattice.
std::size_t leaf_around(const TetSample& sample, const Vec3& p) {
  const LeafLattice& lattice = sample.description.lattice;
  const Vec3 at = (p - lattice.low) / lattice.leaf_size;
  const Index3 n = lattice.macro.leaf_count;
  return static_cast<std::size_t>((static_cast<std::int64_t>(at.z) * n.y + static_cast<std::int64_t>(at.y)) * n.x +
                                  static_cast<std::int64_t>(at.x));
}

TetSample without_item(TetSample sample, std::size_t item) {
  sample.items.erase(sample.items.begin() + static_cast<std::ptrdiff_t>(item));
  for (std::uint64_t& offset : sample.offsets) offset -= offset > item ? 1 : 0;
  --sample.description.leaf_item_count;
  return sample;
}

// A cell that is missing in one list is not found there. Deep checks once tested only the leaf cell
// of each centroid.
TEST(RangeProof, refuses_lists_that_miss_a_cell_which_has_a_point_inside_the_leaf_cell) {
  const TetSample sample = tests::sample_tets(2, {{"flat", [](const Vec3&) { return 1.0; }}}, {3, 4, 5}, {1, 1.5, 2});
  std::size_t taken_out = 0, not_sampled = 0;
  for (std::size_t leaf = 0; leaf + 1 < sample.offsets.size(); ++leaf)
    for (std::size_t item = sample.offsets[leaf]; item < sample.offsets[leaf + 1]; ++item) {
      const std::uint32_t* const cell = sample.cells.data() + 4 * std::size_t{sample.items[item]};
      bool is_inside = false;
      constexpr int n = 12;  // inner points of the cell, with integer barycentric weights
      for (int a = 1; a < n && !is_inside; ++a)
        for (int b = 1; a + b < n && !is_inside; ++b)
          for (int c = 1; a + b + c < n && !is_inside; ++c) {
            Vec3 p(0, 0, 0);
            const std::array<int, 4> weight{a, b, c, n - a - b - c};
            for (std::size_t v = 0; v < 4; ++v) {
              const double* const q = sample.points.data() + 3 * std::size_t{cell[v]};
              p += Vec3(q[0], q[1], q[2]) * (weight[v] / double{n});
            }
            is_inside = leaf_around(sample, p) == leaf;
          }
      if (!is_inside) {
        ++not_sampled;
        continue;
      }
      ++taken_out;
      const std::string file = bytes_of(without_item(sample, item));
      expect_error(ErrorCode::invalid,
                   concat("a cell missing from the list of a leaf cell that it touches: cell ", sample.items[item],
                          " touches leaf ", leaf),
                   [&] { prove_ranges(opened<TetMesh>(file), 0); });
    }
  EXPECT_GT(taken_out, 300U);
  EXPECT_LT(not_sampled, 2 * sample.items.size() / 3) << "listed by their boxes, and not touching";
}

TEST(RangeProof, refuses_empty_lists_of_leaf_cells_that_cells_touch) {
  const TetSample whole = tests::sample_tets(1, {{"flat", [](const Vec3&) { return 1.0; }}}, {2, 2, 1});
  for (std::size_t leaf = 0; leaf + 1 < whole.offsets.size(); ++leaf) {
    TetSample sample = whole;
    for (std::size_t item = whole.offsets[leaf + 1]; item-- > whole.offsets[leaf];) sample = without_item(sample, item);
    expect_error(ErrorCode::invalid, concat("touches leaf ", leaf, ", which lists 0"),
                 [&] { prove_ranges(opened<TetMesh>(bytes_of(sample)), 0); });
  }
}

TEST(RangeProof, lets_lists_leave_out_cells_that_stay_clear) {
  // Lists made from bounding boxes name more cells than touch. Lists without cells that are at
  // least a hundredth of a leaf cell away must still pass: the criterion is touching, not the box.
  const TetSample sample = tests::sample_tets(1, {{"flat", [](const Vec3&) { return 1.0; }}}, {4, 4, 4});
  std::size_t left_out = 0;
  for (std::size_t leaf = 0; leaf + 1 < sample.offsets.size(); ++leaf) {
    const Index3 at(static_cast<std::int64_t>(leaf % 4), static_cast<std::int64_t>(leaf / 4 % 4),
                    static_cast<std::int64_t>(leaf / 16));
    for (std::size_t item = sample.offsets[leaf]; item < sample.offsets[leaf + 1]; ++item) {
      // Cell n of a brick is where the coordinates decrease in the order of its axes
      // (tests/support/packed_samples.h).
      constexpr std::array<std::array<int, 3>, 6> paths{
          {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
      const auto& order = paths[sample.items[item]];
      const auto low = [&](int axis) { return static_cast<double>(at[order[static_cast<std::size_t>(axis)]]) / 4; };
      const auto is_clear = [&](int above, int below) { return low(above) + 0.25 < low(below) - 0.0025; };
      if (!is_clear(0, 1) && !is_clear(1, 2)) continue;
      ++left_out;
      EXPECT_NO_THROW(prove_ranges(opened<TetMesh>(bytes_of(without_item(sample, item))), 0));
    }
  }
  EXPECT_GT(left_out, 50U);
}

TEST(RangeProof, refuses_a_mesh_that_reaches_out_of_its_lattice) {
  TetSample sample = mesh();
  sample.description.lattice.leaf_size = sample.description.lattice.leaf_size * 0.75;
  expect_error(ErrorCode::invalid, "a point outside the lattice of leaf cells: point 4 lies at (",
               [&] { prove_ranges(opened<TetMesh>(bytes_of(sample)), 0); });
}

}  // namespace
}  // namespace rhoray::formats
