// The search for the largest values on rays, compiled once per machine.

#ifndef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/kernels/wide/maximum_lanes.cpp"  // relative to the repository root
#include <hwy/foreach_target.h>  // comes first: this file is included again for each machine

#include <bit>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <hwy/highway.h>

#include "render/kernels/wide/frustum_walk.h"
#include "render/kernels/wide/group-inl.h"
#include "render/kernels/wide/lanes-inl.h"
#include "render/kernels/wide/maximum_parts.h"
#include "render/kernels/wide/octant.h"
#include "render/march/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {
namespace {

constexpr double nothing = -std::numeric_limits<double>::infinity();
constexpr float nothing_float = -std::numeric_limits<float>::infinity();

// ---- numbers in single precision on the safe side

HWY_INLINE float float_not_above(double x) {
  const float rounded = static_cast<float>(x);
  if (!(static_cast<double>(rounded) > x)) return rounded;
  const float lower = rounded - 0x1p-23F * (rounded < 0 ? -rounded : rounded);
  return lower < rounded ? lower : -std::numeric_limits<float>::min();
}
HWY_INLINE float float_not_below(double x) {
  return -float_not_above(-x);
}

// ---- queue

HWY_INLINE int bucket_of(const RegionQueue& queue, double largest) {
  const double at = (largest - queue.lowest) * queue.buckets_per_unit;
  return at > 0 ? (at < 255 ? static_cast<int>(at) : 255) : 0;  // a NaN, from -infinity, comes to 0
}

HWY_INLINE void clear(RegionQueue& queue, double lowest, double highest) {
  queue.lowest = lowest;
  queue.buckets_per_unit = highest > lowest ? 255 / (highest - lowest) : 0;
  for (std::uint64_t& word : queue.filled) word = 0;
  queue.count = 0, queue.unused = RegionQueue::none;
}

/// False where it is full.
HWY_INLINE bool put(RegionQueue& queue, double largest, const int* at, bool is_block) {
  std::uint32_t place = queue.unused;
  if (place != RegionQueue::none)
    queue.unused = queue.regions[place].next;
  else if (queue.count < RegionQueue::capacity)
    place = queue.count++;
  else
    return false;
  const auto bucket = static_cast<std::size_t>(bucket_of(queue, largest));
  std::uint64_t& word = queue.filled[bucket / 64];
  const std::uint64_t bit = std::uint64_t{1} << bucket % 64;
  RegionQueue::Region& region = queue.regions[place];
  region.largest = largest;
  for (int a = 0; a < 3; ++a) region.at[a] = static_cast<std::int16_t>(at[a]);
  region.is_block = is_block;
  region.next = (word & bit) != 0 ? queue.first[bucket] : RegionQueue::none;
  queue.first[bucket] = place;
  word |= bit;
  return true;
}

/// The highest bucket with regions, or -1.
HWY_INLINE int highest_bucket(const RegionQueue& queue) {
  for (int word = 3; word >= 0; --word)
    if (queue.filled[word] != 0) return 64 * word + 63 - std::countl_zero(queue.filled[word]);
  return -1;
}

HWY_INLINE RegionQueue::Region take(RegionQueue& queue, int bucket) {
  const std::uint32_t place = queue.first[bucket];
  const RegionQueue::Region region = queue.regions[place];
  queue.first[bucket] = region.next;
  if (region.next == RegionQueue::none) queue.filled[bucket / 64] &= ~(std::uint64_t{1} << bucket % 64);
  queue.regions[place].next = queue.unused;
  queue.unused = place;
  return region;
}

// ---- values

struct Range {
  double lo, hi;
};

template <class T>
HWY_INLINE Range stored_range(const void* first, std::ptrdiff_t at) {
  const T* ranges = static_cast<const T*>(first) + 2 * at;
  return {static_cast<double>(ranges[0]), static_cast<double>(ranges[1])};
}

/// Of a region of the file; hi is -infinity where nothing in it has data.
HWY_INLINE Range range_of(const MaximumField& field, const StoredRanges& level, const int* region) {
  using formats::ElementType;
  const std::ptrdiff_t at =
      (static_cast<std::ptrdiff_t>(region[2]) * level.count[1] + region[1]) * level.count[0] + region[0];
  const Range range = [&] {
    switch (field.type) {
      case ElementType::U8:
        return stored_range<std::uint8_t>(level.first, at);
      case ElementType::I8:
        return stored_range<std::int8_t>(level.first, at);
      case ElementType::U16:
        return stored_range<std::uint16_t>(level.first, at);
      case ElementType::I16:
        return stored_range<std::int16_t>(level.first, at);
      case ElementType::U32:
        return stored_range<std::uint32_t>(level.first, at);
      case ElementType::I32:
        return stored_range<std::int32_t>(level.first, at);
      case ElementType::F32:
        return stored_range<float>(level.first, at);
      default:
        return stored_range<double>(level.first, at);
    }
  }();
  return range.lo <= range.hi ? range : Range{nothing, nothing};
}

/// A power of two that brings a block's range near 1.
HWY_INLINE double unit_for(double range, bool in_float) {
  const auto exponent = static_cast<int>(std::bit_cast<std::uint64_t>(range) >> 52) - 1023;
  if (range == 0) return 1;
  const int largest = in_float ? 126 : 1022;
  const int wanted = -exponent < largest ? (-exponent > -largest ? -exponent : -largest) : largest;
  return std::bit_cast<double>(static_cast<std::uint64_t>(wanted + 1023) << 52);
}

/// Types whose values, and the differences between those of a block, single precision holds as it holds the samples.
template <class T>
inline constexpr bool fits_float = sizeof(T) <= 2 || std::is_same_v<T, float>;

HWY_INLINE bool in_float(formats::ElementType type) {
  using formats::ElementType;
  return type != ElementType::U32 && type != ElementType::I32 && type != ElementType::F64;
}

constexpr hn::CappedTag<float, 4> row_of_floats;
constexpr hn::Rebind<std::int32_t, decltype(row_of_floats)> row_of_ints;

template <class T>
HWY_INLINE hn::Vec<decltype(row_of_floats)> load_row(const T* from) {
  if constexpr (std::is_same_v<T, float>)
    return hn::LoadU(row_of_floats, from);
  else
    return hn::ConvertTo(row_of_floats,
                         hn::PromoteTo(row_of_ints, hn::LoadU(hn::Rebind<T, decltype(row_of_floats)>(), from)));
}

/// Each cell's largest, at the place of its lowest corner. Cells that touch a sample without data count as if they
/// reached the block's largest: single precision does not tell for certain which cell a ray is in, and one without data
/// says nothing of its neighbour.
HWY_INLINE void find_largest(bool has_gaps, MaximumBlock& block) {
  const auto larger_of = [&](const float* from, std::size_t further, std::size_t count) {
    for (std::size_t i = 0; i < count; i += float_lanes)
      hn::Store(hn::Max(hn::Load(floats, from + i), hn::LoadU(floats, from + i + further)), floats, block.largest + i);
  };
  if (has_gaps) {
    HWY_ALIGN float filled[160];
    for (std::size_t i = 0; i < 160; i += float_lanes) {
      const VecF sample = hn::Load(floats, block.sample + i);
      const MaskF is_number = hn::Le(hn::Abs(sample), hn::Set(floats, std::numeric_limits<float>::max()));
      hn::Store(hn::IfThenElseZero(is_number, sample), floats, filled + i);
    }
    larger_of(filled, 1, 128);
  } else {
    larger_of(block.sample, 1, 128);
  }
  larger_of(block.largest, 5, 128);
  larger_of(block.largest, 25, 96);
}

/// Samples as (sample - highest) * unit, rounded once, and each cell's largest.
/// @param place  of the block in the file
template <class T>
HWY_NOINLINE void fetch(const MaximumField& field, const int* place, double highest, double unit, MaximumBlock& block) {
  const SampleSource& source = field.source;
  const T* samples = static_cast<const T*>(source.samples);
  std::uint64_t address[3][5];
  bool is_whole = source.has_whole_rows;
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < 5; ++i) {
      const int at = 4 * place[a] + i, last = source.count[a] - 1;
      is_whole = is_whole && at <= last;
      address[a][i] = source.address[a][at < last ? at : last];
    }
  const auto each_row = [&](auto&& read) {
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 5; ++j) read(samples + address[1][j] + address[2][k], block.sample + 5 * j + 25 * k);
  };
  if constexpr (fits_float<T>) {
    if (is_whole) {
      const float highest_float = static_cast<float>(highest), unit_float = static_cast<float>(unit);
      const auto highest_row = hn::Set(row_of_floats, highest_float), unit_row = hn::Set(row_of_floats, unit_float);
      each_row([&](const T* row, float* to) {
        for (std::size_t i = 0; i < 4; i += hn::MaxLanes(row_of_floats))
          hn::StoreU(hn::Mul(hn::Sub(load_row(row + address[0][0] + i), highest_row), unit_row), row_of_floats, to + i);
        to[4] = (static_cast<float>(row[address[0][4]]) - highest_float) * unit_float;
      });
      find_largest(field.has_gaps, block);
      return;
    }
  }
  each_row([&](const T* row, float* to) {
    for (int i = 0; i < 5; ++i) to[i] = static_cast<float>((static_cast<double>(row[address[0][i]]) - highest) * unit);
  });
  find_largest(field.has_gaps, block);
}

HWY_INLINE void fetch_of_type(const MaximumField& field, const int* place, double highest, double unit,
                              MaximumBlock& block) {
  using formats::ElementType;
  switch (field.type) {
    case ElementType::U8:
      return fetch<std::uint8_t>(field, place, highest, unit, block);
    case ElementType::I8:
      return fetch<std::int8_t>(field, place, highest, unit, block);
    case ElementType::U16:
      return fetch<std::uint16_t>(field, place, highest, unit, block);
    case ElementType::I16:
      return fetch<std::int16_t>(field, place, highest, unit, block);
    case ElementType::U32:
      return fetch<std::uint32_t>(field, place, highest, unit, block);
    case ElementType::I32:
      return fetch<std::int32_t>(field, place, highest, unit, block);
    case ElementType::F32:
      return fetch<float>(field, place, highest, unit, block);
    default:
      return fetch<double>(field, place, highest, unit, block);
  }
}

/// Corner c of the cells of some looks, each in its lane; lanes beyond repeat the first.
template <class T>
HWY_NOINLINE void corners_of(const SampleSource& source, const Looks& looks, std::size_t first, std::size_t count,
                             double (*corner)[8]) {
  const T* samples = static_cast<const T*>(source.samples);
  for (std::size_t lane = 0; lane < double_lanes; ++lane) {
    const std::size_t i = first + (lane < count ? lane : 0);
    const std::uint64_t* x = source.address[0] + looks.cell[0][i];
    const std::uint64_t* y = source.address[1] + looks.cell[1][i];
    const std::uint64_t* z = source.address[2] + looks.cell[2][i];
    for (int c = 0; c < 8; ++c) corner[c][lane] = static_cast<double>(samples[x[c & 1] + y[c >> 1 & 1] + z[c >> 2]]);
  }
}

// ---- search

/// The search for one group of rays: regions by their largest value, the largest first; blocks in single precision.
///
/// Places in single precision are off by less than `margin_`, 8 units of rounding of the lattice's extent: start and
/// slope of a line are rounded once, and so are their product and sum. Regions are wider by it, so that a ray is found
/// in every one that it passes in double. Values in a block are off by less than 12 margins of its range (3 for a place
/// that is off on all axes, as much for a part that goes on beyond its cell, the rest where the neighbouring cell is
/// the true one), and 2^-20 of it for the interpolation itself. A value is reached for certain where the place lies
/// three margins inside a cell.
class Search {
 public:
  Search(const MaximumField& field, const RayArrays& rays, MaximumScratch& scratch, const MirroredLattice& lattice,
         const Frustum& frustum)
      : field_(field), rays_(rays), scratch_(scratch), lattice_(lattice), frustum_(frustum) {
    int longest = 0;
    for (const int count : lattice.node_count) longest = count > longest ? count : longest;
    double furthest = 0;
    for (std::size_t r = 0; r < scratch.group.count; ++r)
      for (int a = 0; a < 3; ++a) {
        const double o = scratch.group.origin[a][r];
        furthest = o > furthest ? o : -o > furthest ? -o : furthest;
      }
    margin_ = 0x1p-21F * 16 * static_cast<float>(longest) + static_cast<float>(0x1p-46 * furthest);
  }

  void run() {
    make_lines();
    put_nodes();
    RegionQueue& queue = scratch_.queue;
    for (int bucket; (bucket = highest_bucket(queue)) >= 0 && bucket >= bucket_of(queue, lowest_reached_);) {
      const RegionQueue::Region region = take(queue, bucket);
      if (region.largest < lowest_reached_) continue;
      const int at[3] = {region.at[0], region.at[1], region.at[2]};
      if (region.is_block)
        look_into_block(at);
      else
        open_node(at, region.largest);
    }
    decide_suspects();
  }

 private:
  /// The rays as functions of the place on the major axis. The margin holds all rounding there is in these.
  HWY_INLINE void make_lines() {
    const RayGroup& group = scratch_.group;
    GroupLines& lines = scratch_.lines;
    const int w = frustum_.major;
    for (std::size_t r = 0; r < group.count; r += double_lanes) {
      const VecD o_w = mirrored_origin(lattice_, group, w, r), d_w = speed(group, w, r);
      const auto store = [&](VecD x, float* to) { hn::Store(hn::DemoteTo(half_floats, x), half_floats, to + r); };
      for (int m = 0; m < 2; ++m) {
        const VecD slope = hn::Div(speed(group, frustum_.minor[m], r), d_w);
        store(hn::NegMulAdd(o_w, slope, mirrored_origin(lattice_, group, frustum_.minor[m], r)), lines.start[m]);
        store(slope, lines.slope[m]);
        const VecD inverse = hn::Div(hn::Set(doubles, 1.0), slope);
        store(hn::Min(inverse, hn::Set(doubles, 0x1p40)), lines.inverse[m]);
      }
      const VecD margin = hn::Set(doubles, static_cast<double>(margin_));
      store(hn::Sub(hn::MulAdd(hn::Load(doubles, group.t_in + r), d_w, o_w), margin), lines.from);
      store(hn::Add(hn::MulAdd(hn::Load(doubles, group.t_out + r), d_w, o_w), margin), lines.to);
    }
    for (std::size_t r = 0; r < GroupLines::size; ++r) {
      const bool is_inside = r < group.count && (group.inside >> r & 1) != 0;
      lines.reached[r] = is_inside ? nothing_float : std::numeric_limits<float>::infinity();
      lines.reached_at[r] = std::numeric_limits<float>::infinity();
      scratch_.reached[r] = scratch_.known_value[r] = nothing;
      scratch_.known_t[r] = std::numeric_limits<double>::infinity();
      for (std::uint64_t& key : scratch_.last_looks[r].key) key = ~std::uint64_t{0};
      scratch_.last_looks[r].next = 0;
      if (!is_inside) lines.from[r] = 1, lines.to[r] = 0;
    }
    vectors_ = (group.count + float_lanes - 1) / float_lanes;
    in_float_ = in_float(field_.type);
    scratch_.suspects.count = scratch_.looks_left.count = 0;
    lowest_reached_ = nothing;
  }

  /// True for regions that the file has; `place` is where.
  HWY_INLINE bool find_in_file(const int* mirrored, bool is_block, const StoredRanges& level, int* place) const {
    for (int a = 0; a < 3; ++a) {
      place[a] = is_block ? lattice_.block(a, mirrored[a]) : lattice_.node(a, mirrored[a]);
      if (place[a] < 0 || place[a] >= level.count[a]) return false;
    }
    return true;
  }

  HWY_INLINE void put_nodes() {
    const int w = frustum_.major, u = frustum_.minor[0], v = frustum_.minor[1];
    const auto slab_of = [&](double at) {
      const int slab = floored(at / 16);
      return slab < 0 ? 0 : slab >= lattice_.node_count[w] ? lattice_.node_count[w] - 1 : slab;
    };
    const int first = slab_of(frustum_.first), last = slab_of(frustum_.last);
    const auto each_node = [&](auto&& act) {
      for (int slab = last; slab >= first; --slab) {
        const SlabRectangle cells = rectangle_in_slab(frustum_, slab, 16, lattice_.node_count);
        for (int j = cells.last[1]; j >= cells.first[1]; --j)
          for (int i = cells.last[0]; i >= cells.first[0]; --i) {
            int node[3], place[3];
            node[w] = slab, node[u] = i, node[v] = j;
            if (!find_in_file(node, false, field_.nodes, place)) continue;
            const double largest =
                field_.nodes.first ? range_of(field_, field_.nodes, place).hi : std::numeric_limits<double>::max();
            if (largest > nothing) act(static_cast<const int*>(node), largest);
          }
      }
    };
    double lowest = std::numeric_limits<double>::infinity(), highest = nothing;
    each_node([&](const int*, double largest) {
      ++scratch_.regions;
      lowest = largest < lowest ? largest : lowest, highest = largest > highest ? largest : highest;
    });
    clear(scratch_.queue, lowest, highest);
    each_node([&](const int* node, double largest) {
      if (!put(scratch_.queue, largest, node, false)) open_node(node, largest);
    });
  }

  /// Rays of a vector that pass a region and can be changed by it.
  struct Passing {
    MaskF rays;
    VecF from, to;
  };
  HWY_INLINE Passing rays_through(const int* region, float edge, float largest, std::size_t r) const {
    const GroupLines& lines = scratch_.lines;
    const float low_w = static_cast<float>(region[frustum_.major]) * edge;
    Passing passing;
    passing.from = hn::Max(hn::Load(floats, lines.from + r), hn::Set(floats, low_w - margin_));
    passing.to = hn::Min(hn::Load(floats, lines.to + r), hn::Set(floats, low_w + edge + margin_));
    for (int m = 0; m < 2; ++m) {
      const float low = static_cast<float>(region[frustum_.minor[m]]) * edge;
      const VecF start = hn::Load(floats, lines.start[m] + r), inverse = hn::Load(floats, lines.inverse[m] + r);
      passing.from = hn::Max(passing.from, hn::Mul(hn::Sub(hn::Set(floats, low - margin_), start), inverse));
      passing.to = hn::Min(passing.to, hn::Mul(hn::Sub(hn::Set(floats, low + edge + margin_), start), inverse));
    }
    passing.rays = hn::And(hn::Le(passing.from, passing.to),
                           may_improve(hn::Set(floats, largest), passing.from, hn::Load(floats, lines.reached + r),
                                       hn::Load(floats, lines.reached_at + r)));
    return passing;
  }

  HWY_INLINE static MaskF may_improve(VecF bound, VecF from, VecF reached, VecF reached_at) {
    return hn::Or(hn::Gt(bound, reached), hn::And(hn::Eq(bound, reached), hn::Lt(from, reached_at)));
  }

  HWY_NOINLINE void open_node(const int* node, double largest) {
    const float largest_float = float_not_below(largest);
    bool any = false;
    for (std::size_t r = 0; r < vectors_ * float_lanes && !any; r += float_lanes)
      any = !hn::AllFalse(floats, rays_through(node, 16, largest_float, r).rays);
    if (!any) return;
    const int w = frustum_.major, u = frustum_.minor[0], v = frustum_.minor[1];
    const int block_count[3] = {4 * lattice_.node_count[0], 4 * lattice_.node_count[1], 4 * lattice_.node_count[2]};
    for (int s = 3; s >= 0; --s) {
      const int slab = 4 * node[w] + s;
      const SlabRectangle cells = rectangle_in_slab(frustum_, slab, 4, block_count);
      const auto first = [&](int m, int at) { return cells.first[m] > 4 * at ? cells.first[m] : 4 * at; };
      const auto last = [&](int m, int at) { return cells.last[m] < 4 * at + 3 ? cells.last[m] : 4 * at + 3; };
      for (int j = last(1, node[v]); j >= first(1, node[v]); --j)
        for (int i = last(0, node[u]); i >= first(0, node[u]); --i) {
          int block[3], place[3];
          block[w] = slab, block[u] = i, block[v] = j;
          if (!find_in_file(block, true, field_.blocks, place)) continue;
          ++scratch_.regions;
          const double block_largest = range_of(field_, field_.blocks, place).hi;
          if (!(block_largest > nothing) || block_largest < lowest_reached_) continue;
          if (!put(scratch_.queue, block_largest, block, true)) look_into_block(block);
        }
    }
  }

  HWY_NOINLINE void look_into_block(const int* block) {
    int place[3] = {};
    find_in_file(block, true, field_.blocks, place);
    const Range range = range_of(field_, field_.blocks, place);
    const float largest = float_not_below(range.hi);
    RaysAtBlock& at_block = scratch_.at_block;
    at_block.count = 0;
    for (std::size_t r = 0; r < vectors_ * float_lanes; r += float_lanes) {
      const Passing passing = rays_through(block, 4, largest, r);
      if (hn::AllFalse(floats, passing.rays)) continue;
      hn::CompressStore(hn::Iota(ints, static_cast<std::int32_t>(r)), hn::RebindMask(ints, passing.rays), ints,
                        at_block.ray + at_block.count);
      hn::CompressStore(passing.from, passing.rays, floats, at_block.from + at_block.count);
      at_block.count += hn::CompressStore(passing.to, passing.rays, floats, at_block.to + at_block.count);
    }
    if (at_block.count == 0) return;
    // Lanes beyond the last ray pass through nothing.
    for (std::size_t lane = at_block.count; lane < at_block.count + float_lanes; ++lane)
      at_block.ray[lane] = at_block.ray[0], at_block.from[lane] = 1, at_block.to[lane] = 0;

    const double unit = unit_for(range.hi - range.lo, in_float_);
    fetch_of_type(field_, place, range.hi, unit, scratch_.block);
    const float error = static_cast<float>((range.hi - range.lo) * unit) * (12 * margin_ + 0x1p-20F);
    scratch_.at_hand.count = 0;
    for (std::size_t first = 0; first < at_block.count; first += float_lanes)
      walk_block(block, range.hi, unit, error, first);
    keep_suspects(range.hi, unit);
  }

  /// What rays have reached, in a block's unit: no more than it is, and below the block's largest value where that is
  /// not reached.
  HWY_INLINE VecF reached_in_block(double highest, double unit, std::size_t first) const {
    const RaysAtBlock& at_block = scratch_.at_block;
    const VecF least = hn::Set(floats, -8.0F);
    if (in_float_) {
      const VecF reached = hn::GatherIndex(floats, scratch_.lines.reached, hn::Load(ints, at_block.ray + first));
      const VecF from = hn::Set(floats, static_cast<float>(highest));
      const VecF below = hn::Sub(reached, from);
      const VecF lower = hn::NegMulAdd(hn::Abs(below), hn::Set(floats, 0x1p-22F), below);
      const VecF safe = hn::IfThenElse(hn::Eq(hn::Add(below, from), reached), below, lower);
      return hn::Max(hn::Mul(safe, hn::Set(floats, static_cast<float>(unit))), least);
    }
    HWY_ALIGN float result[16];
    for (std::size_t lane = 0; lane < float_lanes; ++lane) {
      const double value = scratch_.reached[at_block.ray[first + lane]];
      const double below = value - highest, scaled = below * unit;
      result[lane] = -8;
      if (!(scaled > -8)) continue;
      result[lane] = float_not_above(scaled);
      if (below + highest != value) result[lane] -= 0x1p-22F * (result[lane] < 0 ? -result[lane] : result[lane]);
    }
    return hn::Load(floats, result);
  }

  /// The cells of a block along some rays.
  HWY_NOINLINE void walk_block(const int* block, double highest, double unit, float error_float, std::size_t first) {
    const RaysAtBlock& at_block = scratch_.at_block;
    const GroupLines& lines = scratch_.lines;
    BlockSuspects& at_hand = scratch_.at_hand;
    const int w = frustum_.major, u = frustum_.minor[0], v = frustum_.minor[1];
    VecF reached = reached_in_block(highest, unit, first);

    const VecF one = hn::Set(floats, 1.0F), three = hn::Set(floats, 3.0F), zero = hn::Zero(floats);
    const VecF never = hn::Set(floats, std::numeric_limits<float>::infinity());
    const VecF error = hn::Set(floats, error_float);
    const VecI ray = hn::Load(ints, at_block.ray + first);
    VecF reached_at = hn::GatherIndex(floats, lines.reached_at, ray);
    VecF from = hn::Load(floats, at_block.from + first);
    const VecF to = hn::Load(floats, at_block.to + first);
    const VecF low_w = hn::Set(floats, static_cast<float>(4 * block[w]));
    const VecF low_u = hn::Set(floats, static_cast<float>(4 * block[u]));
    const VecF low_v = hn::Set(floats, static_cast<float>(4 * block[v]));
    const VecF start_u = hn::Sub(hn::GatherIndex(floats, lines.start[0], ray), low_u);
    const VecF start_v = hn::Sub(hn::GatherIndex(floats, lines.start[1], ray), low_v);
    const VecF slope_u = hn::GatherIndex(floats, lines.slope[0], ray);
    const VecF slope_v = hn::GatherIndex(floats, lines.slope[1], ray);
    const VecF inverse_u = hn::GatherIndex(floats, lines.inverse[0], ray);
    const VecF inverse_v = hn::GatherIndex(floats, lines.inverse[1], ray);

    // Mirrored axes are read backwards.
    const int step[3] = {1, 5, 25};
    std::int32_t stride[3], lowest_sample = 0, lowest_cell = 0;
    for (int a = 0; a < 3; ++a) {
      const bool is_mirrored = lattice_.is_mirrored(a);
      stride[a] = is_mirrored ? -step[a] : step[a];
      if (is_mirrored) lowest_sample += 4 * step[a], lowest_cell += 3 * step[a];
    }
    const float* samples = scratch_.block.sample + lowest_sample;
    const float* largest = scratch_.block.largest + lowest_cell;
    const VecI stride_w = hn::Set(ints, stride[w]), stride_u = hn::Set(ints, stride[u]),
               stride_v = hn::Set(ints, stride[v]);

    const auto clamped = [&](VecF x) { return hn::Min(hn::Max(hn::Floor(x), zero), three); };
    VecF p_w = hn::Sub(from, low_w), p_u = hn::MulAdd(slope_u, from, start_u), p_v = hn::MulAdd(slope_v, from, start_v);
    VecF cell_w = clamped(p_w), cell_u = clamped(p_u), cell_v = clamped(p_v);
    p_w = hn::Sub(p_w, cell_w), p_u = hn::Sub(p_u, cell_u), p_v = hn::Sub(p_v, cell_v);
    VecI cell =
        hn::Add(hn::Add(hn::Mul(hn::ConvertTo(ints, cell_w), stride_w), hn::Mul(hn::ConvertTo(ints, cell_u), stride_u)),
                hn::Mul(hn::ConvertTo(ints, cell_v), stride_v));
    const auto next = [&](VecF c, VecF at) { return hn::IfThenElse(hn::Lt(c, three), at, never); };
    VecF next_w = next(cell_w, hn::Add(hn::Add(low_w, cell_w), one));
    VecF next_u = next(cell_u, hn::Mul(hn::Sub(hn::Add(cell_u, one), start_u), inverse_u));
    VecF next_v = next(cell_v, hn::Mul(hn::Sub(hn::Add(cell_v, one), start_v), inverse_v));

    MaskF active = hn::Le(from, to), raised = hn::Lt(zero, zero);
    VecF cells = hn::Zero(floats);
    for (;;) {
      const VecF leave = hn::Min(hn::Min(next_w, to), hn::Min(next_u, next_v));
      const VecF q_w = hn::Sub(hn::Sub(leave, low_w), cell_w),
                 q_u = hn::Sub(hn::MulAdd(slope_u, leave, start_u), cell_u),
                 q_v = hn::Sub(hn::MulAdd(slope_v, leave, start_v), cell_v);
      const VecF bound = hn::Add(hn::GatherIndex(floats, largest, cell), error);
      const MaskF wanted = hn::And(active, may_improve(bound, from, reached, reached_at));
      cells = hn::Add(cells, hn::IfThenElseZero(active, one));
      if (!hn::AllFalse(floats, wanted)) {
        const Coefficients b =
            coefficients(samples, stride[u], stride[v], stride[w], cell, {p_u, p_v, p_w}, {q_u, q_v, q_w});
        // Without data all coefficients are no numbers, or far below the block's values.
        const VecF hull = b.largest();
        const VecF highest_here = hn::Add(hn::IfThenElseZero(hn::Ge(hull, hn::Set(floats, -4.0F)), hull), error);
        const MaskF suspect = hn::And(wanted, may_improve(highest_here, from, reached, reached_at));
        if (!hn::AllFalse(floats, suspect)) {
          hn::CompressStore(ray, hn::RebindMask(ints, suspect), ints, at_hand.ray + at_hand.count);
          hn::CompressStore(from, suspect, floats, at_hand.from + at_hand.count);
          hn::CompressStore(leave, suspect, floats, at_hand.to + at_hand.count);
          at_hand.count += hn::CompressStore(highest_here, suspect, floats, at_hand.bound + at_hand.count);

          // A value that is reached for certain: at a point well inside the cell and well inside the ray.
          const VecF s = b.likely_maximum();
          const MaskF inside =
              hn::And(hn::And(is_inside(p_u, q_u, s), is_inside(p_v, q_v, s)),
                      hn::And(is_inside(p_w, q_w, s), hn::Ge(hn::Sub(leave, from), hn::Set(floats, 128 * margin_))));
          const VecF value = hn::Sub(b.at(s), error);
          const MaskF has_data =
              hn::Le(hn::Abs(hn::Add(hn::Add(b.b0, b.b1), hn::Add(b.b2, b.b3))), hn::Set(floats, 16.0F));
          const MaskF rises = hn::And(hn::And(suspect, has_data), hn::And(inside, hn::Gt(value, reached)));
          reached = hn::IfThenElse(rises, value, reached);
          const VecF place = hn::MulAdd(s, hn::Sub(leave, from), from);
          reached_at = hn::IfThenElse(rises, hn::Add(place, hn::Set(floats, margin_)), reached_at);
          raised = hn::Or(raised, rises);
        }
      }
      active = hn::And(active, hn::Lt(leave, to));
      if (hn::AllFalse(floats, active)) break;
      const VecF step_w = hn::IfThenElseZero(hn::Le(next_w, leave), one),
                 step_u = hn::IfThenElseZero(hn::Le(next_u, leave), one),
                 step_v = hn::IfThenElseZero(hn::Le(next_v, leave), one);
      cell = hn::Add(cell, hn::Add(hn::IfThenElseZero(hn::RebindMask(ints, hn::Le(next_w, leave)), stride_w),
                                   hn::Add(hn::IfThenElseZero(hn::RebindMask(ints, hn::Le(next_u, leave)), stride_u),
                                           hn::IfThenElseZero(hn::RebindMask(ints, hn::Le(next_v, leave)), stride_v))));
      cell_w = hn::Add(cell_w, step_w), cell_u = hn::Add(cell_u, step_u), cell_v = hn::Add(cell_v, step_v);
      p_w = hn::Sub(q_w, step_w), p_u = hn::Sub(q_u, step_u), p_v = hn::Sub(q_v, step_v);
      next_w = next(cell_w, hn::Add(hn::Add(low_w, cell_w), one));
      next_u = next(cell_u, hn::Mul(hn::Sub(hn::Add(cell_u, one), start_u), inverse_u));
      next_v = next(cell_v, hn::Mul(hn::Sub(hn::Add(cell_v, one), start_v), inverse_v));
      from = leave;
    }
    count_cells(cells, first);
    if (!hn::AllFalse(floats, raised)) raise(raised, reached, reached_at, highest, unit, first);
  }

  HWY_INLINE MaskF is_inside(VecF p, VecF q, VecF s) const {
    const VecF half = hn::Set(floats, 0.5F);
    return hn::Le(hn::Abs(hn::Sub(hn::MulAdd(s, hn::Sub(q, p), p), half)), hn::Set(floats, 0.5F - 3 * margin_));
  }

  HWY_INLINE void count_cells(VecF cells, std::size_t first) {
    HWY_ALIGN float counted[16];
    hn::Store(cells, floats, counted);
    const RaysAtBlock& at_block = scratch_.at_block;
    const std::size_t rays = at_block.count - first < float_lanes ? at_block.count - first : float_lanes;
    for (std::size_t lane = 0; lane < rays; ++lane)
      scratch_.cost[scratch_.group.index[at_block.ray[first + lane]]] += 1 + static_cast<std::uint32_t>(counted[lane]);
  }

  /// Takes over what rays have reached in a block.
  HWY_INLINE void raise(MaskF raised, VecF reached, VecF reached_at, double highest, double unit, std::size_t first) {
    HWY_ALIGN float values[16], places[16];
    hn::Store(reached, floats, values);
    hn::Store(reached_at, floats, places);
    for (std::uint64_t bits = bits_of(floats, raised); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      // Single precision has lost more than this rounding: the error holds for both.
      const double value = highest + static_cast<double>(values[lane]) / unit;
      set_reached(static_cast<std::size_t>(scratch_.at_block.ray[first + static_cast<std::size_t>(lane)]), value,
                  places[lane]);
    }
    find_lowest_reached();
  }

  HWY_INLINE void set_reached(std::size_t ray, double value, float place) {
    if (!(value > scratch_.reached[ray] || (value == scratch_.reached[ray] && place < scratch_.lines.reached_at[ray])))
      return;
    scratch_.reached[ray] = value;
    scratch_.lines.reached[ray] = float_not_above(value);
    scratch_.lines.reached_at[ray] = place;
  }

  struct Point {
    VecF u, v, w;
  };

  /// The Bernstein coefficients along the way from p to q (cells/trilinear.h), b0 to b3.
  struct Coefficients {
    VecF b0, b1, b2, b3;

    HWY_INLINE VecF largest() const { return hn::Max(hn::Max(b0, b1), hn::Max(b2, b3)); }

    HWY_INLINE VecF at(VecF s) const {
      const VecF r = hn::Sub(hn::Set(floats, 1.0F), s), three = hn::Set(floats, 3.0F);
      const VecF outer = hn::MulAdd(hn::Mul(hn::Mul(r, r), r), b0, hn::Mul(hn::Mul(hn::Mul(s, s), s), b3));
      return hn::MulAdd(hn::Mul(three, hn::Mul(r, s)), hn::MulAdd(r, b1, hn::Mul(s, b2)), outer);
    }

    /// A place not far from the largest value, away from both ends.
    HWY_INLINE VecF likely_maximum() const {
      const VecF d0 = hn::Sub(b1, b0), d1 = hn::Sub(b2, b1), d2 = hn::Sub(b3, b2);
      const VecF discriminant = hn::Max(hn::NegMulAdd(d0, d2, hn::Mul(d1, d1)), hn::Zero(floats));
      const VecF turn = hn::Div(d0, hn::Add(hn::Sqrt(discriminant), hn::Sub(d0, d1)));
      const VecF first = hn::Set(floats, 1.0F / 64), last = hn::Set(floats, 63.0F / 64);
      const VecF end = hn::IfThenElse(hn::Gt(b3, b0), last, first);
      return hn::IfThenElse(hn::And(hn::Gt(turn, first), hn::Lt(turn, last)), turn, end);
    }
  };

  HWY_INLINE static Coefficients coefficients(const float* samples, std::int32_t stride_u, std::int32_t stride_v,
                                              std::int32_t stride_w, VecI cell, const Point& p, const Point& q) {
    const auto corner = [&](std::int32_t offset) { return hn::GatherIndex(floats, samples + offset, cell); };
    struct Pair {
      VecF p, q;
    };
    const auto between = [](VecF a, VecF b, VecF at_p, VecF at_q) {
      const VecF difference = hn::Sub(b, a);
      return Pair{hn::MulAdd(difference, at_p, a), hn::MulAdd(difference, at_q, a)};
    };
    const auto along_u = [&](std::int32_t offset) {
      return between(corner(offset), corner(offset + stride_u), p.u, q.u);
    };
    const Pair f00 = along_u(0), f10 = along_u(stride_v), f01 = along_u(stride_w), f11 = along_u(stride_v + stride_w);
    const Pair low_p = between(f00.p, f10.p, p.v, q.v), low_q = between(f00.q, f10.q, p.v, q.v);
    const Pair high_p = between(f01.p, f11.p, p.v, q.v), high_q = between(f01.q, f11.q, p.v, q.v);
    const Pair pp = between(low_p.p, high_p.p, p.w, q.w), qp = between(low_q.p, high_q.p, p.w, q.w);
    const Pair pq = between(low_p.q, high_p.q, p.w, q.w), qq = between(low_q.q, high_q.q, p.w, q.w);
    // Each is a sum of all corners with weights: one that is not a number makes all of them so.
    const VecF third = hn::Set(floats, 1.0F / 3);
    return {pp.p, hn::Mul(hn::Add(hn::Add(qp.p, pq.p), pp.q), third),
            hn::Mul(hn::Add(hn::Add(qq.p, qp.q), pq.q), third), qq.q};
  }

  /// Puts the suspects of a block to the others, but for those that what was reached since rules out.
  HWY_NOINLINE void keep_suspects(double highest, double unit) {
    const BlockSuspects& at_hand = scratch_.at_hand;
    Suspects& suspects = scratch_.suspects;
    for (std::size_t i = 0; i < at_hand.count; ++i) {
      const auto ray = static_cast<std::size_t>(at_hand.ray[i]);
      const double bound = highest + static_cast<double>(at_hand.bound[i]) / unit;
      if (bound < scratch_.reached[ray]) continue;
      suspects.ray[suspects.count] = at_hand.ray[i];
      suspects.from[suspects.count] = at_hand.from[i];
      suspects.to[suspects.count] = at_hand.to[i];
      suspects.bound[suspects.count++] = bound;
    }
    if (suspects.count > Suspects::capacity - BlockSuspects::capacity) decide_suspects();
  }

  /// Looks closely at the suspects that what was reached since does not rule out.
  HWY_NOINLINE void decide_suspects() {
    const std::uint64_t start = field_.time_phases ? ticks_now() : 0;
    Suspects& suspects = scratch_.suspects;
    for (std::size_t i = 0; i < suspects.count; ++i) {
      const auto ray = static_cast<std::size_t>(suspects.ray[i]);
      if (suspects.bound[i] < scratch_.reached[ray]) continue;
      put_look(suspects.ray[i], time_at(ray, suspects.from[i]), time_at(ray, suspects.to[i]));
      if (scratch_.looks_left.count == first_looks) look_closely();
    }
    look_closely();
    suspects.count = 0;
    find_lowest_reached();
    if (field_.time_phases) scratch_.ticks += ticks_now() - start;
  }

  static constexpr std::size_t first_looks = 128;

  /// The cell in the middle, up to rounding; those around it follow as far as the part reaches.
  HWY_INLINE void put_look(std::int32_t ray, double from, double to) {
    const RayGroup& group = scratch_.group;
    const double middle = 0.5 * (from + to);
    std::int32_t cell[3];
    for (int a = 0; a < 3; ++a) {
      const double at = group.origin[a][ray] + middle * group.direction[a][ray];
      cell[a] = at > 0 ? (at < field_.leaf_count[a] ? floored(at) : field_.leaf_count[a] - 1) : 0;
    }
    LastLooks& last = scratch_.last_looks[ray];
    const std::size_t kept = last.next++ % LastLooks::kept;
    last.key[kept] = key_of(cell), last.from[kept] = from, last.to[kept] = to;
    put_look(ray, cell, from, to, 0);
  }

  HWY_INLINE static std::uint64_t key_of(const std::int32_t* cell) {
    return static_cast<std::uint64_t>(cell[0]) | static_cast<std::uint64_t>(cell[1]) << 16 |
           static_cast<std::uint64_t>(cell[2]) << 32;
  }

  HWY_INLINE void put_look(std::int32_t ray, const std::int32_t* cell, double from, double to, std::int32_t way) {
    Looks& looks = scratch_.looks_left;
    const std::size_t i = looks.count++;
    for (int a = 0; a < 3; ++a) looks.cell[a][i] = cell[a];
    looks.ray[i] = ray, looks.from[i] = from, looks.to[i] = to, looks.way[i] = way;
  }

  /// The cell beside one on its ray, unless it is looked at anyway, and what follows it as well.
  HWY_INLINE void put_neighbour(std::size_t of, int axis, int step, std::int32_t way) {
    const Looks& looks = scratch_.looks_left;
    std::int32_t cell[3] = {looks.cell[0][of], looks.cell[1][of], looks.cell[2][of]};
    cell[axis] += step;
    if (cell[axis] < 0 || cell[axis] >= field_.leaf_count[axis]) return;
    const LastLooks& last = scratch_.last_looks[looks.ray[of]];
    for (std::size_t i = 0; i < LastLooks::kept; ++i)
      if (last.key[i] == key_of(cell) && (way < 0 ? last.from[i] <= looks.from[of] : last.to[i] >= looks.to[of]))
        return;
    put_look(looks.ray[of], cell, looks.from[of], looks.to[of], way);
  }

  HWY_NOINLINE void look_closely() {
    Looks& looks = scratch_.looks_left;
    std::size_t first = 0;
    while (first < looks.count) {
      // Each look may add two.
      if (looks.count + 2 * double_lanes > Looks::capacity) {
        const std::size_t left = looks.count - first;
        for (std::size_t i = 0; i < left; ++i) {
          looks.ray[i] = looks.ray[first + i], looks.way[i] = looks.way[first + i];
          looks.from[i] = looks.from[first + i], looks.to[i] = looks.to[first + i];
          for (auto& cell : looks.cell) cell[i] = cell[first + i];
        }
        looks.count = left, first = 0;
      }
      const std::size_t count = looks.count - first < double_lanes ? looks.count - first : double_lanes;
      for (std::size_t i = first + count; i < first + double_lanes; ++i) looks.ray[i] = looks.ray[first];
      look_at_cells(first, count);
      first += count;
    }
    looks.count = 0;
  }

  struct PointD {
    VecD x, y, z;
  };
  HWY_INLINE static VecD between(VecD a, VecD b, VecD w) {
    return hn::Add(hn::Mul(hn::Sub(hn::Set(doubles, 1.0), w), a), hn::Mul(w, b));
  }

  /// Some looks side by side, operation for operation as largest_in_cell<double> (grid_maximum.h).
  HWY_INLINE void look_at_cells(std::size_t first, std::size_t count) {
    const Looks& looks = scratch_.looks_left;
    const RayGroup& group = scratch_.group;
    const VecD zero = hn::Zero(doubles), one = hn::Set(doubles, 1.0);
    scratch_.looks += count;
    constexpr hn::Rebind<std::int32_t, Doubles> half_ints;
    constexpr hn::RebindToSigned<Doubles> longs;

    HWY_ALIGN double corner[8][8];
    read_corners(first, count, corner);
    const auto ray = hn::PromoteTo(longs, hn::LoadU(half_ints, looks.ray + first));
    const auto of_ray = [&](const double* numbers) { return hn::GatherIndex(doubles, numbers, ray); };

    // The whole way through the cell.
    VecD low[3], entry[3], exit[3];
    VecD t_in = of_ray(group.t_in), t_out = of_ray(group.t_out);
    for (int a = 0; a < 3; ++a) {
      low[a] = hn::PromoteTo(doubles, hn::LoadU(half_ints, looks.cell[a] + first));
      const VecD high = hn::Add(low[a], one);
      const bool is_down = (group.octant >> a & 1) != 0;
      const VecD plane_origin = of_ray(group.plane_origin[a]), inverse = of_ray(group.inverse[a]);
      entry[a] = hn::Mul(hn::Sub(is_down ? high : low[a], plane_origin), inverse);
      exit[a] = hn::Mul(hn::Sub(is_down ? low[a] : high, plane_origin), inverse);
      t_in = hn::Max(entry[a], t_in), t_out = hn::Min(exit[a], t_out);
    }
    MaskD through_in[3], through_out[3];
    MaskD later = hn::Lt(zero, zero), earlier = later;
    for (int a = 2; a >= 0; --a) {  // the last plane passed at t_in, in the order x, y, z
      const MaskD is_at = hn::Eq(entry[a], t_in);
      through_in[a] = hn::AndNot(later, is_at);
      later = hn::Or(later, is_at);
    }
    for (int a = 0; a < 3; ++a) {  // the first plane passed at t_out
      const MaskD is_at = hn::Eq(exit[a], t_out);
      through_out[a] = hn::AndNot(earlier, is_at);
      earlier = hn::Or(earlier, is_at);
    }

    VecD f[8];
    VecD bound = hn::Load(doubles, corner[0]);
    MaskD has_data = is_finite(bound);
    f[0] = bound;
    for (int c = 1; c < 8; ++c) {
      f[c] = hn::Load(doubles, corner[c]);
      bound = hn::Max(bound, f[c]);
      has_data = hn::And(has_data, is_finite(f[c]));
    }
    const VecD known = of_ray(scratch_.known_value);
    const MaskD improves =
        hn::Or(hn::Gt(bound, known), hn::And(hn::Eq(bound, known), hn::Lt(t_in, of_ray(scratch_.known_t))));
    // Rounding, where planes are passed at nearly the same time, may have named a cell beside the ray.
    const VecD from = hn::LoadU(doubles, looks.from + first), to = hn::LoadU(doubles, looks.to + first);
    const MaskD is_on_ray = hn::And(hn::Lt(t_in, t_out), hn::And(hn::Le(t_in, to), hn::Ge(t_out, from)));
    const MaskD is_first = hn::Eq(hn::PromoteTo(doubles, hn::LoadU(half_ints, looks.way + first)), zero);
    const MaskD is_stray = hn::AndNot(is_on_ray, is_first);
    if (!hn::AllFalse(doubles, is_stray)) walk_strays(first, bits_of(doubles, is_stray) & first_rays(count));

    const MaskD wanted = hn::And(hn::And(has_data, hn::Lt(t_in, t_out)), hn::AndNot(is_stray, improves));
    if (!hn::AllFalse(doubles, wanted)) {
      VecD largest_size = zero;
      for (VecD& value : f) {
        value = hn::Sub(value, bound);
        largest_size = hn::Max(largest_size, hn::Abs(value));
      }
      VecD in[3], out[3];
      for (int a = 0; a < 3; ++a) {
        const VecD o = of_ray(group.origin[a]), d = of_ray(group.direction[a]);
        const VecD near_face = (group.octant >> a & 1) != 0 ? one : zero, far_face = hn::Sub(one, near_face);
        const auto place = [&](VecD t) {
          return hn::Min(hn::Max(hn::Sub(hn::Add(o, hn::Mul(t, d)), low[a]), zero), one);
        };
        in[a] = hn::IfThenElse(through_in[a], near_face, place(t_in));
        out[a] = hn::IfThenElse(through_out[a], far_face, place(t_out));
      }
      const Answer answer = largest_on_way(f, in, out);
      const VecD along = hn::Add(hn::Mul(hn::Sub(one, answer.s), t_in), hn::Mul(answer.s, t_out));
      const VecD t = hn::Min(hn::Max(along, t_in), t_out);
      const VecD value = hn::Add(bound, answer.value);
      // Differences that need another unit are left to the scalar kernel's own code.
      const MaskD is_far = hn::And(
          hn::Gt(largest_size, zero),
          hn::Or(hn::Gt(largest_size, hn::Set(doubles, 0x1p900)), hn::Lt(largest_size, hn::Set(doubles, 0x1p-900))));
      const MaskD is_far_and_wanted = hn::And(wanted, is_far);
      if (!hn::AllFalse(doubles, is_far_and_wanted))
        walk_strays(first, bits_of(doubles, is_far_and_wanted) & first_rays(count));
      take_answers(first, count, hn::And(hn::AndNot(is_far, wanted), hn::Ge(value, known)), value, t,
                   hn::And(hn::Eq(value, bound), hn::Eq(t, t_in)));
    }
    follow(first, first_rays(count) & ~bits_of(doubles, is_stray), t_in, t_out, through_in, through_out);
  }

  /// Looks at these as the scalar kernel walks.
  HWY_NOINLINE void walk_strays(std::size_t first, std::uint64_t lanes) {
    const Looks& looks = scratch_.looks_left;
    for (std::uint64_t bits = lanes; bits != 0; bits &= bits - 1) {
      const std::size_t i = first + static_cast<std::size_t>(std::countr_zero(bits));
      const auto ray = static_cast<std::size_t>(looks.ray[i]);
      const std::uint32_t place = scratch_.group.index[ray];
      field_.look_closely(field_.context, rays_, place, looks.from[i], looks.to[i], scratch_.found[place]);
      knows(ray, scratch_.found[place]);
    }
  }

  HWY_INLINE void knows(std::size_t ray, const FoundMaximum& found) {
    scratch_.known_value[ray] = found.value, scratch_.known_t[ray] = found.t;
    set_reached(ray, found.value, float_not_below(place_at(ray, found.t)) + margin_);
  }

  struct Answer {
    VecD value, s;
  };

  /// CubicOf::along and largest_value (cells/trilinear.h, cells/cubic.h).
  HWY_INLINE static Answer largest_on_way(const VecD* f, const VecD* in, const VecD* out) {
    struct Pair {
      VecD p, q;
    };
    const auto on_axis = [&](VecD a, VecD b, int axis) {
      return Pair{between(a, b, in[axis]), between(a, b, out[axis])};
    };
    const Pair x00 = on_axis(f[0], f[1], 0), x10 = on_axis(f[2], f[3], 0), x01 = on_axis(f[4], f[5], 0),
               x11 = on_axis(f[6], f[7], 0);
    const Pair low_p = on_axis(x00.p, x10.p, 1), low_q = on_axis(x00.q, x10.q, 1);
    const Pair high_p = on_axis(x01.p, x11.p, 1), high_q = on_axis(x01.q, x11.q, 1);
    // g.._: by x and y, each for both ends on z.
    const Pair gpp = on_axis(low_p.p, high_p.p, 2), gqp = on_axis(low_q.p, high_q.p, 2);
    const Pair gpq = on_axis(low_p.q, high_p.q, 2), gqq = on_axis(low_q.q, high_q.q, 2);
    const VecD zero = hn::Zero(doubles), one = hn::Set(doubles, 1.0), three = hn::Set(doubles, 3.0);
    const VecD b0 = gpp.p, b1 = hn::Div(hn::Add(hn::Add(gqp.p, gpq.p), gpp.q), three),
               b2 = hn::Div(hn::Add(hn::Add(gqq.p, gqp.q), gpq.q), three), b3 = gqq.q;

    Answer best{b0, zero};
    const MaskD may_turn = hn::Or(hn::Gt(b1, b0), hn::Gt(b2, b3));
    if (!hn::AllFalse(doubles, may_turn)) {
      VecD d0 = hn::Sub(b1, b0), d1 = hn::Sub(b2, b1), d2 = hn::Sub(b3, b2);
      const VecD unit = hn::Max(hn::Max(hn::Abs(d0), hn::Abs(d1)), hn::Abs(d2));
      d0 = hn::Div(d0, unit), d1 = hn::Div(d1, unit), d2 = hn::Div(d2, unit);
      const VecD a = hn::Add(hn::Sub(d0, hn::Mul(hn::Set(doubles, 2.0), d1)), d2), half_b = hn::Sub(d1, d0);
      const VecD discriminant = hn::Sub(hn::Mul(d1, d1), hn::Mul(d0, d2));
      const VecD q = hn::Neg(hn::Add(half_b, hn::CopySign(hn::Sqrt(discriminant), half_b)));
      const VecD one_root = hn::Div(q, a), other_root = hn::Div(d0, q);
      const MaskD turns = hn::And(may_turn, hn::Ge(discriminant, zero));
      const auto is_inside = [&](VecD s) { return hn::And(turns, hn::And(hn::Gt(s, zero), hn::Lt(s, one))); };
      const MaskD has_one = is_inside(one_root), has_other = is_inside(other_root);
      // The nearer one first; a larger value takes its place.
      const MaskD swaps = hn::And(hn::And(has_one, has_other), hn::Lt(other_root, one_root));
      const auto offer = [&](VecD s, MaskD valid) {
        const VecD r = hn::Sub(one, s);
        const auto mix = [&](VecD from, VecD to) { return hn::Add(hn::Mul(r, from), hn::Mul(s, to)); };
        const VecD c0 = mix(b0, b1), c1 = mix(b1, b2), c2 = mix(b2, b3);
        const VecD value = mix(mix(c0, c1), mix(c1, c2));
        const MaskD better = hn::And(valid, hn::Gt(value, best.value));
        best.value = hn::IfThenElse(better, value, best.value);
        best.s = hn::IfThenElse(better, s, best.s);
      };
      offer(hn::IfThenElse(swaps, other_root, one_root), has_one);
      offer(hn::IfThenElse(swaps, one_root, other_root), has_other);
    }
    const MaskD ends_higher = hn::Gt(b3, best.value);
    return {hn::IfThenElse(ends_higher, b3, best.value), hn::IfThenElse(ends_higher, one, best.s)};
  }

  HWY_INLINE void take_answers(std::size_t first, std::size_t count, MaskD wanted, VecD value, VecD t, MaskD at_entry) {
    HWY_ALIGN double values[8], times[8];
    hn::Store(value, doubles, values);
    hn::Store(t, doubles, times);
    const std::uint64_t entry_bits = bits_of(doubles, at_entry);
    const Looks& looks = scratch_.looks_left;
    for (std::uint64_t bits = bits_of(doubles, wanted) & first_rays(count); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      const std::size_t i = first + static_cast<std::size_t>(lane);
      const auto ray = static_cast<std::size_t>(looks.ray[i]);
      FoundMaximum& found = scratch_.found[scratch_.group.index[ray]];
      const auto id = static_cast<std::uint64_t>(
          (static_cast<std::int64_t>(looks.cell[2][i]) * field_.leaf_count[1] + looks.cell[1][i]) *
              field_.leaf_count[0] +
          looks.cell[0][i]);
      const FoundMaximum here{values[lane], times[lane], id, (entry_bits >> lane & 1) != 0};
      if (is_better(here, found)) found = here;
      knows(ray, found);
    }
  }

  /// Goes on to the cells before and behind, as far as the parts of the rays in question reach.
  HWY_INLINE void follow(std::size_t first, std::uint64_t lanes, VecD t_in, VecD t_out, const MaskD* through_in,
                         const MaskD* through_out) {
    const Looks& looks = scratch_.looks_left;
    const VecD ways = hn::PromoteTo(doubles, hn::LoadU(hn::Rebind<std::int32_t, Doubles>(), looks.way + first));
    const VecD zero = hn::Zero(doubles);
    const MaskD before = hn::And(hn::Lt(hn::LoadU(doubles, looks.from + first), t_in), hn::Le(ways, zero));
    const MaskD behind = hn::And(hn::Gt(hn::LoadU(doubles, looks.to + first), t_out), hn::Ge(ways, zero));
    const std::uint64_t before_bits = bits_of(doubles, before) & lanes, behind_bits = bits_of(doubles, behind) & lanes;
    if ((before_bits | behind_bits) == 0) return;
    for (int a = 0; a < 3; ++a) {
      const int step = (scratch_.group.octant >> a & 1) != 0 ? -1 : 1;
      for (std::uint64_t bits = bits_of(doubles, through_in[a]) & before_bits; bits != 0; bits &= bits - 1)
        put_neighbour(first + static_cast<std::size_t>(std::countr_zero(bits)), a, -step, -1);
      for (std::uint64_t bits = bits_of(doubles, through_out[a]) & behind_bits; bits != 0; bits &= bits - 1)
        put_neighbour(first + static_cast<std::size_t>(std::countr_zero(bits)), a, step, 1);
    }
  }

  HWY_INLINE void read_corners(std::size_t first, std::size_t count, double (*corner)[8]) const {
    using formats::ElementType;
    const Looks& looks = scratch_.looks_left;
    switch (field_.type) {
      case ElementType::U8:
        return corners_of<std::uint8_t>(field_.source, looks, first, count, corner);
      case ElementType::I8:
        return corners_of<std::int8_t>(field_.source, looks, first, count, corner);
      case ElementType::U16:
        return corners_of<std::uint16_t>(field_.source, looks, first, count, corner);
      case ElementType::I16:
        return corners_of<std::int16_t>(field_.source, looks, first, count, corner);
      case ElementType::U32:
        return corners_of<std::uint32_t>(field_.source, looks, first, count, corner);
      case ElementType::I32:
        return corners_of<std::int32_t>(field_.source, looks, first, count, corner);
      case ElementType::F32:
        return corners_of<float>(field_.source, looks, first, count, corner);
      default:
        return corners_of<double>(field_.source, looks, first, count, corner);
    }
  }

  HWY_INLINE double time_at(std::size_t ray, float place) const {
    const RayGroup& group = scratch_.group;
    const int w = frustum_.major;
    const double inverse = group.inverse[w][ray];
    const double plane =
        lattice_.is_mirrored(w) ? lattice_.plane(w, 0) - static_cast<double>(place) : static_cast<double>(place);
    const double t = (plane - group.plane_origin[w][ray]) * inverse;
    return t < group.t_in[ray] ? group.t_in[ray] : t > group.t_out[ray] ? group.t_out[ray] : t;
  }
  HWY_INLINE double place_at(std::size_t ray, double t) const {
    const RayGroup& group = scratch_.group;
    const int w = frustum_.major;
    const double o = lattice_.is_mirrored(w) ? lattice_.plane(w, 0) - group.origin[w][ray] : group.origin[w][ray];
    const double d = group.direction[w][ray];
    return o + t * (d < 0 ? -d : d);
  }

  HWY_INLINE void find_lowest_reached() {
    VecF lowest = hn::Set(floats, std::numeric_limits<float>::infinity());
    for (std::size_t r = 0; r < vectors_ * float_lanes; r += float_lanes)
      lowest = hn::Min(lowest, hn::Load(floats, scratch_.lines.reached + r));
    lowest_reached_ = static_cast<double>(hn::GetLane(hn::MinOfLanes(floats, lowest)));
  }

  const MaximumField& field_;
  const RayArrays& rays_;
  MaximumScratch& scratch_;
  const MirroredLattice& lattice_;
  const Frustum& frustum_;
  float margin_;  ///< more than positions are off in single precision
  std::size_t vectors_ = 0;
  bool in_float_ = false;
  double lowest_reached_ = nothing;
};

void largest_values(const MaximumField& field, const RayArrays& rays, std::size_t count, MaximumScratch& scratch) {
  for_each_group(rays, count, field.leaf_count, field.node_count, scratch.group,
                 [&](const RayGroup&, const MirroredLattice& lattice, const Frustum& frustum) {
                   Search(field, rays, scratch, lattice, frustum).run();
                 });
}

}  // namespace
LargestValues largest_values_here() {
  return largest_values;
}
}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace rhoray::render::wide {

LargestValues largest_values_on(Machine machine) {
  switch (machine) {
    case Machine::scalar:
      break;
    case Machine::baseline:
#if HWY_TARGETS & HWY_SSE4
      if (__builtin_cpu_supports("sse4.2")) return N_SSE4::largest_values_here();
#endif
#if HWY_TARGETS & HWY_SCALAR
      return N_SCALAR::largest_values_here();
#endif
      break;
    case Machine::avx2:
#if HWY_TARGETS & HWY_AVX2
      return N_AVX2::largest_values_here();
#endif
      break;
    case Machine::avx512:
#if HWY_TARGETS & HWY_AVX3
      return N_AVX3::largest_values_here();
#endif
      break;
  }
  return nullptr;
}

}  // namespace rhoray::render::wide
#endif
