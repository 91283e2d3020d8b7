#include "formats/triangle_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>

#include "formats/format_error.h"
#include "tests/support/expect_error.h"
#include "tests/support/memory_file.h"
#include "tests/support/resealed.h"

namespace rhoray::formats {
namespace {

using tests::expect_error;
using tests::MemoryFile;

/// Two triangles of a unit square.
struct Made {
  TriangleMeshDescription description{.length_unit = "mm",
                                      .point_type = ElementType::F32,
                                      .point_count = 4,
                                      .triangle_count = 2,
                                      .bounds = Box3(Vec3(0, 0, 0), Vec3(1, 1, 0)),
                                      .has_source_order = false,
                                      .flat_triangle_count = 0,
                                      .dropped_facet_count = 3,
                                      .unused_point_count = 1,
                                      .provenance = {.source_name = "a.stl", .source_checksum = {}, .command = "made"}};
  std::vector<std::array<float, 3>> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
  std::vector<std::uint32_t> ids{2, 4};

  std::string bytes() const {
    const MemoryFile memory;
    PackedFileWriter writer(memory.descriptor(), describe(description), triangle_mesh_arrays(description));
    writer.write("points", 0, std::as_bytes(std::span(points)));
    writer.write("triangles", 0, std::as_bytes(std::span(triangles)));
    if (!description.has_source_order) writer.write("triangle_ids", 0, std::as_bytes(std::span(ids)));
    writer.commit();
    return memory.content();
  }
};

TriangleMesh opened(const std::string& bytes) {
  const MemoryFile memory(bytes);
  return TriangleMesh(PackedFile::from_descriptor(memory.descriptor(), "a.rho"));
}

TEST(TriangleMesh, is_read_as_it_was_written) {
  const Made made;
  const TriangleMesh surface = opened(made.bytes());
  const TriangleMeshDescription& d = surface.description();
  EXPECT_EQ(surface.file().version(), "1.3");
  EXPECT_EQ(d.length_unit, "mm");
  EXPECT_EQ(d.point_type, ElementType::F32);
  EXPECT_EQ(d.bounds, made.description.bounds);
  EXPECT_EQ(d.dropped_facet_count, 3U);
  EXPECT_EQ(d.unused_point_count, 1U);
  EXPECT_EQ(d.provenance.source_name, "a.stl");
  EXPECT_EQ(surface.point(2), (std::array<double, 3>{1, 1, 0}));
  EXPECT_EQ(surface.triangles()[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_EQ(surface.triangle_id(1), 4U);
  EXPECT_THAT(deep_findings(surface), testing::IsEmpty());
}

TEST(TriangleMesh, has_ids_of_its_own_in_the_order_of_the_source) {
  Made made;
  made.description.has_source_order = true;
  const TriangleMesh surface = opened(made.bytes());
  EXPECT_FALSE(surface.file().has("triangle_ids"));
  EXPECT_EQ(surface.triangle_id(1), 1U);
}

TEST(TriangleMesh, keeps_points_in_double_precision) {
  const Made made;
  TriangleMeshDescription d = made.description;
  d.point_type = ElementType::F64;
  const std::vector<std::array<double, 3>> points{{0.1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const MemoryFile memory;
  PackedFileWriter writer(memory.descriptor(), describe(d), triangle_mesh_arrays(d));
  writer.write("points", 0, std::as_bytes(std::span(points)));
  writer.write("triangles", 0, std::as_bytes(std::span(made.triangles)));
  writer.write("triangle_ids", 0, std::as_bytes(std::span(made.ids)));
  writer.commit();
  EXPECT_EQ(opened(memory.content()).point(0)[0], 0.1);
}

TEST(TriangleMesh, refuses_a_corner_that_is_no_point) {
  Made made;
  made.triangles[1][2] = 4;
  expect_error(ErrorCode::invalid, "array 'triangles', element 5: found 4; expected an index below 4",
               [&] { opened(made.bytes()); });
}

TEST(TriangleMesh, refuses_points_that_are_not_finite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Made made;
    made.points[3][1] = bad;
    expect_error(ErrorCode::invalid, "array 'points', element 10", [&] { opened(made.bytes()); });
  }
}

TEST(TriangleMesh, refuses_a_file_that_ends_too_soon) {
  const std::string bytes = Made().bytes();
  for (const std::size_t size : {bytes.size() - 1, bytes.size() / 2, std::size_t{100}})
    expect_error(ErrorCode::invalid, "a.rho", [&] { opened(bytes.substr(0, size)); });
}

/// Changes content and recomputes valid checksums.
void expect_refusal(const std::string& from, const std::string& to, const std::string& words) {
  tests::Envelope parts = tests::open_envelope(Made().bytes());
  const std::size_t at = parts.json.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  parts.json.replace(at, from.size(), to);
  expect_error(ErrorCode::invalid, words, [&] { opened(tests::seal_again(parts)); });
}

TEST(TriangleMesh, refuses_descriptions_that_do_not_fit_the_arrays) {
  expect_refusal(R"(\"point_count\":4)", R"(\"point_count\":5)", "array 'points'");
  expect_refusal(R"(\"triangle_count\":2)", R"(\"triangle_count\":1)", "array 'triangles'");
  expect_refusal(R"(\"triangle_count\":2)", R"(\"triangle_count\":0)", "triangle_count");
  expect_refusal(R"(\"point_count\":4)", R"(\"point_count\":4294967296)", "point_count");
  expect_refusal(R"(\"point_type\":\"F32\")", R"(\"point_type\":\"F64\")", "array 'points'");
  expect_refusal(R"(\"point_type\":\"F32\")", R"(\"point_type\":\"U32\")", "F32 or F64");
  expect_refusal(R"(\"high\":[1.0)", R"(\"high\":[-1.0)", "bounds");
  expect_refusal(R"(\"order\":\"ids\")", R"(\"order\":\"odd\")", "order");
  expect_refusal(R"("kind":"surface")", R"("kind":"tets")", "'surface'");
}

TEST(TriangleMesh, deep_findings_name_what_is_not_true) {
  Made made;
  made.description.bounds = Box3(Vec3(0, 0, 0), Vec3(2, 1, 0));
  made.triangles[1] = {0, 2, 2};
  made.ids = {4, 2};
  EXPECT_THAT(deep_findings(opened(made.bytes())),
              testing::UnorderedElementsAre(testing::HasSubstr("bounds"), testing::HasSubstr("a corner twice"),
                                            testing::HasSubstr("ids that fall"),
                                            testing::HasSubstr("a point that no triangle has")));
}

}  // namespace
}  // namespace rhoray::formats
