#include "preprocess/grid/resample/neighborhood.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rhoray::preprocess {

void Neighborhood::gather(const TouchedBricks& touched, const Index3& brick, const BrickValues& values) {
  constexpr auto brick_samples = static_cast<std::size_t>(SampleLattice::brick_samples);
  std::visit(
      [&]<class T>(const Array<T>& all) {
        for (std::size_t side = 0; side < 8; ++side) {
          const bool x = (side & 1) != 0, y = (side & 2) != 0, z = (side & 4) != 0;
          const std::uint32_t slot = touched.slot(brick + Index3(x, y, z));
          const T* from = slot == TouchedBricks::none ? nullptr : all.data() + slot * brick_samples;
          for (std::size_t k = 0; k < (z ? 1 : edge); ++k)
            for (std::size_t j = 0; j < (y ? 1 : edge); ++j) {
              double* to = values_.data() + ((k + z * edge) * wide + j + y * edge) * wide + x * edge;
              const std::size_t count = x ? 1 : edge;
              if (from == nullptr)
                std::fill_n(to, count, std::numeric_limits<double>::quiet_NaN());
              else
                std::copy_n(from + place(0, j, k), count, to);
            }
        }
      },
      values);
  // A sum of all samples is not NaN only where all have data.
  std::array<double, wide> sums{};
  for (std::size_t row = 0; row < values_.size(); row += wide)
    for (std::size_t i = 0; i < wide; ++i) sums[i] += values_[row + i];
  double all = 0;
  for (const double sum : sums) all += sum;
  if (!std::isnan(all)) {
    covered_.set();
    return;
  }
  for (std::size_t k = 0; k < edge; ++k)
    for (std::size_t j = 0; j < edge; ++j)
      for (std::size_t i = 0; i < edge; ++i) {
        const std::array<double, 8> c = corners(i, j, k);
        const double sum = ((c[0] + c[1]) + (c[2] + c[3])) + ((c[4] + c[5]) + (c[6] + c[7]));
        covered_[place(i, j, k)] = !std::isnan(sum);
      }
}

}  // namespace rhoray::preprocess
