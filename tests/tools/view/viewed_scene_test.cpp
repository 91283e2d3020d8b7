#include "tools/view/viewed_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "formats/base/json.h"
#include "render/method_words.h"
#include "render/render.h"
#include "tests/support/expect_error.h"
#include "tests/tools/view/viewed.h"

namespace rhoray::tests {
namespace {

using namespace tools;

render::Framebuffer picture_of(const ViewedScene& viewed, const ChangedScene& scene) {
  const render::ResolvedScene plan = with_request(viewed, scene, {.width = 60, .height = 40});
  render::Framebuffer picture;
  render::render(plan.datasets, plan.scene, plan.frame, picture);
  return picture;
}

TEST(ChangedScene, of_a_patch_that_changes_nothing_draws_the_same_picture) {
  for (const render::LayerType type : {render::LayerType::isosurface, render::LayerType::boundary}) {
    const TemporaryFolder folder;
    const ViewedScene viewed = viewed_box(folder, type);
    const std::string document = document_to_change(viewed);
    EXPECT_EQ(picture_of(viewed, changed_scene(viewed, document, R"({"style": "default"})")).color,
              picture_of(viewed, changed_scene(viewed, document, "")).color);
  }
}

TEST(ChangedScene, numbers_its_layers_as_the_document_does) {
  const TemporaryFolder folder, other_folder;
  ViewedScene two_isovalues = viewed_box(folder), with_boundary = viewed_box(other_folder);
  two_isovalues.scene_spec.layers[0].isovalues = {"0.5", "0.8"};
  with_boundary.scene_spec.layers[0].context = 0.25;  // the boundary's opacity
  // One layer is asked for, two are drawn.
  for (ViewedScene* const viewed : {&two_isovalues, &with_boundary}) {
    viewed->plan = viewed->resolve(viewed->scene_spec);
    aim_camera(viewed->scene_spec, viewed->plan);
    const std::string document = document_to_change(*viewed);
    ASSERT_EQ(Json::parse(document)["layers"].size(), 2U);
    for (const std::string patch : {"", R"({"style": "paper"})"})
      EXPECT_EQ(changed_scene(*viewed, document, patch).layer_numbers, (std::vector<std::size_t>{0, 1})) << patch;
    const std::string without_first = R"({"layers": {"0": {"visible": false}}})";
    EXPECT_EQ(changed_scene(*viewed, document, without_first).layer_numbers, std::vector<std::size_t>{1});
  }
}

TEST(ChangedScene, takes_every_method_and_accuracy_that_hello_names) {
  const TemporaryFolder folder;
  const ViewedScene viewed = viewed_box(folder);
  const std::string document = document_to_change(viewed);
  const Json hello = Json::parse(hello_text(viewed, document))["hello"];
  std::set<std::string> methods;
  for (const char* type : {"isosurface", "mip"})
    for (const Json& word : hello["data"]["data"]["methods"][type]) {
      Json layer{{"type", type}, {"data", "data"}, {"method", word}};
      if (type == std::string("isosurface")) layer["isovalue"] = 0.5;
      const ChangedScene scene = changed_scene(viewed, document, dump(Json{{"layers", {{"1", layer}}}}));
      const render::Method method = scene.plan.scene.layers[1].method;
      for (const Json& level : hello["words"]["accuracy"])
        EXPECT_FALSE(method == render::method_of(render::accuracy_named(level.get<std::string>()))) << word;
      methods.insert(word.get<std::string>());
    }
  EXPECT_THAT(methods, testing::ElementsAre("face", "paper", "sampled:0.5", "slack:1e-6"));
}

TEST(ChangedScene, draws_what_the_same_scene_draws_when_it_is_asked_for) {
  const TemporaryFolder folder;
  const ViewedScene viewed = viewed_box(folder);
  const auto changed = [&](const std::string& patch) {
    return picture_of(viewed, changed_scene(viewed, document_to_change(viewed), patch));
  };
  const auto asked = [&](const std::function<void(render::SceneSpec&)>& change) {
    ViewedScene other = viewed;
    change(other.scene_spec);
    other.plan = other.resolve(other.scene_spec);
    other.plan.scene.camera = viewed.plan.scene.camera;
    return picture_of(other, changed_scene(other, {}, ""));
  };
  const auto before = changed("");
  const auto expect_same = [&](const std::string& patch, const std::function<void(render::SceneSpec&)>& change) {
    EXPECT_EQ(changed(patch).color, asked(change).color) << patch;
    EXPECT_NE(changed(patch).color, before.color) << patch;
  };
  expect_same(R"({"layers": {"0": {"isovalue": 0.5}}})", [](auto& spec) { spec.layers[0].isovalues = {"0.5"}; });
  expect_same(R"({"style": "presentation"})", [](auto& spec) { spec.style = "presentation"; });
  expect_same(R"({"layers": {"0": {"color_by": "x", "colormap": "magma"}}})", [](auto& spec) {
    spec.layers[0].color_by = "x";
    spec.layers[0].colormap = "magma";
  });
  expect_same(R"({"data": {"data": {"field": "x"}}, "layers": {"0": {"isovalue": 0.25}}})", [](auto& spec) {
    spec.data[0].field = "x";
    spec.layers[0].isovalues = {"0.25"};
  });
  expect_same(R"({"clip": {"planes": [{"point": [0.5, 0, 0], "normal": [1, 0, 0]}]}})", [](auto& spec) {
    spec.clip = render::ClipSpec{};
    spec.clip->planes.push_back({.point = {0.5, 0, 0}, .normal = {1, 0, 0}});
  });
  expect_same(R"({"layers": {"1": {"type": "slice", "axis": "x"}}})", [](auto& spec) {
    spec.layers.push_back({.type = render::LayerType::slice, .data = "data"});
    spec.layers[1].axis = "x";
  });
}

TEST(ChangedScene, refuses_what_no_client_may_choose) {
  const TemporaryFolder folder;
  const ViewedScene viewed = viewed_box(folder);
  const std::string document = document_to_change(viewed);
  for (const char* patch :
       {R"({"data": {"data": {"file": "/etc/passwd"}}})",
        R"({"data": {"other": {"field": "x"}}})",
        R"({"data": {"other": {"file": "/etc/passwd"}}})",
        R"({"data": null})",
        R"({"data": {"data": null}})",
        R"({"camera": {"view": "front"}})",
        R"({"image": {"size": [60000, 60000]}})",
        R"({"image": {"channels": ["depth"]}})",
        R"({"image": {"frames": 5}})",
        R"({"image": 5})",
        R"({"layers": []})",
        R"({"layers": null})",
        R"({"layers": {"0": null}})",
        R"({"layers": {"x": {}}})",
        R"({"layers": {"-1": {}}})",
        R"({"layers": {"00": {"opacity": 0.5}}})",
        R"({"layers": {"2": {"type": "mip"}}})",
        R"({"layers": {"1": 5}})",
        R"({"layers": {"1": {"type": "volume"}}})",
        R"({"layers": {"0": {"data": "../other"}}})",
        R"({"layers": {"0": {"isovalue": "high"}}})",
        R"({"layers": {"0": {"isovalue": 99}}})",
        R"({"layers": {"0": {"texture": "/etc/passwd"}}})",
        R"({"layers": {"0": {"colour": "red"}}})",
        R"({"style": "nice"})",
        R"({"space": "lps"})",
        R"({"effects": {"ambient_occlusion": {"samples": 65}}})",
        R"({"lights": [{"type": "directional", "direction": [0, 0, 1], "angular_diameter": 5, "samples": 4096}]})",
        R"({"image": {"antialias": 65}})",
        R"({"$schema": "https://evil.com"})"})
    expect_error(ErrorCode::invalid, "", [&] { changed_scene(viewed, document, patch); });
}

TEST(ChangedScene, of_random_changes_of_a_patch_is_resolved_or_refused) {
  const TemporaryFolder folder;
  const ViewedScene viewed = viewed_box(folder);
  const std::string document = document_to_change(viewed);
  const std::string seeds[] = {
      R"({"layers": {"0": {"isovalue": 0.5, "opacity": 0.5, "color": "#102030"}, "1": {"type": "slice", "axis": "x"}}})",
      R"({"style": "fast", "accuracy": "exact", "clip": {"planes": [{"point": [0, 0, 0], "normal": [1, 0, 0]}]}})",
      R"({"data": {"data": {"field": "x"}}, "layers": {"0": {"isovalue": "p50", "color_by": "x", "range": [0, 1]}}})",
      R"({"effects": {"ambient_occlusion": {"samples": 4}}, "image": {"show": "cost", "antialias": 2}})"};
  std::mt19937_64 random(20261127);
  int resolved = 0;
  for (int round = message_count(4000); round > 0; --round) {
    const std::string request =
        concat(R"({"n": 1, "size": [9, 9], "scene": )", mutated(seeds[random() % 4], random), "}");
    try {
      const auto message = std::get<PictureRequest>(parse_client_message(request));
      const ChangedScene scene = changed_scene(viewed, document, message.patch);
      with_request(viewed, scene, message);
      ++resolved;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::invalid) << request << "\n" << error.what();
    }
  }
  EXPECT_GT(resolved, 20);
}

TEST(ChangedScene, keeps_what_a_patch_does_not_name) {
  const TemporaryFolder folder;
  const ViewedScene viewed = viewed_box(folder);
  const Json document = Json::parse(document_to_change(viewed));
  EXPECT_FALSE(document.contains("camera"));
  EXPECT_FALSE(document["layers"]["0"].contains("ambient")) << "the style's";
  const ChangedScene scene = changed_scene(viewed, dump(document),
                                           R"({"layers": {"2": {"type": "isosurface", "isovalue": 0.4},)"
                                           R"( "1": {"type": "isosurface", "isovalue": 0.3}}})");
  ASSERT_EQ(scene.plan.scene.layers.size(), 3U);
  EXPECT_EQ(scene.plan.scene.layers[0].isovalue, 0.8);
  EXPECT_EQ(scene.plan.scene.layers[1].isovalue, 0.3);
  EXPECT_EQ(scene.plan.scene.layers[2].isovalue, 0.4);
}

}  // namespace
}  // namespace rhoray::tests
