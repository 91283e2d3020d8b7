// Shows which of the instruction sets that kernels are compiled for are covered by this run of the
// tests. Tests of wide kernels use wide_machines(), which omits those that the processor lacks;
// here an omitted one shows as a skipped test.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/render/support/bundles.h"
#include "tests/render/support/crossings.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/render/support/wide_machines.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

using render::Hit;
using render::Machine;
using render::Method;
using render::Ray;

class InstructionSets : public testing::TestWithParam<Machine> {};

TEST_P(InstructionSets, answer_as_the_reference_does) {
  if (!render::has_machine(GetParam()))
    GTEST_SKIP() << "this processor lacks " << name_of(GetParam()) << ": no kernel for it is tested here";
  TracedDataset traced(sampled_volume<float>({25, 22, 27}, {}, distance_field({12, 10, 13})));
  const std::vector<Ray> rays = bundles({24, 21, 26}, 500, 31);
  const Method single = render::method_of(render::Accuracy::float32);
  const std::vector<Hit> reference = answers(traced, Method{}, Machine::scalar, rays, 8);
  const std::vector<Hit> found = answers(traced, single, GetParam(), rays, 8);
  std::size_t hits = 0;
  for (std::size_t r = 0; r < rays.size(); ++r) {
    ASSERT_EQ(found[r].is_miss(), reference[r].is_miss()) << r;
    if (reference[r].is_miss()) continue;
    ++hits;
    EXPECT_NEAR(found[r].t, reference[r].t, 1e-3) << r;
  }
  EXPECT_GT(hits, 50U);
}

INSTANTIATE_TEST_SUITE_P(Of, InstructionSets,
                         testing::Values(Machine::scalar, Machine::baseline, Machine::avx2, Machine::avx512),
                         [](const auto& of) { return std::string(name_of(of.param)); });

TEST(WideMachines, are_the_machines_whose_instruction_sets_are_not_skipped) {
  const std::vector<Machine> machines = wide_machines();
  for (const Machine machine : {Machine::baseline, Machine::avx2, Machine::avx512})
    EXPECT_EQ(std::count(machines.begin(), machines.end(), machine), render::has_machine(machine)) << name_of(machine);
}

}  // namespace
}  // namespace rhoray::tests
