#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/frame/antialiasing.h"
#include "tests/agreement/pictures.h"
#include "tests/support/equal_bytes.h"
#include "tests/support/expect_error.h"

/// Further samples at edges, and only there.
namespace rhoray::tests {
namespace {

using render::Framebuffer;
using render::FrameOptions;
using render::FrameStatistics;
using render::Layer;
using render::Mode;
using render::Scene;

constexpr int edge = 96;

struct Answer {
  Framebuffer picture;
  FrameStatistics statistics;
};

Answer traced(std::span<const render::Dataset> datasets, const Scene& scene, const FrameOptions& options) {
  Answer answer;
  answer.statistics = render::render(datasets, scene, options, answer.picture);
  return answer;
}

/// Returns the part of a convex polygon on one side of a line.
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, const Vec3& normal, double offset) {
  std::vector<Vec3> left;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double of_a = normal.dot(a) - offset, of_b = normal.dot(b) - offset;
    if (of_a <= 0) left.push_back(a);
    if ((of_a < 0 && of_b > 0) || (of_a > 0 && of_b < 0)) left.push_back(a + (b - a) * (of_a / (of_a - of_b)));
  }
  return left;
}

double area(const std::vector<Vec3>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return std::abs(twice) / 2;
}

/// A flat plane bounded by the data: a rotated square in the picture, all of one colour.
struct Square {
  TemporaryFolder folder;
  render::Dataset dataset = packed(folder, "plane.rho",
                                   sampled_volume<float>({5, 5, 5}, lattice_over({{-1, -1, -1}, {1, 1, 1}}, {5, 5, 5}),
                                                         [](const Vec3& p) { return p.z - 0.125; }));
  double turn = 0.3;
  double height = 3.4;

  Scene scene() const {
    Scene scene;
    scene.camera = {.position = {0.017, 0.011, 5},
                    .target = {0.017, 0.011, 0},
                    .up = {std::sin(turn), std::cos(turn), 0},
                    .orthographic = true,
                    .orthographic_height = height};
    return scene;
  }

  /// Returns the share of a pixel that the square covers.
  double coverage(int x, int y) const {
    const double pixel = height / edge;
    const Vec3 up(std::sin(turn), std::cos(turn), 0), right(std::cos(turn), -std::sin(turn), 0);
    const auto corner = [&](int dx, int dy) {
      return Vec3(0.017, 0.011, 0) + right * ((x + dx - edge / 2) * pixel) - up * ((y + dy - edge / 2) * pixel);
    };
    std::vector<Vec3> polygon{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
    for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0)})
      polygon = clipped(polygon, normal, 1);
    return area(polygon) / (pixel * pixel);
  }
};

struct Errors {
  double largest = 0, mean_square = 0;
};

/// Errors of the pixels that an edge passes through.
Errors coverage_errors(const Square& square, const Framebuffer& picture) {
  Errors errors;
  double count = 0;
  for (int y = 0; y < edge; ++y)
    for (int x = 0; x < edge; ++x) {
      const double expected = square.coverage(x, y);
      const double found = picture.color[4 * static_cast<std::size_t>(y * edge + x) + 3];
      if (expected < 1e-9 || expected > 1 - 1e-9) {
        EXPECT_NEAR(found, expected, 1e-6) << x << ", " << y;
        continue;
      }
      errors.largest = std::max(errors.largest, std::abs(found - expected));
      errors.mean_square += (found - expected) * (found - expected);
      ++count;
    }
  errors.mean_square /= count;
  return errors;
}

TEST(Antialiasing, comes_near_the_share_of_a_pixel_that_an_edge_leaves) {
  Square square;
  struct Bound {
    int samples;
    double largest, root_mean_square;
  };
  for (const Bound& bound : {Bound{8, 0.26, 0.09}, {16, 0.17, 0.045}, {64, 0.1, 0.025}})
    for (const double turn : {0.02, 0.3, std::numbers::pi / 4, 1.2}) {
      square.turn = turn;
      const Answer answer = traced({&square.dataset, 1}, square.scene(),
                                   {.width = edge, .height = edge, .antialiasing = bound.samples, .threads = 1});
      const Errors errors = coverage_errors(square, answer.picture);
      EXPECT_LE(errors.largest, bound.largest) << bound.samples << " at " << turn;
      EXPECT_LE(std::sqrt(errors.mean_square), bound.root_mean_square) << bound.samples << " at " << turn;
    }
}

TEST(Antialiasing, samples_only_pixels_beside_edges) {
  const Square square;
  const Answer answer =
      traced({&square.dataset, 1}, square.scene(), {.width = edge, .height = edge, .antialiasing = 16, .threads = 1});
  const Answer plain = traced({&square.dataset, 1}, square.scene(), {.width = edge, .height = edge, .threads = 1});
  std::uint64_t beside_edges = 0;
  for (int y = 0; y < edge; ++y)
    for (int x = 0; x < edge; ++x) {
      const auto hit = [&](int at_x, int at_y) {
        if (at_x < 0 || at_y < 0 || at_x >= edge || at_y >= edge) at_x = x, at_y = y;
        return plain.picture.color[4 * static_cast<std::size_t>(at_y * edge + at_x) + 3];
      };
      const float here = hit(x, y);
      beside_edges += hit(x - 1, y) != here || hit(x + 1, y) != here || hit(x, y - 1) != here || hit(x, y + 1) != here;
    }
  EXPECT_EQ(answer.statistics.edge_pixels, beside_edges);
  EXPECT_EQ(answer.statistics.edge_samples, 15 * beside_edges);
  EXPECT_EQ(answer.statistics.rays, edge * edge + answer.statistics.edge_samples);
}

TEST(Antialiasing, gives_a_slanted_plane_no_further_sample) {
  TemporaryFolder folder;
  const std::vector<render::Dataset> datasets = [&] {
    std::vector<render::Dataset> all;
    all.push_back(packed(folder, "slant.rho",
                         sampled_volume<float>({5, 5, 5}, lattice_over({{-1, -1, -1}, {1, 1, 1}}, {5, 5, 5}),
                                               [](const Vec3& p) { return p.z - 0.7 * p.x; })));
    return all;
  }();
  for (const bool orthographic : {false, true}) {
    Scene scene;
    scene.camera = {.position = {-0.4, -1, 2.5},
                    .target = {0, 0, 0},
                    .vertical_fov_deg = 8,
                    .orthographic = orthographic,
                    .orthographic_height = 0.4};
    const Answer answer = traced(datasets, scene, {.width = edge, .height = edge, .antialiasing = 16, .threads = 1});
    EXPECT_EQ(answer.statistics.hits, edge * edge);
    EXPECT_EQ(answer.statistics.edge_pixels, 0U);
  }
}

/// A sphere in front of a sphere of the same colour and lighting: only depths show the border
/// between them.
TEST(Antialiasing, finds_an_edge_that_only_depths_tell) {
  TemporaryFolder folder;
  std::vector<render::Dataset> datasets;
  const auto steps = [](const Vec3& p) { return std::max(p.z - (p.x < 0 ? 0.5 : -0.5), -1.0); };
  datasets.push_back(
      packed(folder, "step.rho",
             sampled_volume<float>({257, 5, 257}, lattice_over({{-1, -1, -1}, {1, 1, 1}}, {257, 5, 257}), steps)));
  Scene scene;
  scene.camera = {.position = {0.003, 0, 5},
                  .target = {0.003, 0, 0},
                  .up = {0, 1, 0},
                  .orthographic = true,
                  .orthographic_height = 1};
  const Answer answer = traced(datasets, scene, {.width = edge, .height = edge, .antialiasing = 16, .threads = 1});
  EXPECT_GE(answer.statistics.edge_pixels, 2U * edge);
  EXPECT_LE(answer.statistics.edge_pixels, 4U * edge);
}

struct Layers {
  TemporaryFolder folder;
  std::vector<render::Dataset> datasets;
  Scene scene;

  Layers() {
    const Box3 box{{-1, -1, -1}, {1, 1, 1}};
    const auto waves = [](const Vec3& p) { return std::sin(5 * p.x + 1) + std::sin(4 * p.y) * std::cos(6 * p.z); };
    datasets.push_back(
        packed(folder, "grid.rho", sampled_volume<float>({25, 25, 25}, lattice_over(box, {25, 25, 25}), waves)));
    preprocess::NeutralMesh mesh = box_mesh({.cells = {6, 6, 6}, .box = box, .jitter = 0.1});
    add_point_field(mesh, "value", [](const Vec3& p) { return p.length(); });
    datasets.push_back(packed(folder, "mesh.rho", mesh));
    scene.layers = {Layer{.dataset = 0, .isovalue = 0.4}, Layer{.dataset = 1, .isovalue = 0.8}};
    scene.layers[1].material.opacity = 0.5;
    scene.layers[1].material.color = {0.1, 0.2, 0.9};
    scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, -1, 1}, .casts_shadows = true}};
    scene.occlusion = {.samples = 4, .radius = 0.3};
    scene.camera = render::fit_camera(box, {.azimuth_deg = 33, .elevation_deg = 21}, 1);
  }
};

/// Returns means over squares of pixels, channel by channel.
std::vector<double> means_of(const Framebuffer& fine, int square) {
  const int across = fine.width / square;
  std::vector<double> means(static_cast<std::size_t>(across) * static_cast<std::size_t>(fine.height / square) * 4);
  for (std::size_t p = 0; p < fine.pixel_count(); ++p) {
    const auto x = static_cast<int>(p) % fine.width / square, y = static_cast<int>(p) / fine.width / square;
    for (std::size_t c = 0; c < 4; ++c)
      means[4 * static_cast<std::size_t>(y * across + x) + c] +=
          static_cast<double>(fine.color[4 * p + c]) / (square * square);
  }
  return means;
}

// A region tested against the rays of another tile would show what it removes along every edge.
TEST(Antialiasing, shows_what_a_clip_region_leaves) {
  Layers shown;
  shown.scene.lights = {{}};
  shown.scene.occlusion = {};
  Layer slice{.dataset = 0, .mode = render::Mode::slice};
  slice.plane = {.point = {0.1, 0, 0}, .normal = {1, 0, 0}};
  slice.material.color_by = render::FieldColors{.field = shown.datasets[0].field().name, .range = {.lo = -2, .hi = 2}};
  shown.scene.layers.push_back(slice);
  shown.scene.layers[0].clipped = false;
  constexpr int square = 6;
  for (const bool cuts_away : {false, true}) {
    shown.scene.clip = render::Clip{.planes = {{.point = {0.1, 0, 0}, .normal = {1, 0, 0}}}, .cuts_away = cuts_away};
    const Answer smooth =
        traced(shown.datasets, shown.scene, {.width = edge, .height = edge, .antialiasing = 16, .threads = 1});
    const Answer fine =
        traced(shown.datasets, shown.scene, {.width = square * edge, .height = square * edge, .threads = 1});
    const std::vector<double> means = means_of(fine.picture, square);
    std::size_t differing = 0;
    for (std::size_t i = 0; i < means.size(); ++i)
      differing += std::abs(static_cast<double>(smooth.picture.color[i]) - means[i]) > 0.15;
    EXPECT_GT(smooth.statistics.edge_pixels, 300U);
    // Allows for 16 samples per pixel, and for pixels at an edge that their middle and their
    // neighbours do not show.
    EXPECT_LT(differing, means.size() / 200) << cuts_away;
  }
}

TEST(Antialiasing, is_the_same_for_any_number_of_threads_and_in_passes) {
  const Layers shown;
  const FrameOptions one{.width = edge, .height = edge, .channels = all_channels, .antialiasing = 16, .threads = 1};
  const Answer first = traced(shown.datasets, shown.scene, one);
  EXPECT_GT(first.statistics.edge_pixels, 0U);
  FrameOptions three = one;
  three.threads = 3;
  const Answer second = traced(shown.datasets, shown.scene, three);
  EXPECT_TRUE(equal_bytes(first.picture.color, second.picture.color));
  EXPECT_EQ(first.statistics.edge_samples, second.statistics.edge_samples);
  Framebuffer refined;
  render::RenderContext memory;
  render::refine(shown.datasets, shown.scene, three, {.first_spacing = 4}, refined, memory);
  EXPECT_TRUE(equal_bytes(first.picture.color, refined.color));
}

TEST(Antialiasing, changes_no_channel_and_keeps_those_asked_for_alone) {
  const Layers shown;
  FrameOptions options{.width = edge, .height = edge, .channels = all_channels, .threads = 1};
  const Answer plain = traced(shown.datasets, shown.scene, options);
  options.antialiasing = 8;
  const Answer smooth = traced(shown.datasets, shown.scene, options);
  EXPECT_FALSE(equal_bytes(plain.picture.color, smooth.picture.color));
  EXPECT_TRUE(equal_bytes(plain.picture.depth, smooth.picture.depth));
  EXPECT_TRUE(equal_bytes(plain.picture.normal, smooth.picture.normal));
  EXPECT_TRUE(equal_bytes(plain.picture.cell, smooth.picture.cell));
  options.channels = {};
  const Answer color_alone = traced(shown.datasets, shown.scene, options);
  EXPECT_TRUE(equal_bytes(smooth.picture.color, color_alone.picture.color));
  EXPECT_TRUE(color_alone.picture.depth.empty() && color_alone.picture.normal.empty());
}

TEST(Antialiasing, off_traces_and_counts_nothing_more) {
  const Layers shown;
  const Answer plain = traced(shown.datasets, shown.scene, {.width = edge, .height = edge, .threads = 1});
  EXPECT_EQ(plain.statistics.edge_pixels, 0U);
  EXPECT_EQ(plain.statistics.edge_samples, 0U);
  EXPECT_EQ(plain.statistics.rays, edge * edge);
}

/// Each pixel shows the mean of the corresponding pixels in a larger picture.
TEST(Antialiasing, of_several_layers_comes_near_a_picture_of_more_pixels) {
  const Layers shown;
  constexpr int finer = 8;
  const Answer fine =
      traced(shown.datasets, shown.scene, {.width = edge * finer, .height = edge * finer, .threads = 1});
  const auto error_of = [&](int samples) {
    const Answer answer =
        traced(shown.datasets, shown.scene, {.width = edge, .height = edge, .antialiasing = samples, .threads = 1});
    double sum = 0;
    for (int y = 0; y < edge; ++y)
      for (int x = 0; x < edge; ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          double mean = 0;
          for (int j = 0; j < finer; ++j)
            for (int i = 0; i < finer; ++i)
              mean +=
                  fine.picture.color[4 * static_cast<std::size_t>((y * finer + j) * edge * finer + x * finer + i) + c];
          mean /= finer * finer;
          const double found = answer.picture.color[4 * static_cast<std::size_t>(y * edge + x) + c];
          sum += (found - mean) * (found - mean);
        }
    return std::sqrt(sum / (3 * edge * edge));
  };
  const double plain = error_of(1), smooth = error_of(32);
  EXPECT_LT(smooth, plain / 3) << plain << " and " << smooth;
}

TEST(Antialiasing, of_a_projection_looks_at_colours_alone) {
  TemporaryFolder folder;
  std::vector<render::Dataset> datasets;
  datasets.push_back(packed(folder, "ball.rho",
                            sampled_volume<float>({33, 33, 33}, lattice_over({{-1, -1, -1}, {1, 1, 1}}, {33, 33, 33}),
                                                  [](const Vec3& p) { return p.length() < 0.5 ? 1.0 : 0.0; })));
  Scene scene;
  scene.layers[0].mode = Mode::mip;
  scene.layers[0].window = {.lo = 0, .hi = 1};
  scene.background = {0, 0, 0};
  scene.camera = render::fit_camera(datasets[0].bounds(), {}, 1);
  const Answer answer = traced(datasets, scene, {.width = edge, .height = edge, .antialiasing = 8, .threads = 1});
  EXPECT_GT(answer.statistics.edge_pixels, 0U);
  EXPECT_LT(answer.statistics.edge_pixels, edge * edge / 4U);
}

TEST(Antialiasing, refuses_a_number_of_samples_that_is_none) {
  const Square square;
  Framebuffer out;
  for (const int samples : {0, -3, render::most_samples + 1})
    expect_error(ErrorCode::usage, "samples of a pixel", [&] {
      render::render(square.dataset, square.scene(), {.width = 8, .height = 8, .antialiasing = samples}, out);
    });
}

}  // namespace
}  // namespace rhoray::tests
