#include "tools/analysis/effect_costs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace rhoray::tests {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> names(const render::ResolvedScene& plan) {
  std::vector<std::string> names;
  for (const tools::WithoutEffect& without : tools::without_each_effect(plan)) names.emplace_back(without.effect);
  return names;
}

/// One layer, lit from the camera.
render::ResolvedScene plain() {
  render::ResolvedScene plan;
  plan.scene.layers[0].material.specular = 0;
  return plan;
}

render::ResolvedScene with_all_effects() {
  render::ResolvedScene plan = plain();
  plan.frame.antialiasing = 4;
  plan.scene.layers.resize(3, plan.scene.layers[0]);
  render::Material& clear = plan.scene.layers[1].material;
  clear.opacity = 0.5, clear.specular = 0.25, clear.normals = render::Normals::smooth;
  clear.color_by.emplace().field = "x";
  plan.scene.layers[2].mode = render::Mode::slice;
  plan.scene.layers[2].material.lit = false;
  plan.scene.layers[2].material.color_by.emplace().field = "x";
  plan.scene.lights[0] = {.kind = render::Light::Kind::directional, .place = {0, 0, 1}, .casts_shadows = true};
  plan.scene.occlusion.radius = 1;
  plan.scene.fog = render::Fog{.range = {1, 2}};
  plan.scene.clip = render::Clip{.box = Box3({0, 0, 0}, {1, 1, 1})};
  return plan;
}

TEST(EffectCosts, a_plain_scene_has_no_effect_to_leave_out) {
  EXPECT_THAT(names(plain()), IsEmpty());
}

TEST(EffectCosts, each_effect_is_left_out_alone) {
  const render::ResolvedScene plan = with_all_effects();
  const std::vector<std::string> all = names(plan);
  EXPECT_THAT(all, ElementsAre("antialiasing", "shadows", "ambient occlusion", "transparency", "clipping",
                               "smooth normals", "colour by field", "specular", "fog"));
  for (const tools::WithoutEffect& without : tools::without_each_effect(plan)) {
    std::vector<std::string> others = all;
    std::erase(others, std::string(without.effect));
    EXPECT_EQ(names(without.plan), others) << without.effect;
    EXPECT_TRUE(without.plan.scene.layers[2].material.color_by) << "a slice shows nothing but colours";
  }
}

TEST(EffectTimes, are_differences_of_the_smaller_of_two_times) {
  render::ResolvedScene plan = plain();
  plan.frame.antialiasing = 4;
  plan.scene.fog = render::Fog{.range = {1, 2}};
  tools::EffectTimes times(plan);
  // The whole picture, without antialiasing, without fog, and again.
  for (const double ms : {10.0, 7.0, 9.5, 12.0, 6.0, 11.0}) {
    EXPECT_FALSE(times.is_done());
    times.took(ms);
  }
  EXPECT_TRUE(times.is_done());
  EXPECT_EQ(times.whole_ms(), 10);
  const auto costs = times.costs();
  ASSERT_EQ(costs.size(), 2U);
  EXPECT_EQ(costs[0].effect, "antialiasing");
  EXPECT_EQ(costs[0].ms, 4);
  EXPECT_EQ(costs[1].effect, "fog");
  EXPECT_EQ(costs[1].ms, 0.5);
}

}  // namespace
}  // namespace rhoray::tests
