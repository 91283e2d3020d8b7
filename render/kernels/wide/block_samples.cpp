#include "render/kernels/wide/block_samples.h"

namespace rhoray::render::wide {

SampleSource::SampleSource(const void* first, const formats::AxisTables& tables, const Index3& sample_count)
    : samples(first),
      address{tables.x.data(), tables.y.data(), tables.z.data()},
      count{static_cast<int>(sample_count.x), static_cast<int>(sample_count.y), static_cast<int>(sample_count.z)},
      has_whole_rows(true) {
  for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(sample_count.x); ++i)
    if (i % 4 != 3 && tables.x[i + 1] != tables.x[i] + 1) has_whole_rows = false;
}

}  // namespace rhoray::render::wide
