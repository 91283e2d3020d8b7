// R05, D13. A constant volume whose value is the isovalue: all of it is inside, and no surface lies
// in it or at its border. A rule that treats the exterior of the data as below the isovalue draws
// the bounding box.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support/rays.h"
#include "tests/render/support/traced_dataset.h"
#include "tests/support/fields.h"

namespace rhoray::tests {
namespace {

template <class T>
void expect_nothing(int& boxes_of_the_naive) {
  TracedDataset traced(volume_of<T>({7, 6, 5}, [](const Index3&) { return T{7}; }));
  for (const double isovalue : {7.0, std::nextafter(7.0, 0.0), std::nextafter(7.0, 8.0), 0.0, 8.0})
    for (const render::Method::Algorithm algorithm :
         {render::Method::Algorithm::preview, render::Method::Algorithm::direct, render::Method::Algorithm::certified,
          render::Method::Algorithm::exact})
      for (const render::Ray& ray : stressful_rays({6, 5, 4}, 200, 1)) {
        EXPECT_TRUE(traced.first_crossing(ray, isovalue, {.algorithm = algorithm}).is_miss()) << isovalue;
        boxes_of_the_naive += isovalue <= 7 && !traced.largest_value(ray).is_miss();
      }
}

TEST(ConstantVolumes, have_no_surface_at_any_isovalue) {
  int boxes_of_the_naive = 0;
  expect_nothing<std::uint8_t>(boxes_of_the_naive);
  expect_nothing<float>(boxes_of_the_naive);
  expect_nothing<double>(boxes_of_the_naive);
  EXPECT_GT(boxes_of_the_naive, 1000) << "no ray meets the box: is this case still the hard one?";
}

}  // namespace
}  // namespace rhoray::tests
