#include "tools/rhoray/bench/views.h"

#include <gmock/gmock.h>

#include "formats/base/error.h"
#include "preprocess/pack_volume.h"
#include "render/render.h"
#include "tests/tools/lab/small_grid.h"
#include "tools/analysis/cpu_meter.h"

namespace rhoray::tests {
namespace {

using tools::StudyView;

TEST(StudyViews, show_the_surface_whole_close_up_and_from_within) {
  const TemporaryFolder folder;
  preprocess::pack_volume(ball_grid(24), folder / "ball.rho");
  const render::Dataset dataset = render::Dataset::load(folder / "ball.rho");
  const auto covered = [&](StudyView view, double isovalue) {
    render::Scene scene;
    scene.layers[0].isovalue = isovalue;
    scene.camera = tools::study_camera(view, dataset, isovalue, 1);
    render::Framebuffer picture;
    return static_cast<double>(render::render(dataset, scene, {.width = 40, .height = 40}, picture).hits) / 1600;
  };
  for (const StudyView whole : {StudyView::front, StudyView::from_feet}) {
    EXPECT_GT(covered(whole, 200), 0.1);  // a ball with a radius of 8 samples in 24
    EXPECT_LT(covered(whole, 200), 0.5);
  }
  EXPECT_GT(covered(StudyView::close_up, 200), 0.8);
  EXPECT_EQ(covered(StudyView::inside, 200), 1);
  // If the centre ray of the front view misses the surface, the close view shows the data's box.
  EXPECT_EQ(covered(StudyView::close_up, 2000), 0);
}

TEST(StudyViews, are_known_by_name) {
  for (const StudyView view : tools::study_views) EXPECT_EQ(tools::study_view_named(tools::name_of(view)), view);
  EXPECT_THROW(tools::study_view_named("feet"), Error);
}

TEST(CpuMeter, measures_what_is_done_and_a_plausible_frequency) {
  const double frequency = tools::core_frequency_hz();
  EXPECT_GT(frequency, 2e8);
  EXPECT_LT(frequency, 2e10);
  tools::CpuMeter meter;
  double sum = 0;
  const tools::Cost cost = meter.measure([&] {
    for (int i = 1; i < 5'000'000; ++i) sum += 1.0 / i;
  });
  EXPECT_GT(sum, 15);
  EXPECT_GT(cost.cpu_s, 1e-4);
  EXPECT_LT(cost.cpu_s, 60);
  EXPECT_EQ(cost.instructions.has_value(), meter.counts_instructions());
  if (cost.instructions) {
    EXPECT_GT(*cost.instructions, 5e6);
  }
}

}  // namespace
}  // namespace rhoray::tests
