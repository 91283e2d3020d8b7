#include "render/triangles/array_pool.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <set>
#include <span>
#include <variant>
#include <vector>

#include "render/triangles/facets.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"

namespace rhoray::tests {
namespace {

using render::ArrayPool;
using render::PooledArray;

TEST(ArrayPool, gives_the_memory_of_dropped_arrays_to_new_ones_of_about_their_size) {
  const auto pool = std::make_shared<ArrayPool>();
  PooledArray<int> small(pool, 100), large(pool, 10'000);
  const int* const small_memory = small.data();
  const int* const large_memory = large.data();
  small = {}, large = {};
  const PooledArray<int> tiny(pool, 10);
  const PooledArray<double> fits_large(pool, 5500);
  const PooledArray<int> fits_small(pool, 105);
  EXPECT_NE(static_cast<const void*>(tiny.data()), small_memory);
  EXPECT_EQ(static_cast<const void*>(fits_large.data()), large_memory);
  EXPECT_EQ(fits_small.data(), small_memory);
}

TEST(ArrayPool, keeps_no_more_than_five_dropped_arrays) {
  const auto pool = std::make_shared<ArrayPool>();
  const std::byte* first = nullptr;
  {
    std::vector<PooledArray<std::byte>> arrays;
    for (int i = 0; i < 6; ++i) arrays.emplace_back(pool, 4096);
    first = arrays[0].data();
    for (PooledArray<std::byte>& array : arrays) array = {};
  }
  // The first to be dropped was released. What is kept is taken before anything is allocated.
  std::vector<PooledArray<std::byte>> arrays;
  for (int i = 0; i < 5; ++i) arrays.emplace_back(pool, 4096);
  for (const PooledArray<std::byte>& array : arrays) EXPECT_NE(array.data(), first);
}

TEST(ArrayPool, gives_the_facets_of_an_isovalue_the_memory_of_those_that_were_dropped) {
  const TracedDataset mesh(box_mesh({.cells = {9, 9, 9}}, [](const Vec3& p) { return p.x + 0.1 * p.y * p.z; }));
  const auto& view = std::get<render::TetData>(mesh.dataset().implementation().view);
  const Box3& bounds = mesh.dataset().implementation().bounds_data;
  render::FacetsCache cache;
  std::set<const void*> used;
  for (int i = 0; i < 20; ++i) {
    const double isovalue = 0.5 + 1e-3 * i;
    const auto facets = cache.of(view, bounds, isovalue, 1);
    used.insert({facets->blocks(), facets->fields()});
    const render::Facets fresh(view, bounds, isovalue, 1);
    ASSERT_EQ(facets->count(), fresh.count());
    EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(facets->fields(), facets->count())),
                                   std::as_bytes(std::span(fresh.fields(), fresh.count()))));
  }
  EXPECT_EQ(used.size(), 8U);  // two arrays of the last four; the next takes the memory of the oldest
}

}  // namespace
}  // namespace rhoray::tests
