#include "tests/agreement/pictures.h"

namespace rhoray::tests {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// Two balls far apart. The field has no data (NaN) beyond 9 units from their centres.
float two_balls(const Index3& at) {
  const Vec3 p(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z));
  const double distance = std::min((p - Vec3(10, 11, 12)).length(), (p - Vec3(47, 30, 40)).length());
  return distance > 9 ? nan : static_cast<float>(9 - distance);
}

void expect_same_pictures(const render::Dataset& a, const render::Dataset& b, double isovalue, std::size_t least_hits) {
  for (const render::Mode mode : {render::Mode::isosurface, render::Mode::mip})
    for (const bool straight : {false, true}) {
      render::Scene scene = straight ? straight_scene(a, isovalue) : oblique_scene(a, isovalue);
      scene.layers[0].mode = mode;
      const render::Framebuffer expected = picture(a, scene);
      EXPECT_GT(hit_count(expected), least_hits);
      expect_same_bits(expected, picture(b, scene));
    }
}

}  // namespace

// Bricks that are not stored are equivalent to bricks full of NaN.
TEST(SparseBricks, give_the_same_bits_as_the_whole_grid_and_take_less_room) {
  const TemporaryFolder folder;
  const auto dataset = volume_of<float>({60, 44, 52}, two_balls);
  const render::Dataset dense = packed(folder, "dense.rho", dataset);
  for (const std::int64_t edge : {2, 4, 8}) {
    const render::Dataset sparse = packed(folder, concat("sparse", edge, ".rho"), dataset,
                                          {.order = preprocess::SampleOrder::sparse, .brick_edge = edge});
    EXPECT_LT(2 * sparse.file().file_bytes(), dense.file().file_bytes());
    EXPECT_EQ(sparse.field().no_data_count, dense.field().no_data_count);
    EXPECT_EQ(sparse.field().histogram, dense.field().histogram);
    expect_same_pictures(dense, sparse, 4.5, 100);
  }
}

TEST(SeveralFields, are_seen_each_as_if_it_were_alone) {
  const TemporaryFolder folder;
  std::vector<preprocess::NeutralVolume> fields;
  fields.reserve(3);
  fields.push_back(noise_volume<std::uint16_t>({21, 30, 26}, 6, 3));
  fields.push_back(noise_volume<float>({21, 30, 26}, 9, 4));
  fields.push_back(noise_volume<std::int8_t>({21, 30, 26}, 6, 5));
  const char* names[] = {"density", "pressure", "speed"};
  for (std::size_t f = 0; f < 3; ++f) fields[f].field_name = names[f];
  preprocess::pack_grid(fields, folder / "all.rho");
  for (std::size_t f = 0; f < 3; ++f) {
    const render::Dataset alone = packed(folder, concat(names[f], ".rho"), fields[f]);
    const render::Dataset of_all = render::Dataset::load(folder / "all.rho", names[f]);
    EXPECT_EQ(of_all.field().name, names[f]);
    EXPECT_EQ(of_all.field_names(), (std::vector<std::string>{"density", "pressure", "speed"}));
    expect_same_pictures(alone, of_all, 4.5, 3000);
  }
  EXPECT_EQ(render::Dataset::load(folder / "all.rho").field().name, "density");
}

// The positions of the samples change, the field in the world does not. Depth and normals refer to
// the world.
TEST(PositionsAlongAxes, give_the_picture_of_the_same_plane_on_a_uniform_grid) {
  const TemporaryFolder folder;
  const Affine map{{0, 0.5, 0.1}, {-0.25, 0, 0}, {0, 0.2, 2}, {1, -2, 3.5}};
  const Vec3 slope(0.8, -0.3, 0.5);
  const Field field = linear_field(slope, 2);
  const Index3 count(24, 20, 22);
  std::array<std::vector<double>, 3> axes;
  for (int axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < count[axis]; ++i) {  // squeezed towards the middle; same ends
      const double u = 2 * static_cast<double>(i) / static_cast<double>(count[axis] - 1) - 1;
      axes[static_cast<std::size_t>(axis)].push_back(0.5 * (1 + u * u * u) * static_cast<double>(count[axis] - 1));
    }
  auto uneven = volume_of<double>(
      count,
      [&](const Index3& at) {
        return field(map.point({axes[0][static_cast<std::size_t>(at.x)], axes[1][static_cast<std::size_t>(at.y)],
                                axes[2][static_cast<std::size_t>(at.z)]}));
      },
      map);
  uneven.axes = axes;
  const render::Dataset rectilinear = packed(folder, "rectilinear.rho", uneven);
  const render::Dataset uniform = packed(folder, "uniform.rho", sampled_volume<double>(count, map, field));
  EXPECT_LT((rectilinear.bounds().max - uniform.bounds().max).length(), 1e-12);
  const render::Scene scene = oblique_scene(uniform, field(map.point({12, 9, 11})));
  const render::FrameOptions size{.width = 192, .height = 192};
  const render::Framebuffer expected = picture(uniform, scene, size), found = picture(rectilinear, scene, size);
  const Vec3 normal = slope.normalized();
  std::size_t hits = 0, at_the_border = 0;
  for (std::size_t pixel = 0; pixel < expected.depth.size(); ++pixel) {
    const bool is_hit = std::isfinite(expected.depth[pixel]);
    if (is_hit != std::isfinite(found.depth[pixel])) {
      ++at_the_border;
      continue;
    }
    if (!is_hit) continue;
    ++hits;
    ASSERT_NEAR(found.depth[pixel], expected.depth[pixel], 1e-5F * expected.depth[pixel]);
    Vec3 n(found.normal[3 * pixel], found.normal[3 * pixel + 1], found.normal[3 * pixel + 2]);
    ASSERT_NEAR(std::abs(n.dot(normal)), 1, 1e-6);
  }
  EXPECT_GT(hits, 1000U);
  EXPECT_LE(at_the_border, 4U);
}

}  // namespace rhoray::tests
