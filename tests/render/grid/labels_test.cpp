#include "preprocess/labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "preprocess/pack_volume.h"
#include "render/load.h"
#include "render/ray_caster.h"
#include "render/render.h"
#include "tests/support/fields.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using formats::BrickGrid;
using tests::TemporaryFolder;

/// Labels 1, 5 and 9 that touch each other, in a background of 0.
int label_at(const Index3& p) {
  if (p.x < 3 || p.y < 2 || p.z < 4 || p.x > 16 || p.y > 13 || p.z > 12) return 0;
  if (p.x < 9) return 1;
  return (p.y + p.z) % 20 < 14 ? 5 : 9;
}

constexpr Index3 sample_count{20, 16, 15};

template <class T>
BrickGrid segmentation(const TemporaryFolder& folder, bool is_rectilinear = false) {
  const Affine map{{0.5, 0, 0}, {0, 0, 1.5}, {0, -2, 0}, {10, 20, 30}};
  NeutralVolume volume = tests::volume_of<T>(
      sample_count, [](const Index3& p) { return static_cast<T>(label_at(p)); }, map);
  volume.length_unit = "mm";
  volume.space = formats::Space::ras;
  if (is_rectilinear)
    for (int i = 0; i < sample_count.y; ++i) volume.axes[1].push_back(i + 0.01 * i * i);
  pack_volume(volume, folder / "labels.rho", {.replace_existing = true});
  return BrickGrid(formats::PackedFile::open(folder / "labels.rho"));
}

TEST(Labels, are_found_with_boxes_around_their_samples) {
  const TemporaryFolder folder;
  const auto check = [](const BrickGrid& grid) {
    const auto labels = find_labels(grid, 0);
    ASSERT_TRUE(labels);
    ASSERT_EQ(labels->size(), 3U);
    for (const Label& label : *labels) {
      Index3 first = sample_count, end(0, 0, 0);
      for (std::int64_t k = 0; k < sample_count.z; ++k)
        for (std::int64_t j = 0; j < sample_count.y; ++j)
          for (std::int64_t i = 0; i < sample_count.x; ++i) {
            if (label_at({i, j, k}) != label.value) continue;
            first = Index3(std::min(first.x, i), std::min(first.y, j), std::min(first.z, k));
            end = Index3(std::max(end.x, i + 1), std::max(end.y, j + 1), std::max(end.z, k + 1));
          }
      EXPECT_EQ(label.first, first) << label.value;
      EXPECT_EQ(label.end, end) << label.value;
    }
    EXPECT_EQ((*labels)[0].value, 1);
    EXPECT_EQ((*labels)[1].value, 5);
    EXPECT_EQ((*labels)[2].value, 9);
  };
  check(segmentation<std::uint8_t>(folder));
  check(segmentation<std::int16_t>(folder));
  check(segmentation<std::uint32_t>(folder));
}

TEST(Labels, are_not_found_in_pictures_masks_and_fractions) {
  const TemporaryFolder folder;
  const auto labels_of = [&](const NeutralVolume& volume) {
    pack_volume(volume, folder / "v.rho", {.replace_existing = true});
    return find_labels(BrickGrid(formats::PackedFile::open(folder / "v.rho")), 0);
  };
  const auto of = [&](auto value) {
    return labels_of(tests::volume_of<std::uint8_t>(
        {16, 16, 16}, [&](const Index3& p) { return static_cast<std::uint8_t>(value(p)); }));
  };
  EXPECT_FALSE(of([](const Index3& p) { return p.x * 10 + p.y; })) << "a ramp";
  EXPECT_FALSE(of([](const Index3& p) { return p.x % 7; })) << "few values that change at every step";
  EXPECT_FALSE(of([](const Index3& p) { return p.x > 8 ? 255 : 0; })) << "a mask";
  EXPECT_TRUE(of([](const Index3& p) { return p.x / 4; }));
  EXPECT_FALSE(of([](const Index3& p) { return p.x / 4 + 4 * (p.y / 4) + 16 * (p.z / 4); })) << "64 labels";
  EXPECT_FALSE(labels_of(tests::volume_of<float>({16, 16, 16}, [](const Index3& p) {
    return static_cast<float>(p.x / 4);
  }))) << "floating-point numbers";
}

/// The trilinear interpolation of the indicator, straight from the definition.
double indicator_at(const Vec3& p, int label) {
  double sum = 0;
  const Index3 low(static_cast<std::int64_t>(std::floor(p.x)), static_cast<std::int64_t>(std::floor(p.y)),
                   static_cast<std::int64_t>(std::floor(p.z)));
  for (int corner = 0; corner < 8; ++corner) {
    const Index3 at = low + Index3(corner & 1, corner >> 1 & 1, corner >> 2);
    if (at.x >= sample_count.x || at.y >= sample_count.y || at.z >= sample_count.z) continue;
    const double weight = (1 - std::abs(p.x - static_cast<double>(at.x))) *
                          (1 - std::abs(p.y - static_cast<double>(at.y))) *
                          (1 - std::abs(p.z - static_cast<double>(at.z)));
    sum += weight * (label_at(at) == label ? 1 : 0);
  }
  return sum;
}

TEST(Labels, have_surfaces_where_the_interpolated_indicator_is_one_half) {
  const TemporaryFolder folder;
  const BrickGrid grid = segmentation<std::uint8_t>(folder);
  const Affine grid_from_world = grid.description().world_from_grid.inverse();
  std::size_t hits = 0;
  const auto labels = find_labels(grid, 0);
  for (const Label& label : labels.value()) {
    const render::Dataset dataset = render::Dataset::load(pack_indicator(grid, 0, label));
    EXPECT_EQ(dataset.space(), formats::Space::ras);
    EXPECT_EQ(dataset.length_unit(), "mm");
    const render::Camera camera = render::fit_camera(dataset.bounds(), {.azimuth_deg = 33, .elevation_deg = 21}, 1);
    render::Scene scene;
    scene.camera = camera;
    scene.layers[0].isovalue = 0.5;
    scene.layers[0].method = render::method_of(render::Accuracy::float64);
    render::Framebuffer found;
    render::render(dataset, scene, {.width = 48, .height = 48, .channels = {.depth = true}}, found);
    const std::vector<render::Ray> rays = camera_rays(dataset, camera, 48, 48);
    const Affine world_from_data = world_from_ray_frame(dataset);
    for (std::size_t p = 0; p < found.pixel_count(); ++p) {
      if (!std::isfinite(found.depth[p])) continue;
      ++hits;
      const Vec3 world = world_from_data.point(rays[p].origin + double{found.depth[p]} * rays[p].direction);
      // The depth is a float.
      ASSERT_NEAR(indicator_at(grid_from_world.point(world), label.value), 0.5, 1e-4) << label.value << ' ' << p;
    }
  }
  EXPECT_GT(hits, 1500U);
}

TEST(Labels, keep_their_place_on_uneven_axes) {
  const TemporaryFolder folder;
  const BrickGrid grid = segmentation<std::uint8_t>(folder, true);
  const auto labels = find_labels(grid, 0);
  for (const Label& label : labels.value()) {
    const BrickGrid indicator(pack_indicator(grid, 0, label));
    const auto& of_whole = grid.description().axes[1];
    const auto& of_label = indicator.description().axes[1];
    ASSERT_FALSE(of_label.empty());
    EXPECT_EQ(of_label.front(), of_whole[static_cast<std::size_t>(label.first.y - 1)]);
    const Index3 first = label.first - Index3(1, 1, 1);
    EXPECT_EQ(
        indicator.description().world_from_grid.origin,
        grid.description().world_from_grid.point({static_cast<double>(first.x), 0, static_cast<double>(first.z)}));
  }
}

}  // namespace
}  // namespace rhoray::preprocess
