#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "formats/base/checks.h"

namespace rhoray::render::wide {

/// Regions of a group's frustum with the largest value in each, taken in falling order of value:
/// 256 buckets of values, last in first out within a bucket.
class RegionQueue {
 public:
  struct Region {
    double largest;
    std::int16_t at[3];  ///< mirrored; in units of regions of this size
    std::uint16_t is_block;
    std::uint32_t next;
  };

  /// Empties the queue, for regions with values in this range.
  RHORAY_INLINE void clear(double lowest, double highest) {
    lowest_ = lowest;
    buckets_per_unit_ = highest > lowest ? 255 / (highest - lowest) : 0;
    for (std::uint64_t& word : filled_) word = 0;
    count_ = 0, unused_ = none;
  }

  RHORAY_INLINE int bucket_of(double largest) const {
    const double at = (largest - lowest_) * buckets_per_unit_;
    return at > 0 ? (at < 255 ? static_cast<int>(at) : 255) : 0;  // a NaN, from -infinity, gives 0
  }

  /// About the smallest value in a bucket.
  RHORAY_INLINE double least_of(int bucket) const {
    return bucket > 0 ? lowest_ + bucket / buckets_per_unit_ : lowest_;
  }

  /// Returns false where the queue is full.
  RHORAY_INLINE bool put(double largest, const int* at, bool is_block) {
    std::uint32_t place = unused_;
    if (place != none)
      unused_ = regions_[place].next;
    else if (count_ < capacity)
      place = count_++;
    else
      return false;
    const auto bucket = static_cast<std::size_t>(bucket_of(largest));
    std::uint64_t& word = filled_[bucket / 64];
    const std::uint64_t bit = std::uint64_t{1} << bucket % 64;
    Region& region = regions_[place];
    region.largest = largest;
    for (int a = 0; a < 3; ++a) region.at[a] = static_cast<std::int16_t>(at[a]);
    region.is_block = is_block;
    region.next = (word & bit) != 0 ? first_[bucket] : none;
    first_[bucket] = place;
    word |= bit;
    return true;
  }

  /// The highest bucket with regions, or -1.
  RHORAY_INLINE int highest_bucket() const {
    for (int word = 3; word >= 0; --word)
      if (filled_[word] != 0) return 64 * word + 63 - std::countl_zero(filled_[word]);
    return -1;
  }

  /// What take(bucket) would return; the bucket must have regions.
  RHORAY_INLINE const Region& first_in(int bucket) const { return regions_[first_[bucket]]; }

  RHORAY_INLINE Region take(int bucket) {
    const std::uint32_t place = first_[bucket];
    const Region region = regions_[place];
    first_[bucket] = region.next;
    if (region.next == none) filled_[bucket / 64] &= ~(std::uint64_t{1} << bucket % 64);
    regions_[place].next = unused_;
    unused_ = place;
    return region;
  }

 private:
  static constexpr std::uint32_t capacity = 4096;
  static constexpr std::uint32_t none = ~std::uint32_t{0};

  double lowest_, buckets_per_unit_;
  std::uint64_t filled_[4];  ///< bit b of word w: bucket 64 w + b has regions
  std::uint32_t count_, unused_;
  std::uint32_t first_[256];
  Region regions_[capacity];
};

}  // namespace rhoray::render::wide
