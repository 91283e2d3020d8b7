// Clusters prepared for the search for the largest values. Included again for each machine.
#if defined(RHORAY_WIDE_TET_MAXIMUM_CLUSTER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_TET_MAXIMUM_CLUSTER_INL_H
#undef RHORAY_WIDE_TET_MAXIMUM_CLUSTER_INL_H
#else
#define RHORAY_WIDE_TET_MAXIMUM_CLUSTER_INL_H
#endif

#include <cmath>

#include "render/tets/largest/candidates-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {
namespace {

using Counts = hn::Rebind<std::uint32_t, Doubles>;
inline constexpr Counts counts{};

class TetClusters {
 public:
  HWY_INLINE TetClusters(const TetMaximumField& field, TetScratch& scratch) : field_(field), scratch_(scratch) {}

  HWY_INLINE const LocalCluster& made_ready(std::uint64_t cluster) {
    LocalCluster& local = scratch_.clusters[cluster % TetScratch::slot_count];
    if (local.cluster != cluster) make_ready(cluster, local);
    return local;
  }

 private:
  HWY_NOINLINE void make_ready(std::uint64_t cluster, LocalCluster& local) {
    local.cluster = cluster;
    const formats::BoxBlock& block = field_.boxes[0][cluster / formats::ClusterShape::width];
    const std::size_t entry = cluster % formats::ClusterShape::width;
    double half = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double low = block.lo[a][entry], high = block.hi[a][entry];
      local.center[a] = 0.5 * (low + high) * field_.box_unit;
      half = TetRays::larger(half, 0.5 * (high - low) * field_.box_unit);
    }
    int exponent;
    std::frexp(half, &exponent);
    local.scale = half > 0 ? std::ldexp(1.0, -exponent) : 1;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto at = [&](float x) { return (x * field_.box_unit - local.center[a]) * local.scale; };
      local.low[a] = static_cast<float>(at(block.lo[a][entry])) - 0x1p-23f;
      local.high[a] = static_cast<float>(at(block.hi[a][entry])) + 0x1p-23f;
    }
    if (field_.is_single)
      take_range<float>(cluster, local);
    else
      take_range<double>(cluster, local);
    const std::uint32_t* const table = field_.tables + field_.table_starts[cluster];
    local.vertex_count = static_cast<std::uint32_t>(field_.table_starts[cluster + 1] - field_.table_starts[cluster]);
    HWY_ALIGN std::uint32_t at[LocalCluster::capacity];
    HWY_ALIGN double value[LocalCluster::capacity];
    for (std::size_t i = 0; i < LocalCluster::capacity && (i < local.vertex_count || i % 16 != 0); ++i)
      at[i] = table[i < local.vertex_count ? i : 0];
    for (std::size_t i = 0; i < local.vertex_count; ++i)
      value[i] = field_.is_single ? static_cast<const float*>(field_.values)[at[i]]
                                  : static_cast<const double*>(field_.values)[at[i]];
    for (std::size_t i = 0; i < local.vertex_count; i += double_lanes) {
      const hn::Vec<Longs> index = to_longs(hn::Load(counts, at + i));
      const hn::Vec<Longs> place = hn::Add(index, hn::Add(index, index));
      for (std::size_t a = 0; a < 3; ++a) {
        const VecD x = hn::GatherIndex(doubles, field_.points + a, place);
        const VecD moved = hn::Mul(hn::Sub(x, hn::Set(doubles, local.center[a])), hn::Set(doubles, local.scale));
        hn::Store(hn::DemoteTo(half_floats, moved), half_floats, local.place[a] + i);
      }
      const VecD share = hn::Mul(hn::Sub(hn::Load(doubles, value + i), hn::Set(doubles, local.lowest)),
                                 hn::Set(doubles, local.per_range));
      hn::Store(hn::DemoteTo(half_floats, share), half_floats, local.value + i);
    }
  }

  HWY_INLINE static hn::Vec<Longs> to_longs(hn::Vec<Counts> x) {
    return hn::BitCast(longs, hn::PromoteTo(hn::RebindToUnsigned<Doubles>(), x));
  }

  template <class T>
  HWY_INLINE void take_range(std::uint64_t cluster, LocalCluster& local) const {
    const auto& block =
        static_cast<const formats::RangeBlock<T>*>(field_.ranges[0])[cluster / formats::ClusterShape::width];
    local.lowest = block.lo[cluster % formats::ClusterShape::width];
    local.highest = block.hi[cluster % formats::ClusterShape::width];
    local.range = local.highest - local.lowest;
    const bool has_inverse = local.range > least_range;
    local.per_range = has_inverse ? 1 / local.range : 0;
    const double largest = std::abs(local.lowest) + local.range;
    const double error = has_inverse ? 6 * 0x1p-50 * largest * local.per_range : 0;
    local.value_error = error < 1e30 ? static_cast<float>(error) : 1e30f;
  }

  const TetMaximumField& field_;
  TetScratch& scratch_;
};

}  // namespace
}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
