// Watertightness. Rays of all sorts, above all at edges and vertices, at closed isosurfaces of
// every size and position: none slips through, and none hits what is not there. A million rays; the
// environment variable RHORAY_WATERTIGHT_RAYS sets a larger number (tests/nightly).
#include <gtest/gtest.h>

#include <iostream>
#include <mutex>
#include <vector>

#include "formats/base/parallel.h"
#include "formats/base/text.h"
#include "render/query/machine.h"
#include "tests/hard_cases/watertight_tally.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/asked_count.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {
namespace {

constexpr std::uint64_t chunk = 1024;         ///< rays of one seed
constexpr std::uint64_t thorough_every = 7;   ///< in chunks; thorough runs take ten times as long
constexpr std::uint64_t sample_every = 1000;  ///< 100,000 of the nightly rays

/// A box of size 1e-6 around 148376 1234 -223423 is 34,000 neighbouring doubles wide, 2,900 of them
/// per cell.
std::vector<study::Placement> placements() {
  std::vector<study::Placement> all;
  for (const Vec3& centre : {Vec3(0), Vec3(1e3), Vec3(1e5), Vec3(148376, 1234, -223423)})
    for (const double scale : {1e-6, 1.0, 1e6}) all.push_back({centre, scale});
  return all;
}

void print(const WatertightTally& tally) {
  std::cout << tally.rays << " rays, " << tally.redecided << " decided again\n";
  const auto print_method = [](const char* name, const WatertightTally::OfMethod& of) {
    std::cout << name << ": hits " << of.hits << ", crossings " << of.crossings << ", wide " << of.wide << ", odd "
              << of.parity << ", other " << of.other << ", of these ties " << of.ties << ", wrong " << of.wrong
              << ", met past " << of.met_past << "\n";
  };
  for (std::size_t m = 0; m < WatertightTally::method_count; ++m)
    print_method(WatertightTally::name(m), tally.of_method[m]);
  std::cout << "all crossings of " << tally.all.rays << " rays\n";
  print_method("all crossings", tally.all);
}

TEST(Watertight, no_ray_slips_through_a_closed_surface_and_none_meets_what_it_passes) {
  const std::size_t parts = study::scene_kinds.size() * placements().size() * study::aims.size();
  const std::uint64_t ray_count = asked_count("RHORAY_WATERTIGHT_RAYS", 1'000'000);
  const std::uint64_t chunks = (ray_count + parts * chunk - 1) / (parts * chunk);
  const TemporaryFolder folder;
  WatertightTally whole;
  std::mutex adding;
  std::uint64_t seed = 1;
  for (const study::SceneKind kind : study::scene_kinds)
    for (const study::Placement& placement : placements()) {
      const study::ClosedScene scene = closed_scene(kind, placement, 12, folder.path());
      for (const study::Aim aim : study::aims) {
        const std::uint64_t first = seed++ << 32;
        parallel_for_each(chunks, [&](std::uint64_t c) {
          WatertightTally part = tally_watertight(scene, aim, chunk, first + c, c % thorough_every == 0, sample_every);
          for (std::string& complaint : part.complaints)
            complaint = concat(name_of(kind), " of size ", placement.scale, " around x = ", placement.centre.x,
                               ", aimed at ", name_of(aim), ", seed ", first + c, ": ", complaint);
          const std::scoped_lock lock(adding);
          whole.add(part);
        });
      }
    }
  print(whole);
  for (const std::string& complaint : whole.complaints) ADD_FAILURE() << complaint;
  EXPECT_GE(whole.rays, ray_count);
  for (std::size_t m = 0; m < WatertightTally::method_count; ++m) {
    const WatertightTally::OfMethod& of = whole.of_method[m];
    EXPECT_EQ(of.wrong, 0U) << WatertightTally::name(m);
    EXPECT_EQ(of.met_past, 0U) << WatertightTally::name(m);
    EXPECT_GT(of.hits, of.rays / 2) << WatertightTally::name(m);
    EXPECT_LT(of.ties, of.rays / 50) << WatertightTally::name(m) << ": too much is excused";
  }
  EXPECT_GT(whole.of_method[2].other, whole.of_method[2].rays / 2000)
      << "double precision is right too: are these rays still hard?";
  if (render::chosen_machine() != render::Machine::scalar) {
    EXPECT_GT(whole.of_method[0].wide, whole.rays / 2);
    EXPECT_GT(whole.of_method[1].wide, whole.rays / 2);
    // All but the eighth that goes past the surface, and up to a hundredth that is left to other
    // kernels.
    EXPECT_GT(whole.all.rays, whole.rays - whole.rays / 8 - whole.rays / 100);
  }
  EXPECT_EQ(whole.all.wrong, 0U);
  EXPECT_EQ(whole.all.parity, 0U) << "even ties must leave the ray on the right side";
}

// These two rays lie in a facet, from one of its corners to another, to within rounding. They were
// said to cross the surface once.
TEST(Watertight, a_ray_in_a_facet_is_not_said_to_stay_inside) {
  struct Case {
    study::Placement placement;
    render::Ray ray;
  };
  const Case cases[] = {{{Vec3(0), 1e-6},
                         {.origin = {-0x1.5b9e6efd4533fp-19, -0x1.4a1e2c3f3ba33p-19, -0x1.9404e193ee124p-22},
                          .direction = {0x1.66d24099d695dp-1, 0x1.6cc1a4ca12a43p-1, 0x1.28c4bc861db48p-5}}},
                        {{Vec3(1e3), 1e6},
                         {.origin = {-0x1.0a570b8b0720ep+21, -0x1.058a65bf611c1p+21, -0x1.a9201cbfa4fd9p+20},
                          .direction = {0x1.2a577957a4772p-1, 0x1.25428dcf446b7p-1, 0x1.272fa2a3b1442p-1}}}};
  const TemporaryFolder folder;
  for (const auto& [placement, ray] : cases) {
    const study::ClosedScene scene = closed_scene(study::SceneKind::tets_whole, placement, 12, folder.path());
    for (const render::Machine machine : wide_machines()) {
      render::Scratch scratch;
      const std::vector<AllCrossings> found = all_crossings(scene, {&ray, 1}, machine, scratch);
      ASSERT_EQ(found.size(), 1U) << name_of(machine);
      EXPECT_TRUE(!found[0].is_complete || found[0].t.size() % 2 == 0) << name_of(machine) << ": " << found[0].t.size();
    }
  }
}

}  // namespace
}  // namespace rhoray::tests
