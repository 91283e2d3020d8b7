#include "formats/mesh_boundary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stop_token>

#include "formats/tet_mesh.h"
#include "tests/support/expect_error.h"
#include "tests/support/packed_samples.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::formats {
namespace {

using tests::TemporaryFolder;
using tests::TetSample;

using Cells = std::vector<std::array<std::uint32_t, 4>>;

TetSample box(std::int64_t edge) {
  return tests::sample_tets(edge, {{"f", [](const Vec3& p) { return p.x; }}}, {2, 2, 2});
}

Cells cells_of(const TetSample& sample) {
  Cells cells(sample.cells.size() / 4);
  for (std::size_t c = 0; c < cells.size(); ++c)
    std::copy_n(sample.cells.begin() + static_cast<std::ptrdiff_t>(4 * c), 4, cells[c].begin());
  return cells;
}

/// By a table of all faces.
FaceNumbers faces_of_one_cell(const Cells& cells) {
  std::map<std::set<std::uint32_t>, std::vector<std::uint64_t>> faces;
  for (std::uint64_t c = 0; c < cells.size(); ++c)
    for (unsigned k = 0; k < 4; ++k) {
      std::set<std::uint32_t> points(cells[c].begin(), cells[c].end());
      points.erase(cells[c][k]);
      faces[points].push_back(4 * c + k);
    }
  FaceNumbers single;
  for (const auto& [points, numbers] : faces)
    if (numbers.size() == 1) single.push_back(numbers[0]);
  std::sort(single.begin(), single.end());
  return single;
}

TEST(MeshBoundary, of_one_cell_are_its_four_faces_seen_from_outside) {
  const Cells one{{0, 1, 2, 3}};
  EXPECT_THAT(boundary_faces(one, 4), testing::ElementsAre(0, 1, 2, 3));
  const std::array<Vec3, 4> points{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  for (unsigned k = 0; k < 4; ++k) {
    const auto [a, b, c] = face_points(one[0], k);
    const Vec3 normal = (points[b] - points[a]).cross(points[c] - points[a]);
    EXPECT_LT(normal.dot(points[k] - points[a]), 0) << k;
  }
}

TEST(MeshBoundary, leaves_shared_faces_out) {
  EXPECT_THAT(boundary_faces(Cells{{0, 1, 2, 3}, {1, 2, 3, 4}}, 5), testing::ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(boundary_faces(Cells{{0, 1, 2, 3}, {0, 1, 2, 3}}, 4), testing::IsEmpty()) << "the same cell twice";
}

TEST(MeshBoundary, of_a_box_covers_its_six_sides) {
  for (const std::int64_t edge : {1, 2, 5}) {
    const Cells cells = cells_of(box(edge));
    const FaceNumbers faces = boundary_faces(cells, 1000);
    EXPECT_EQ(faces.size(), static_cast<std::size_t>(12 * edge * edge));
    EXPECT_EQ(faces, faces_of_one_cell(cells));
  }
}

TEST(MeshBoundary, is_the_same_in_any_order_and_with_little_memory) {
  Cells cells = cells_of(box(4));
  std::mt19937_64 random(7);
  std::vector<std::uint32_t> names(125);
  std::iota(names.begin(), names.end(), 0U);
  for (int round = 0; round < 20; ++round) {
    std::shuffle(names.begin(), names.end(), random);
    std::shuffle(cells.begin(), cells.end(), random);
    Cells renamed = cells;
    for (auto& cell : renamed) {
      for (std::uint32_t& point : cell) point = names[point];
      std::shuffle(cell.begin(), cell.end(), random);
    }
    renamed.resize(renamed.size() - static_cast<std::size_t>(round) * 9);  // holes
    const FaceNumbers expected = faces_of_one_cell(renamed);
    for (const std::uint64_t most_at_once : {std::uint64_t{1}, std::uint64_t{37}, std::uint64_t{1} << 26})
      EXPECT_EQ(boundary_faces(renamed, 125, most_at_once), expected) << round << ' ' << most_at_once;
  }
}

TEST(MeshBoundary, of_a_part_are_the_faces_of_one_of_its_cells) {
  const TetSample sample = box(3);
  const Cells cells = cells_of(sample);
  const TemporaryFolder folder;
  const TetMesh mesh = packed(sample, folder / "m.rho");
  std::vector<std::uint64_t> part;
  for (std::uint64_t c = cells.size(); c-- > 0;)
    if (c % 7 < 3) part.push_back(c);
  Cells alone;
  for (const std::uint64_t c : part) alone.push_back(cells[c]);
  FaceNumbers expected = faces_of_one_cell(alone);
  for (std::uint64_t& number : expected) number = 4 * part[number / 4] + number % 4;
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(boundary_faces(mesh, part), expected);
  EXPECT_GT(expected.size(), 100U);
  EXPECT_THAT(boundary_faces(mesh, std::vector<std::uint64_t>{}), testing::IsEmpty());
}

TEST(MeshBoundary, is_kept_in_the_file_and_computed_without_it) {
  TetSample sample = box(2);
  const TemporaryFolder folder;
  const TetMesh without = packed(sample, folder / "without.rho");
  EXPECT_THAT(without.boundary(), testing::IsEmpty());
  EXPECT_EQ(without.file().version(), "1.0");
  const FaceNumbers faces = boundary_faces(without);
  EXPECT_EQ(faces.size(), 48U);

  sample.boundary.assign(faces.begin(), faces.end());
  sample.description.boundary_face_count = faces.size();
  const TetMesh with = packed(sample, folder / "with.rho");
  EXPECT_THAT(with.boundary(), testing::ElementsAreArray(faces));
  EXPECT_EQ(with.file().version(), "1.7");
  EXPECT_EQ(boundary_faces(with), faces);
  EXPECT_THAT(deep_findings(with), testing::IsEmpty());
}

TEST(MeshBoundary, is_not_computed_after_a_stop_request) {
  const TetSample sample = box(2);
  const TemporaryFolder folder;
  const TetMesh mesh = packed(sample, folder / "m.rho");
  std::stop_source stop;
  stop.request_stop();
  const std::vector<std::uint64_t> part{0, 1};
  const auto expect_interrupted = [](const auto& act) { tests::expect_error(ErrorCode::interrupted, "", act); };
  expect_interrupted([&] { boundary_faces(cells_of(sample), 27, most_faces_at_once, stop.get_token()); });
  expect_interrupted([&] { boundary_faces(mesh, stop.get_token()); });
  expect_interrupted([&] { boundary_faces(mesh, part, stop.get_token()); });
  expect_interrupted([&] { TetMesh(mesh.file(), stop.get_token()); });
}

TEST(MeshBoundary, that_is_wrong_is_found_by_the_deep_check) {
  TetSample sample = box(2);
  const TemporaryFolder folder;
  const FaceNumbers faces = boundary_faces(cells_of(sample), sample.description.point_count);
  const auto findings = [&](const FaceNumbers& stored) {
    sample.boundary.assign(stored.begin(), stored.end());
    sample.description.boundary_face_count = stored.size();
    std::filesystem::remove(folder / "m.rho");
    return deep_findings(packed(sample, folder / "m.rho"));
  };
  FaceNumbers fewer(faces.begin(), faces.end() - 1), other = faces;
  EXPECT_THAT(findings(fewer), testing::ElementsAre(testing::HasSubstr("wrong face of the boundary")));
  while (std::find(faces.begin(), faces.end(), other[3]) != faces.end()) ++other[3];
  std::sort(other.begin(), other.end());
  EXPECT_THAT(findings(other), testing::ElementsAre(testing::HasSubstr("wrong face of the boundary")));
}

}  // namespace
}  // namespace rhoray::formats
