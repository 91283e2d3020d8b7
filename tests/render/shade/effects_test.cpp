#include "render/shade/effects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "render/shade/power.h"
#include "render/shade/spread_directions.h"

namespace rhoray::tests {
namespace {

using render::Colors;
using render::EffectSet;
using render::Facing;
using render::Layer;
using render::Mode;

constexpr std::size_t group_size = render::RayBatch::group_size;

Layer lit_surface() {
  Layer layer;
  layer.material = {.color = {0.5, 0.25, 1}, .ambient = 0.2, .specular = 0.4, .shininess = 10};
  return layer;
}

/// Shades one hit in every lane of a group; fails when lanes differ.
Vec3 shaded(const Layer& layer, const EffectSet& effects, const Vec3& gradient, const Vec3& direction, double value = 0,
            const Affine& world_from_data = {}, const render::Surroundings& surroundings = {}) {
  render::RayBatch rays(group_size);
  render::HitBatch hits(group_size);
  for (std::size_t i = 0; i < group_size; ++i) {
    rays.set(i, {.origin = {0, 0, 0}, .direction = direction});
    hits.set(i, {.t = 1, .value = value, .gradient = gradient});
  }
  rays.count = group_size;
  Colors colors;
  shade(layer, effects, Facing(world_from_data), rays, hits, 0, nullptr, colors, surroundings);
  for (std::size_t i = 1; i < group_size; ++i)
    EXPECT_TRUE(colors.red[i] == colors.red[0] && colors.green[i] == colors.green[0] &&
                colors.blue[i] == colors.blue[0]);
  return {colors.red[0], colors.green[0], colors.blue[0]};
}

TEST(EffectsCalledFor, are_read_from_the_layer) {
  Layer layer = lit_surface();
  EffectSet set = effects_called_for(layer);
  EXPECT_TRUE(set.diffuse && set.specular && !set.intensity);
  layer.material.specular = 0;
  EXPECT_FALSE(effects_called_for(layer).specular);
  layer.material.specular = 1;
  layer.mode = Mode::mip;
  set = effects_called_for(layer);
  EXPECT_TRUE(!set.diffuse && !set.specular && set.intensity);
}

TEST(Shade, lights_a_surface_by_the_angle_to_the_eye) {
  const Layer layer = lit_surface();
  const Vec3 away(0, 0, -1), facing(0, 0, 3), tilted(0, 5 * std::sqrt(0.75), 2.5);
  const EffectSet dull{.diffuse = true};
  for (const double side : {1.0, -1.0}) {
    EXPECT_LT((shaded(layer, dull, side * facing, away) - layer.material.color).length(), 1e-6);
    EXPECT_LT((shaded(layer, dull, side * tilted, away) - 0.6 * layer.material.color).length(), 1e-6);
  }
  const Vec3 highlight = shaded(layer, effects_called_for(layer), tilted, away) - shaded(layer, dull, tilted, away);
  const double expected = 0.4 * std::pow(0.5, 10);
  EXPECT_LT((highlight - Vec3(expected, expected, expected)).length(), 1e-6);
}

// Within a quarter of a step of 16-bit colour of the formulas in double, for any angle, any cell
// and any length of the gradient.
TEST(Shade, is_as_the_formulas_say_in_cells_of_any_shape_and_for_gradients_of_any_length) {
  Layer layer = lit_surface();
  layer.material.shininess = 40;
  const Affine sheared{{2e-3, 1e-4, 0}, {-3e-4, 4e-3, 2e-4}, {1e-3, 0, 7e-2}, {5, 6, 7}};
  Affine huge = sheared, mirrored = sheared;
  for (Vec3* axis : {&huge.x_axis, &huge.y_axis, &huge.z_axis}) *axis *= 1e30;
  mirrored.x_axis *= -1;
  double largest = 0;
  for (const Affine& map : {sheared, huge, mirrored})
    for (const double length : {1.0, 1e-300, 1e-160, 1e100, 1e300, 5e-324 * 1e6})
      for (int k = 0; k < 200; ++k) {
        const Vec3 gradient(std::sin(k), std::cos(2.1 * k), std::sin(3.3 * k + 1));
        const Vec3 direction = Vec3(std::cos(0.7 * k), 0.4, std::sin(0.9 * k)).normalized();
        const double cosine = std::abs(map.gradient(gradient).normalized().dot(direction));
        const Vec3 color = (0.2 + 0.8 * cosine) * layer.material.color + 0.4 * std::pow(cosine, 40.0) * Vec3(1, 1, 1);
        const Vec3 got =
            shaded(layer, effects_called_for(layer), gradient * length, map.inverse().vector(direction), 0, map);
        // A gradient made of a few of the smallest doubles has few digits itself.
        if (length > 1e-310) largest = std::max(largest, (got - color).length());
        EXPECT_LT((got - color).length(), length > 1e-310 ? 4e-6 : 1e-4) << length << ", " << k;
      }
  EXPECT_GT(largest, 1e-8) << "is this still computed in single precision?";
}

// The same for lights anywhere, against the formulas in double.
TEST(Shade, adds_up_lights_as_the_formulas_say) {
  const Affine sheared{{2e-3, 1e-4, 0}, {-3e-4, 4e-3, 2e-4}, {1e-3, 0, 7e-2}, {5, 6, 7}};
  Affine huge = sheared, mirrored = sheared;
  for (Vec3* axis : {&huge.x_axis, &huge.y_axis, &huge.z_axis, &huge.origin}) *axis *= 1e20;
  mirrored.x_axis *= -1;
  render::Scene scene;
  scene.layers[0] = lit_surface();
  const render::Material& surface = scene.layers[0].material;
  double highlights = 0;
  for (const Affine& map : {sheared, huge, mirrored})
    for (const double length : {1.0, 1e-300, 1e300})
      for (int k = 0; k < 200; ++k) {
        const double unit = map.z_axis.length();
        const Vec3 gradient(std::sin(k), std::cos(2.1 * k), std::sin(3.3 * k + 1));
        const Vec3 direction = Vec3(std::cos(0.7 * k), 0.4, std::sin(0.9 * k)).normalized();
        // The hits of shaded() are at t = 1 from the origin of the data's frame.
        const Vec3 place = map.origin + direction;
        scene.lights = {
            {.color = {0.5, 0.25, 0.125}},
            {.kind = render::Light::Kind::directional, .place = {3, std::sin(0.3 * k), -2}, .color = {0.1, 0.2, 2}},
            {.kind = render::Light::Kind::point,
             .place = place + unit * Vec3(std::cos(k), 2, std::sin(0.2 * k)),
             .color = {1, 0.1, 0.3}}};
        const Vec3 to_eye = -direction;
        Vec3 normal = map.gradient(gradient).normalized();
        if (normal.dot(to_eye) < 0) normal = -normal;
        Vec3 expected = surface.ambient * surface.color;
        for (const render::Light& light : scene.lights) {
          const Vec3 to_light = light.kind == render::Light::Kind::head    ? to_eye
                                : light.kind == render::Light::Kind::point ? (light.place - place).normalized()
                                                                           : light.place.normalized();
          const double cosine = normal.dot(to_light);
          if (cosine <= 0) continue;
          const double highlight =
              surface.specular *
              std::pow(std::max(0.0, normal.dot((to_light + to_eye).normalized())), surface.shininess);
          highlights += highlight;
          expected += light.color * ((1 - surface.ambient) * cosine * surface.color + highlight * Vec3(1, 1, 1));
        }
        const render::LayerLights lights = lights_of(scene, map);
        const Vec3 got = shaded(scene.layers[0], effects_called_for(scene, scene.layers[0]), gradient * length,
                                map.inverse().vector(direction), 0, map, {.lights = &lights});
        // A position that differs from the origin's by less than doubles can resolve: the light's
        // direction has an error of the same size.
        EXPECT_LT((got - expected).length(), 2e-5) << length << ", " << k;
      }
  EXPECT_GT(highlights, 1);
}

TEST(EffectsCalledFor, are_read_from_the_scene) {
  render::Scene scene;
  scene.layers[0] = lit_surface();
  const auto called_for = [&] { return effects_called_for(scene, scene.layers[0]); };
  EffectSet set = called_for();
  EXPECT_TRUE(!set.lights && !set.shadows && !set.occlusion && !set.fog) << "one white light at the camera";
  scene.lights[0].color = {1, 1, 0.5};
  EXPECT_TRUE(called_for().lights);
  scene.lights = {{}, {.kind = render::Light::Kind::point, .color = {0, 0, 0}, .casts_shadows = true}};
  set = called_for();
  EXPECT_TRUE(!set.lights && !set.shadows) << "a light of no intensity";
  scene.lights[1].color = {0, 0, 1};
  set = called_for();
  EXPECT_TRUE(set.lights && set.shadows);
  EXPECT_FALSE(called_for().soft_shadows) << "a light without a size";
  scene.lights[1].size = 0.1;
  EXPECT_TRUE(called_for().soft_shadows);
  scene.lights[1].casts_shadows = false;
  EXPECT_FALSE(called_for().soft_shadows) << "no shadows";
  scene.lights[1].casts_shadows = true;
  scene.layers[0].material.opacity = 0.5;
  EXPECT_FALSE(called_for().shadows || called_for().soft_shadows) << "nothing holds light back";
  scene.layers.push_back(lit_surface());
  EXPECT_TRUE(called_for().shadows);
  scene.lights = {{}};
  scene.occlusion.radius = 1;
  set = called_for();
  EXPECT_TRUE(set.lights && set.occlusion && !set.shadows);
  scene.layers[0].material.ambient = 0;
  EXPECT_FALSE(called_for().occlusion);
  scene.fog = render::Fog{.range = {.lo = 0, .hi = 1}};
  EXPECT_TRUE(called_for().fog);
  scene.layers[0].mode = Mode::mip;
  set = called_for();
  EXPECT_TRUE(!set.fog && !set.lights && set.intensity);
}

TEST(SpreadDirections, lie_around_the_normal_as_the_cosine_weighs) {
  double height = 0;
  Vec3 sum(0, 0, 0);
  int count = 0;
  for (const Vec3& any : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(0.3, -0.7, -1e-9), Vec3(-1, 2, 3)})
    for (std::uint32_t pixel = 0; pixel < 50; ++pixel) {
      const Vec3 normal = any.normalized();
      const render::SpreadDirections directions(pixel, 7 * pixel);
      for (int sample = 0; sample < 32; ++sample, ++count) {
        const Vec3 direction = directions.about(normal, sample);
        EXPECT_NEAR(direction.length(), 1, 1e-12);
        EXPECT_GT(direction.dot(normal), 0);
        height += direction.dot(normal), sum += direction - direction.dot(normal) * normal;
      }
    }
  EXPECT_NEAR(height / count, 2.0 / 3, 0.003);  // the mean of a cosine weighted by itself
  EXPECT_LT(sum.length() / count, 0.003);
}

TEST(SpreadDirections, fill_a_cone_evenly) {
  for (const double cap_height : {1.0, 0.3, 1e-9})
    for (const Vec3& any : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(0.3, -0.7, -1e-9)}) {
      const Vec3 axis = any.normalized();
      double below = 0, lowest = 0;
      Vec3 sum(0, 0, 0);
      int count = 0;
      for (std::uint32_t pixel = 0; pixel < 50; ++pixel) {
        const render::SpreadDirections directions(pixel, 7 * pixel);
        for (int sample = 0; sample < 32; ++sample, ++count) {
          const Vec3 direction = directions.within(axis, cap_height, sample);
          EXPECT_NEAR(direction.length(), 1, 1e-12);
          const Vec3 across = direction - direction.dot(axis) * axis;
          // 1 - cosine, without the digits that the difference would lose
          const double height = across.dot(across) / (1 + direction.dot(axis));
          below += height, lowest = std::max(lowest, height), sum += across;
        }
      }
      EXPECT_NEAR(below / count / cap_height, 0.5, 0.005);
      EXPECT_LE(lowest, cap_height * (1 + 1e-6));
      EXPECT_GT(lowest, 0.99 * cap_height);
      EXPECT_LT(sum.length() / count / std::sqrt(cap_height), 0.005);
    }
}

TEST(Shade, lights_a_hit_without_gradient_as_if_it_faced_the_eye) {
  const Layer layer = lit_surface();
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const Vec3 facing = shaded(layer, effects_called_for(layer), {0, 0, 1}, {0, 0, 1});
  for (const Vec3& none :
       {Vec3(0, 0, 0), Vec3(-0.0, 0, 0), Vec3(nan, 1, 1), Vec3(1, nan, 1), Vec3(1, 1, nan), Vec3(0, infinity, 1)}) {
    EXPECT_EQ(shaded(layer, effects_called_for(layer), none, {0, 0, 1}), facing) << none;
    EXPECT_EQ(Facing({}).normal(none, {0, 0, 1}), Vec3(0, 0, 0)) << none;
  }
}

TEST(Facing, gives_the_unit_normal_towards_the_eye) {
  const Affine map{{1, 0, 0}, {0, 2, 0}, {0, 0, 4}, {0, 0, 0}};
  for (const double length : {1.0, -1.0, 1e-300, 1e300}) {
    const Vec3 normal = Facing(map).normal(Vec3(1, 2, 4) * length, map.inverse().vector({-1, 0, 0}));
    EXPECT_LT((normal - Vec3(1, 1, 1).normalized()).length(), 1e-15) << length;
  }
}

TEST(Shade, colours_a_surface_by_a_field_and_leaves_its_own_colour_where_that_says_nothing) {
  Layer layer = lit_surface();
  layer.material.specular = 0;
  layer.material.color_by = {.field = "f", .map = render::ColorMap::coolwarm, .range = {.lo = 10, .hi = 30}};
  render::RayBatch rays(group_size);
  render::HitBatch hits(group_size);
  double values[group_size];
  for (std::size_t i = 0; i < group_size; ++i) {
    rays.set(i, {.origin = {0, 0, 0}, .direction = {0, 0, -1}});
    hits.set(i, {.t = 1, .gradient = {0, std::sqrt(0.75), 0.5}});
    values[i] = 5 + 0.5 * static_cast<double>(i);
  }
  values[7] = std::numeric_limits<double>::quiet_NaN();
  values[8] = std::numeric_limits<double>::infinity();
  Colors colors;
  shade(layer, effects_called_for(layer), Facing({}), rays, hits, 0, values, colors);
  for (std::size_t i = 0; i < group_size; ++i) {
    const Vec3 base = i == 7 ? layer.material.color : color_of(render::ColorMap::coolwarm, (values[i] - 10) / 20);
    const Vec3 found(colors.red[i], colors.green[i], colors.blue[i]);
    EXPECT_LT((found - 0.6 * base).length(), 1e-3) << values[i];
  }
}

TEST(Shade, shows_a_projection_as_even_steps_of_grey) {
  Layer layer;
  layer.mode = Mode::mip;
  layer.window = {.lo = 100, .hi = 300};
  const auto grey = [&](double value) { return shaded(layer, effects_called_for(layer), {0, 0, 0}, {0, 0, 1}, value); };
  EXPECT_EQ(grey(100), Vec3(0, 0, 0));
  EXPECT_EQ(grey(50), Vec3(0, 0, 0));
  EXPECT_EQ(grey(300), Vec3(1, 1, 1));
  EXPECT_EQ(grey(999), Vec3(1, 1, 1));
  // Positions in the window are proportional to the sRGB code: its linear light by the standard's
  // formula.
  for (double value = 100; value < 300; value += 0.37) {
    const double share = (value - 100) / 200;
    EXPECT_NEAR(grey(value).x, share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4), 1e-6);
  }
  layer.window = {.lo = 5, .hi = 5};
  EXPECT_EQ(grey(4), Vec3(0, 0, 0));
  EXPECT_EQ(grey(5), Vec3(1, 1, 1));
  EXPECT_EQ(grey(6), Vec3(1, 1, 1));
}

TEST(Power, is_right_within_its_bound) {
  double largest_absolute = 0;
  for (const float exponent : {0.5F, 1.0F, 2.4F, 10.0F, 40.0F, 1000.0F})
    for (int i = 1; i <= 100'000; ++i) {
      const float base = static_cast<float>(i) / 100'000;
      const double expected = std::pow(double{base}, double{exponent}), got = render::power(base, exponent);
      if (expected < std::exp2(-99)) {
        EXPECT_LT(got, std::exp2(-98)) << base << " ^ " << exponent;
        continue;
      }
      EXPECT_LE(std::abs(got - expected), 4e-7 * (1 - std::log2(expected)) * expected) << base << " ^ " << exponent;
      largest_absolute = std::max(largest_absolute, std::abs(got - expected));
    }
  EXPECT_LT(largest_absolute, 6e-7);
  for (const float exponent : {0.5F, 40.0F}) {
    EXPECT_EQ(render::power(1, exponent), 1);
    EXPECT_LT(render::power(0, exponent), exponent < 1 ? 1e-18F : 1e-30F);
  }
}

/// Numbers in [0, 1], including the nearest ones to 1, in whole groups.
std::vector<render::Lanes> bases_of_powers() {
  std::vector<float> numbers{0, 1, std::numeric_limits<float>::denorm_min(), 1e-30F};
  for (int i = 0; i < 20'000; ++i) numbers.push_back(static_cast<float>(i) / 20'000);
  for (int i = 1; i < 2'000; ++i) numbers.push_back(1 - static_cast<float>(i * i) * 0x1p-24F);
  numbers.resize((numbers.size() + group_size - 1) / group_size * group_size, 0.99F);
  std::vector<render::Lanes> groups(numbers.size() / group_size);
  for (std::size_t i = 0; i < numbers.size(); ++i) groups[i / group_size][i % group_size] = numbers[i];
  return groups;
}

/// Largest errors of raise(), and of plain squaring in single precision.
struct PowerErrors {
  double raised = 0, squared = 0;
};

PowerErrors errors_of_powers(int exponent) {
  PowerErrors errors;
  render::Lanes powers;
  for (const render::Lanes& bases : bases_of_powers()) {
    render::raise(bases, exponent, powers);
    for (std::size_t i = 0; i < group_size; ++i) {
      long double exact = 1;
      float squared = 1;
      for (unsigned bit = std::bit_floor(static_cast<unsigned>(exponent)); bit > 0; bit >>= 1) {
        const bool is_set = (static_cast<unsigned>(exponent) & bit) != 0;
        exact *= exact * (is_set ? bases[i] : 1.0L);
        squared *= squared * (is_set ? bases[i] : 1.0F);
      }
      EXPECT_TRUE(powers[i] >= 0 && powers[i] <= 1) << bases[i] << " ^ " << exponent;
      errors.raised = std::max(errors.raised, static_cast<double>(std::abs(powers[i] - exact)));
      errors.squared = std::max(errors.squared, static_cast<double>(std::abs(squared - exact)));
    }
  }
  return errors;
}

// Five roundings of 2^-24. Only the last squarings, of numbers no longer near 1, round by as much.
// What they are added to is not doubled, as it is in x^2. Over all floats above 1/4 and all
// exponents up to 1024 the largest error is 2.5e-7.
TEST(Power, of_a_whole_exponent_is_right_to_five_roundings_however_large_it_is) {
  double largest_squared = 0;
  for (int exponent = 1; exponent <= 1024; exponent += exponent < 64 ? 1 : 37) {
    ASSERT_EQ(render::short_whole_exponent(exponent), static_cast<unsigned>(exponent));
    const PowerErrors errors = errors_of_powers(exponent);
    EXPECT_LT(errors.raised, 5 * 0x1p-24) << exponent;
    largest_squared = std::max(largest_squared, errors.squared);
  }
  EXPECT_GT(errors_of_powers(40).squared, 0x1p-21) << "squares do no worse: is this still worth it?";
  EXPECT_GT(largest_squared, 1e-5);
}

TEST(Power, of_nothing_is_nothing_and_of_all_is_all_where_the_exponent_is_whole) {
  render::Lanes bases, powers;
  for (std::size_t i = 0; i < group_size; ++i) bases[i] = i % 2 == 0 ? 0 : 1;
  for (const int exponent : {1, 2, 3, 40, 255, 1000, 1024}) {
    render::raise(bases, exponent, powers);
    for (std::size_t i = 0; i < group_size; ++i) EXPECT_EQ(powers[i], bases[i]) << exponent;
  }
}

TEST(Power, of_other_exponents_is_the_one_of_single_numbers) {
  render::Lanes bases, powers;
  for (std::size_t i = 0; i < group_size; ++i) bases[i] = static_cast<float>(i) / (group_size - 1);
  for (const double exponent : {0.5, 1.5, 39.999, 1025.0, 1e4}) {
    EXPECT_EQ(render::short_whole_exponent(exponent), 0U);
    render::raise(bases, exponent, powers);
    for (std::size_t i = 0; i < group_size; ++i)
      EXPECT_EQ(powers[i], render::power(bases[i], static_cast<float>(exponent))) << exponent;
  }
  for (const double exponent : {0.0, -2.0, 1e300, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(render::short_whole_exponent(exponent), 0U) << exponent;
}

}  // namespace
}  // namespace rhoray::tests
