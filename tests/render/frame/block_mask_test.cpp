#include "render/frame/block_mask.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/render/support/rays.h"

namespace rhoray::tests {
namespace {

using render::BlockMask;
using render::box_around;
using render::BoxLevels;
using render::BoxNode;
using render::BoxProjection;
using render::Camera;
using render::CameraRays;
using render::PixelLattice;
using render::Ray;
using render::SurfaceBoxes;
using render::Tile;

constexpr int edge = render::block_edge;

/// By definition: some t from 0 on is between the planes of every axis.
bool meets(const Ray& ray, const Box3& box) {
  double first = 0, last = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (d == 0) {
      if (o < box.min[axis] || o > box.max[axis]) return false;
      continue;
    }
    const auto [near, far] = std::minmax({(box.min[axis] - o) / d, (box.max[axis] - o) / d});
    first = std::max(first, near), last = std::min(last, far);
  }
  return first <= last;
}

std::shared_ptr<BoxLevels> tree_of(const std::vector<Box3>& boxes) {
  auto levels = std::make_shared<BoxLevels>(1);
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    if (b % BoxNode::size == 0) levels->front().push_back(BoxNode::of_empty_boxes());
    for (int axis = 0; axis < 3; ++axis) {
      levels->front().back().low[axis][b % BoxNode::size] = static_cast<float>(boxes[b].min[axis]);
      levels->front().back().high[axis][b % BoxNode::size] = static_cast<float>(boxes[b].max[axis]);
    }
  }
  add_upper_levels(*levels);
  return levels;
}

/// Marks the blocks per pixel of the lattice.
std::vector<char> blocks_of(const BlockMask& mask, const PixelLattice& lattice) {
  const int across = (lattice.columns() + edge - 1) / edge, down = (lattice.rows() + edge - 1) / edge;
  std::vector<char> marked(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
  for (const Tile& tile : render::tiles_in_order(lattice.columns(), lattice.rows())) {
    Tile masked = tile;
    masked.blocks = mask.of_tile(tile);
    for (int y = tile.y_begin; y < tile.y_end; y += edge)
      for (int x = tile.x_begin; x < tile.x_end; x += edge)
        marked[static_cast<std::size_t>(y / edge * across + x / edge)] =
            masked.has_block((x - tile.x_begin) / edge, (y - tile.y_begin) / edge);
  }
  return marked;
}

/// Returns the blocks in which a pixel's ray hits one of the boxes.
std::vector<char> blocks_by_rays(const CameraRays& camera, const Affine& data_from_world, const PixelLattice& lattice,
                                 const std::vector<Box3>& boxes) {
  const int across = (lattice.columns() + edge - 1) / edge, down = (lattice.rows() + edge - 1) / edge;
  std::vector<char> met(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
  for (int row = 0; row < lattice.rows(); ++row)
    for (int column = 0; column < lattice.columns(); ++column) {
      const Ray world =
          camera.through_pixel(lattice.x_first + column * lattice.spacing, lattice.y_first + row * lattice.spacing);
      const Ray ray{data_from_world.point(world.origin), data_from_world.vector(world.direction)};
      for (const Box3& box : boxes)
        if (meets(ray, box)) met[static_cast<std::size_t>(row / edge * across + column / edge)] = 1;
    }
  return met;
}

/// A map that rotates, scales by up to 1 : 1000, mirrors, and may put the volume far away.
Affine any_map(Dice& dice) {
  const Vec3 x = dice.direction(), y = x.cross(dice.direction()).normalized(), z = x.cross(y);
  const auto size = [&] { return std::pow(10.0, dice.between(-1.5, 1.5)) * (dice.coin() ? 1 : -1); };
  const double far = dice.one_of(std::array<double, 4>{0, 1, 1e4, 1e8});
  return {x * size(), y * size(), z * size(), dice.direction() * far};
}

Box3 any_box(Dice& dice, double largest) {
  const Vec3 low = dice.point({-20, -20, -20}, {20, 20, 20});
  Box3 box(low, low + dice.point({0, 0, 0}, {largest, largest, largest}));
  for (int axis = 0; axis < 3; ++axis) {
    if (dice.below(6) == 0) box.max[axis] = box.min[axis];  // flat
    box.min[axis] = static_cast<float>(box.min[axis]), box.max[axis] = static_cast<float>(box.max[axis]);
  }
  return box;
}

/// From afar, near by, inside a box, on its face, or with the box behind.
Camera any_camera(Dice& dice, const Affine& world_from_data, const Box3& box) {
  Vec3 eye = dice.point(box.min, box.max);
  const std::int64_t place = dice.below(4);
  const double size = std::max(1.0, box.size().length());
  if (place == 0) eye += dice.direction() * size * 50;
  if (place == 1) eye += dice.direction() * size * 2;
  if (place == 2) eye[static_cast<int>(dice.below(3))] = dice.coin() ? box.min.x : box.max.x;
  const Vec3 target = dice.below(3) == 0 ? eye + dice.direction() * size : dice.point(box.min, box.max);
  return {.position = world_from_data.point(eye),
          .target = world_from_data.point(target),
          .up = dice.direction(),
          .vertical_fov_deg = dice.one_of(std::array<double, 5>{40, 90, 3, 150, 0.01}),
          .orthographic = dice.below(3) == 0,
          .orthographic_height = size * std::cbrt(std::abs(world_from_data.determinant()))};
}

PixelLattice any_lattice(Dice& dice) {
  PixelLattice lattice{.width = static_cast<int>(1 + dice.below(150)), .height = static_cast<int>(1 + dice.below(110))};
  lattice.spacing = dice.one_of(std::array<int, 4>{1, 1, 2, 8});
  lattice.x_first = static_cast<int>(dice.below(std::min(lattice.spacing, lattice.width)));
  lattice.y_first = static_cast<int>(dice.below(std::min(lattice.spacing, lattice.height)));
  return lattice;
}

BlockMask blocks_that_may_meet(const SurfaceBoxes& boxes, const BoxProjection& projection,
                               const PixelLattice& lattice) {
  BlockMask mask(lattice);
  add_blocks_that_may_meet(boxes, projection, lattice, mask, render::chosen_machine());
  return mask;
}

TEST(BlockMask, has_every_block_in_which_a_ray_meets_a_box) {
  Dice dice(20261121);
  int scenes = 0, lost = 0, needed = 0, marked = 0, blocks = 0;
  for (int round = 0; round < 1500; ++round) {
    const Affine world_from_data = any_map(dice), data_from_world = world_from_data.inverse();
    std::vector<Box3> boxes;
    const std::int64_t count = dice.one_of(std::array<std::int64_t, 4>{1, 1, 7, 40});
    Box3 bounds;
    for (std::int64_t b = 0; b < count; ++b) {
      boxes.push_back(any_box(dice, count == 1 ? 30 : 4));
      bounds.extendBy(boxes.back());
    }
    const Camera camera = any_camera(dice, world_from_data, boxes[static_cast<std::size_t>(dice.below(count))]);
    const PixelLattice lattice = any_lattice(dice);
    const Vec3 forward = (camera.target - camera.position).normalized();
    if (!(forward.cross(camera.up).length() > 1e-6)) continue;
    const CameraRays rays(camera, lattice.width, lattice.height);
    const BoxProjection projection(rays, data_from_world, world_from_data, bounds);
    ASSERT_TRUE(projection.is_certain());
    const auto levels = tree_of(boxes);
    const BlockMask mask = blocks_that_may_meet(render::boxes_of(levels, *levels), projection, lattice);
    const std::vector<char> has = blocks_of(mask, lattice);
    const std::vector<char> met = blocks_by_rays(rays, data_from_world, lattice, boxes);
    ++scenes;
    for (std::size_t b = 0; b < has.size(); ++b) {
      lost += met[b] && !has[b];
      needed += met[b], marked += has[b], ++blocks;
    }
  }
  EXPECT_EQ(lost, 0);
  EXPECT_GT(scenes, 1400);
  EXPECT_GT(needed, blocks / 10);
  EXPECT_LT(marked, blocks * 8 / 10) << "of " << blocks << ", " << needed << " of which are needed";
  EXPECT_LT(marked, needed * 2);
}

// There a box projects to a rectangle, and nothing is rounded up.
TEST(BlockMask, has_no_other_block_where_an_orthographic_camera_looks_along_an_axis) {
  Dice dice(3);
  std::ptrdiff_t marked = 0, blocks = 0;
  for (int round = 0; round < 300; ++round) {
    const std::vector<Box3> boxes{any_box(dice, 15)};
    const PixelLattice lattice = any_lattice(dice);
    const Camera camera{
        .position = {1, -90, 2}, .target = {1, 0, 2}, .up = {0, 0, 1}, .orthographic = true, .orthographic_height = 60};
    const CameraRays rays(camera, lattice.width, lattice.height);
    const auto levels = tree_of(boxes);
    const BoxProjection projection(rays, {}, {}, boxes[0]);
    const std::vector<char> has =
        blocks_of(blocks_that_may_meet(render::boxes_of(levels, *levels), projection, lattice), lattice);
    ASSERT_EQ(has, blocks_by_rays(rays, {}, lattice, boxes)) << round;
    marked += std::count(has.begin(), has.end(), 1);
    blocks += std::ssize(has);
  }
  EXPECT_GT(marked, 300);
  EXPECT_LT(marked, blocks / 2);
}

TEST(BlockMask, has_nothing_where_there_is_nothing_and_all_where_the_eye_is_in_a_box) {
  const PixelLattice lattice{.width = 150, .height = 70};
  const Camera camera{.position = {1, 2, 3}, .target = {2, 3, 5}, .up = {0, 0, 1}, .vertical_fov_deg = 100};
  const CameraRays rays(camera, lattice.width, lattice.height);
  const Box3 around({0, 0, 0}, {5, 5, 5}), behind({-3, -3, -3}, {0.5, 1, 0});
  const auto marked = [&](const SurfaceBoxes& boxes) {
    const std::vector<char> has =
        blocks_of(blocks_that_may_meet(boxes, BoxProjection(rays, {}, {}, around), lattice), lattice);
    return std::count(has.begin(), has.end(), 1);
  };
  EXPECT_EQ(marked({}), 0);
  EXPECT_EQ(marked(render::box_around(behind)), 0);
  EXPECT_EQ(marked(render::box_around(around)), 19 * 9);
}

TEST(BoxProjection, is_the_same_on_every_machine) {
  Dice dice(5);
  std::vector<Box3> boxes;
  Box3 bounds;
  for (int b = 0; b < 16; ++b) boxes.push_back(any_box(dice, 4)), bounds.extendBy(boxes.back());
  const auto levels = tree_of(boxes);
  for (int round = 0; round < 50; ++round) {
    const PixelLattice lattice{.width = 150, .height = 70};
    const Affine world_from_data = any_map(dice);
    const CameraRays rays(any_camera(dice, world_from_data, bounds), lattice.width, lattice.height);
    const BoxProjection projection(rays, world_from_data.inverse(), world_from_data, bounds);
    render::ProjectedNode expected, got;
    const SurfaceBoxes tree = render::boxes_of(levels, *levels);
    BoxProjection::OntoLattice(projection, tree, lattice, render::Machine::scalar)
        .project(levels->front().front(), expected);
    for (const render::Machine machine : {render::Machine::avx2, render::Machine::avx512}) {
      if (!has_machine(machine)) continue;
      BoxProjection::OntoLattice(projection, tree, lattice, machine).project(levels->front().front(), got);
      for (std::size_t b = 0; b < 16; ++b) {
        ASSERT_EQ(got.first_column[b], expected.first_column[b]);
        ASSERT_EQ(got.last_column[b], expected.last_column[b]);
        ASSERT_EQ(got.first_row[b], expected.first_row[b]);
        ASSERT_EQ(got.last_row[b], expected.last_row[b]);
      }
    }
  }
}

// Nothing can be decided when rounding hides the position of the picture relative to the volume.
TEST(BoxProjection, is_not_certain_where_numbers_are_out_of_reach) {
  const Camera camera{.position = {1, 2, 3}, .target = {2, 3, 5}, .up = {0, 0, 1}};
  const CameraRays rays(camera, 10, 10);
  const Box3 box({0, 0, 0}, {1, 1, 1});
  const auto is_certain = [&](double scale) {
    const Affine map{{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, {0, 0, 0}};
    return BoxProjection(rays, map.inverse(), map, box).is_certain();
  };
  EXPECT_TRUE(is_certain(1));
  EXPECT_TRUE(is_certain(1e-30));
  EXPECT_FALSE(is_certain(1e-100));
  EXPECT_FALSE(is_certain(1e100));
}

}  // namespace
}  // namespace rhoray::tests
