#pragma once

#include <cstdlib>
#include <random>
#include <string>

#include "preprocess/pack_mesh.h"
#include "render/document.h"
#include "tests/agreement/pictures.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"
#include "tools/view/viewed_scene.h"

namespace rhoray::tests {

/// A mesh of a box whose field is the distance from a corner, shown by one layer: an isosurface, or
/// the boundary with feature edges. Its second field is the x coordinate.
inline tools::ViewedScene viewed_box(const TemporaryFolder& folder,
                                     render::LayerType type = render::LayerType::isosurface) {
  preprocess::NeutralMesh mesh = box_mesh({.cells = {8, 8, 8}});
  add_point_field(mesh, "distance", [](const Vec3& p) { return p.length(); });
  add_point_field(mesh, "x", [](const Vec3& p) { return p.x; });
  const render::Dataset dataset = packed(folder, "box.rho", mesh);
  render::SceneSpec scene_spec{.data = {{.name = "data", .file = folder / "box.rho"}}, .layers = {{.type = type}}};
  if (type == render::LayerType::isosurface)
    scene_spec.layers[0].isovalues = {"0.8"};
  else
    scene_spec.layers[0].feature_edges = 30;
  tools::ViewedScene viewed{.title = "box", .program = "rhoray test", .scene_spec = scene_spec};
  viewed.resolve = [dataset](const render::SceneSpec& changed) {
    return render::resolve_layers(changed, [&](const render::DataSpec& data, formats::Space world) {
      return data.field.empty() || data.field == dataset.field().name
                 ? dataset
                 : render::Dataset::load(data.file, data.field, world);
    });
  };
  viewed.plan = viewed.resolve(scene_spec);
  aim_camera(scene_spec, viewed.plan);
  viewed.command_of = [](const render::ResolvedScene& plan) { return concat("iso ", plan.scene.layers[0].isovalue); };
  viewed.texts_of = [command_of = viewed.command_of](const render::ResolvedScene& plan, std::string_view machine) {
    return std::vector<tools::PictureText>{{"rhoray:command", command_of(plan)},
                                           {"rhoray:machine", std::string(machine)}};
  };
  return viewed;
}

/// The number of malformed messages that a test sends; RHORAY_VIEW_MESSAGES, for runs that take
/// hours.
inline int message_count(int usual) {
  const char* const asked = std::getenv("RHORAY_VIEW_MESSAGES");
  return asked == nullptr ? usual : std::stoi(asked);
}

/// A message with some letters changed, left out or repeated.
inline std::string mutated(std::string text, std::mt19937_64& random) {
  for (int change = static_cast<int>(random() % 4); change >= 0; --change) {
    const std::size_t at = random() % text.size();
    if (random() % 3 == 0)
      text.erase(at, random() % 8);
    else if (random() % 2 == 0)
      text[at] = static_cast<char>(random() % 128);
    else
      text.insert(at, text.substr(random() % text.size(), random() % 20));
    if (text.empty()) text = "{";
  }
  return text;
}

}  // namespace rhoray::tests
