// Fuzzes scene documents. They are read, written and read again, planned with the packed files of
// tests/formats/released, and rendered at a very small size.
#include <unistd.h>

#include <algorithm>
#include <string>

#include "formats/base/checks.h"
#include "render/document.h"
#include "render/render.h"
#include "render/sweep.h"
#include "tests/fuzz/harness.h"
#include "tools/rhoray/data_choice.h"

namespace {

using namespace rhoray;
using namespace rhoray::tools;

/// Checks that a written document can be read again and is the same.
void check_written(const render::SceneSpec& scene_spec) {
  const std::string written = render::scene_text(scene_spec);
  RHORAY_CHECK(render::scene_text(render::read_scene(written).scene_spec) == written);
}

void draw(render::ResolvedScene& plan) {
  constexpr int most_samples = 2;
  plan.frame.width = std::min(plan.frame.width, 6);
  plan.frame.height = std::min(plan.frame.height, 6);
  plan.frame.antialiasing = std::min(plan.frame.antialiasing, most_samples);
  plan.frame.threads = 1;
  plan.scene.occlusion.samples = std::min(plan.scene.occlusion.samples, most_samples);
  for (render::Light& light : plan.scene.lights) light.samples = std::min(light.samples, most_samples);
  constexpr std::size_t most_shown = 8;
  if (plan.scene.layers.size() > most_shown) plan.scene.layers.resize(most_shown);
  render::Framebuffer framebuffer;
  render::render(plan.datasets, plan.scene, plan.frame, framebuffer);
}

void show(const render::SceneSpec& scene_spec) {
  render::ResolvedScene plan = resolve_layers(scene_spec);
  aim_camera(scene_spec, plan);
  RHORAY_CHECK(!render::explain(scene_spec, plan).antialiasing.empty());
  check_written(to_spec(plan));
  draw(plan);
}

void show_sweep(const render::SceneSpec& scene_spec) {
  render::Sweep sweep(scene_spec);
  const int last = sweep.frame_count() - 1;
  for (const int frame : {0, last / 2, last}) {
    const render::SceneSpec at = sweep.spec_at(sweep.time_of(frame));
    render::ResolvedScene plan = resolve_layers(at);
    sweep.plan_frame(frame, plan);
    draw(plan);
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  RHORAY_CHECK(::chdir(RHORAY_RELEASED_FILES) == 0);  // folder of the files that documents name
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos || text[begin] != '{') return 0;  // a file name, not a document
  try {
    const render::SceneDocument document = render::read_scene(text);
    check_written(document.scene_spec);
    if (document.scene_spec.camera.keyframes || document.scene_spec.image.frames)
      show_sweep(document.scene_spec);
    else
      show(document.scene_spec);
  } catch (const Error& error) {
    tests::check_refusal(error);
  }
  return 0;
}
