// All rays of a search through the lattice from plane to plane of samples, 32 side by side in 16
// bits.
#if defined(RHORAY_WIDE_MAXIMUM_SWEEP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_MAXIMUM_SWEEP_INL_H
#undef RHORAY_WIDE_MAXIMUM_SWEEP_INL_H
#else
#define RHORAY_WIDE_MAXIMUM_SWEEP_INL_H
#endif

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "render/grid/largest/candidates-inl.h"
#include "render/grid/largest/layers-inl.h"
#include "render/grid/largest/pairs-inl.h"
#include "render/grid/largest/planes-inl.h"
#include "render/grid/largest/slab_blocks-inl.h"
#include "render/grid/largest/state-inl.h"
#include "render/grid/largest/walk-inl.h"
#include "render/traverse/frustum_walk.h"
#include "render/traverse/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {

#if RHORAY_HAS_WORD_TABLES

/// The search for samples of 8 and 16 bits without gaps, in bricks, where a vector's rays lie in a
/// window of samples and close to the major axis.
///
/// It takes slab by slab of blocks, the one with the largest value first. Two vectors of rays at a
/// time get their values at five planes of samples, and with them bounds for the four layers
/// between. Values at planes are certainly reached. When all slabs are done, the layers that may
/// hold more than was reached are walked from cell to cell. They are few: by then nearly the
/// largest value is reached.
class PlaneSweep {
 public:
  PlaneSweep(SearchState& state, CandidateRefinement& looks)
      : state_(state),
        looks_(looks),
        field_(state.field),
        scratch_(state.scratch),
        axes_{state.frustum.major, state.frustum.minor[0], state.frustum.minor[1]},
        block_count_{4 * state.lattice.node_count[0], 4 * state.lattice.node_count[1], 4 * state.lattice.node_count[2]},
        reader_(state.field, state.lattice, axes_),
        pairs_(state, axes_) {}

  /// True where this search can be used.
  HWY_INLINE bool fits() {
    using formats::ElementType;
    const ElementType type = field_.type;
    const bool is_short =
        type == ElementType::U8 || type == ElementType::I8 || type == ElementType::U16 || type == ElementType::I16;
    if (!is_short || field_.has_gaps || !field_.has_bricks) return false;
    // Positions are more accurate than their units.
    if (!(state_.exact_margin < 0x1p-22)) return false;
    find_slopes();
    // Rays stay in the neighbouring cells from one plane to the next.
    if (!(steepest_[0] < 0.99F && steepest_[1] < 0.99F)) return false;
    for (int m = 0; m < 2; ++m) slope_[m] = static_cast<int>(steepest_[m] * 0x1p15F) + 1;
    return is_narrow();
  }

  HWY_INLINE void run() {
    using formats::ElementType;
    switch (field_.type) {
      case ElementType::U8:
        return run_on<std::uint8_t>();
      case ElementType::I8:
        return run_on<std::int8_t>();
      case ElementType::U16:
        return run_on<std::uint16_t>();
      default:
        return run_on<std::int16_t>();
    }
  }

 private:
  static constexpr std::size_t layers = LayerValues::layers;

  HWY_INLINE void find_slopes() {
    const GroupLines& lines = scratch_.lines;
    VecF most[2] = {hn::Zero(floats), hn::Zero(floats)};
    for (std::size_t r = 0; r < state_.vectors * float_lanes; r += float_lanes) {
      const MaskF is_inside = hn::Le(hn::Load(floats, lines.from + r), hn::Load(floats, lines.to + r));
      for (int m = 0; m < 2; ++m)
        most[m] = hn::Max(most[m], hn::IfThenElseZero(is_inside, hn::Load(floats, lines.slope[m] + r)));
    }
    for (int m = 0; m < 2; ++m) steepest_[m] = hn::GetLane(hn::MaxOfLanes(floats, most[m]));
  }

  /// Cells across the rays of a vector at one plane for which a window of as many bricks as
  /// possible holds those of a slab. That is three samples less than a window, because bricks begin
  /// where they do, and one less than samples.
  /// slab: three samples less than a window, as bricks begin where they do, and one less than
  /// samples.
  static constexpr float most_across = 28;

  /// True where the cells that a vector's rays pass in a slab fit in a window, and the blocks of
  /// all vectors in their table. They lie between lines that are farthest apart at one of their
  /// ends.
  HWY_INLINE bool is_narrow() const {
    const Frustum& frustum = state_.frustum;
    const VectorLines& around = scratch_.around;
    for (int m = 0; m < 2; ++m)
      for (const double end : {frustum.first, frustum.last}) {
        const float beside = 4 * steepest_[m] + 16 * state_.margin + 2;
        const int blocks = m == 0 ? SlabBlocks::most_columns : SlabBlocks::most_rows;
        const auto all = static_cast<float>(frustum.high[m].at(end) - frustum.low[m].at(end));
        if (!(all + beside < static_cast<float>(4 * (blocks - 1)))) return false;
        const auto w = static_cast<float>(end);
        for (std::size_t vector = 0; vector < state_.vectors; ++vector) {
          const float low = around.low[m][vector] + w * around.low_slope[m][vector];
          const float high = around.high[m][vector] + w * around.high_slope[m][vector];
          if (!(high - low + beside < most_across)) return false;
        }
      }
    return true;
  }

  HWY_INLINE int slab_of(double at) const { return floored_within(at / 4, 0, block_count_[axes_[0]] - 1); }

  /// Adds the slabs to the queue, by the largest value of the blocks that the frustum meets in
  /// each.
  template <class T>
  HWY_INLINE void put_slabs() {
    const int w = axes_[0], first = slab_of(state_.frustum.first), last = slab_of(state_.frustum.last);
    constexpr std::int32_t none = std::numeric_limits<std::int32_t>::min();
    std::int32_t lowest = std::numeric_limits<std::int32_t>::max(), highest = none;
    for (int slab = first; slab <= last; ++slab) {
      std::int32_t& largest = scratch_.slab_largest[slab];
      largest = none;
      const int place = state_.lattice.block(w, slab);
      if (place < 0 || place >= field_.blocks.count[w]) continue;
      int from[2], to[2];
      if (!find_rectangle(slab, from, to)) continue;
      const BlockRanges<T> ranges(field_.blocks, state_.lattice, axes_, slab, from);
      for (int j = 0; j <= to[1] - from[1]; ++j)
        for (int i = 0; i <= to[0] - from[0]; ++i)
          largest = ranges.at(i, j)[1] > largest ? ranges.at(i, j)[1] : largest;
      scratch_.regions += static_cast<std::uint64_t>((to[0] - from[0] + 1) * (to[1] - from[1] + 1));
      lowest = largest < lowest ? largest : lowest, highest = largest > highest ? largest : highest;
    }
    scratch_.queue.clear(lowest, highest);
    for (int slab = last; slab >= first; --slab) {
      int at[3] = {};
      at[w] = slab;
      // There is room for all: a lattice has no more slabs.
      if (scratch_.slab_largest[slab] != none) scratch_.queue.put(scratch_.slab_largest[slab], at, true);
    }
  }

  /// The mirrored blocks at a slab that the frustum meets and that the volume has; false where
  /// there are none.
  HWY_INLINE bool find_rectangle(int slab, int* first, int* last) const {
    const SlabRectangle blocks = rectangle_in_slab(state_.frustum, slab, 4, block_count_);
    for (int m = 0; m < 2; ++m) {
      const int a = axes_[1 + m], count = field_.blocks.count[a];
      const int lowest = state_.lattice.is_mirrored(a) ? state_.lattice.block(a, count - 1) : 0;
      first[m] = blocks.first[m] < lowest ? lowest : blocks.first[m];
      last[m] = blocks.last[m] < lowest + count ? blocks.last[m] : lowest + count - 1;
      if (first[m] > last[m]) return false;
    }
    return true;
  }

  HWY_INLINE void find_line_parts() {
    const GroupLines& lines = scratch_.lines;
    LineParts& parts = scratch_.line_parts;
    const VecD one = hn::Set(doubles, LineParts::size_of_one);
    for (int m = 0; m < 2; ++m)
      for (std::size_t r = 0; r < state_.vectors * float_lanes; r += double_lanes) {
        const VecD slope = hn::Mul(hn::Load(doubles, lines.exact_slope[m] + r), one);
        hn::Store(hn::Mul(hn::Load(doubles, lines.exact_start[m] + r), one), doubles, parts.start[m] + r);
        hn::Store(slope, doubles, parts.slope[m] + r);
        hn::Store(hn::Vec<HalfInts>{_mm512_cvtpd_epi32(slope.raw)}, half_ints, parts.step[m] + r);
      }
  }

  template <class T>
  HWY_NOINLINE void run_on() {
    RegionQueue& queue = scratch_.queue;
    find_line_parts();
    scratch_.seen_layers.count = 0;
    put_slabs<T>();
    unsigned taken = 0;
    for (int bucket; (bucket = queue.highest_bucket()) >= 0 && bucket >= queue.bucket_of(state_.lowest_reached);) {
      const RegionQueue::Region region = queue.take(bucket);
      ask_for_next<T>();
      // Finding it anew takes longer than some slabs that it would have saved.
      if (++taken % 4 == 0 && state_.has_risen) state_.find_lowest_reached();
      if (region.largest < state_.lowest_reached) continue;
      look_at_slab<T>(region.at[axes_[0]], static_cast<float>(region.largest));
    }
    walk_seen<T>();
  }

  /// Prefetches the samples of the slab that is likely to be next.
  template <class T>
  HWY_INLINE void ask_for_next() const {
    const int bucket = scratch_.queue.highest_bucket();
    if (bucket < 0) return;
    const int slab = scratch_.queue.first_in(bucket).at[axes_[0]];
    int first[2], last[2];
    if (!find_rectangle(slab, first, last)) return;
    const auto brick = [&](int i, int block) HWY_ATTR {
      return field_.source.address[axes_[i]][4 * state_.lattice.block(axes_[i], block)];
    };
    const T* const samples = static_cast<const T*>(field_.source.samples) + brick(0, slab);
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) {
        const T* const here = samples + brick(2, j) + brick(1, i);
        hwy::Prefetch(here);
        hwy::Prefetch(here + 32);
      }
  }

  /// @param largest  of the slab
  template <class T>
  HWY_NOINLINE void look_at_slab(int slab, float largest) {
    pairs_.move_to(slab);
    int first[2], last[2];
    pairs_.find_blocks(first, last);
    const SlabBlocks blocks(BlockRanges<T>(field_.blocks, state_.lattice, axes_, slab, first), first, last);
    scratch_.regions += static_cast<std::uint64_t>((last[0] - first[0] + 1) * (last[1] - first[1] + 1));
    SlabPair changing[PairsAtSlab::most];
    std::size_t count = 0;
    const float* const reached = scratch_.around.reached;
    for (std::size_t vector = 0; vector < state_.vectors; vector += 2) {
      const std::size_t second = vector + 1 < state_.vectors ? vector + 1 : vector;
      if (reached[vector] > largest && reached[second] > largest) continue;
      SlabPair& pair = changing[count];
      pair = pairs_.pair_of(vector, second);
      if (pair.first[0] > pair.last[0] || pair.first[1] > pair.last[1]) continue;
      const int from[2] = {pair.first[0] >> 2, pair.first[1] >> 2}, to[2] = {pair.last[0] >> 2, pair.last[1] >> 2};
      pair.lowest = blocks.lowest, pair.highest = blocks.largest_between(from, to);
      pair.rays = rays_at(pair, static_cast<float>(4 * slab));
      count += pair.rays != 0;
    }
    if (count == 0) return;
    // Each may be split into two.
    if (scratch_.seen_layers.count + 2 * count > SeenLayers::capacity) {
      walk_seen<T>();
      pairs_.move_to(slab);
    }
    pairs_.in_windows(changing, count, [&](const SlabPair* pair, std::size_t fitting, const SlabPart& part) HWY_ATTR {
      sweep<T>(slab, pair, fitting, part);
    });
  }

  /// Calls of(vector) for both vectors of a pair; returns rays as bits, those of the second vector
  /// in the upper half.
  template <class Of>
  HWY_INLINE static std::uint32_t rays_of(const SlabPair& pair, const Of& of) {
    const auto bits = [&](std::size_t vector)
                          HWY_ATTR { return static_cast<std::uint32_t>(bits_of(floats, of(vector * float_lanes))); };
    return bits(pair.vector) | (pair.second != pair.vector ? bits(pair.second) << 16 : 0);
  }

  /// Rays of a pair that have a part in a slab and that its values may change.
  HWY_INLINE std::uint32_t rays_at(const SlabPair& pair, float low_w) const {
    const GroupLines& lines = scratch_.lines;
    const VecF largest = hn::Set(floats, static_cast<float>(pair.highest));
    return rays_of(pair, [&](std::size_t r) HWY_ATTR {
      const VecF from = hn::Max(hn::Load(floats, lines.from + r), hn::Set(floats, low_w - state_.margin));
      const VecF to = hn::Min(hn::Load(floats, lines.to + r), hn::Set(floats, low_w + 4 + state_.margin));
      return hn::And(hn::Le(from, to), SearchState::may_improve(largest, from, hn::Load(floats, lines.reached + r),
                                                                hn::Load(floats, lines.reached_at + r)));
    });
  }

  /// Rays of a pair that begin before one position and end behind another, on the major axis.
  HWY_INLINE std::uint32_t rays_between(const SlabPair& pair, float begin, float end) const {
    const GroupLines& lines = scratch_.lines;
    return rays_of(pair, [&](std::size_t r) HWY_ATTR {
      return hn::And(hn::Le(hn::Load(floats, lines.from + r), hn::Set(floats, begin)),
                     hn::Ge(hn::Load(floats, lines.to + r), hn::Set(floats, end)));
    });
  }

  template <class T>
  HWY_INLINE void sweep(int slab, const SlabPair* pair, std::size_t count, const SlabPart& part) {
    const WordScale scale = scale_of(pair, count);
    // Finding it takes longer than a single pair gains by it.
    const bool has_rise = part.window.is_narrow() && count > 1;
    if (has_rise)
      reader_.template read_planes_and_rise<T>(part.window, 4 * slab, scale, slope_, scratch_.planes);
    else
      reader_.template read_planes<T>(part.window, 4 * slab, scale, scratch_.planes);
    SeenLayers& seen = scratch_.seen_layers;
    for (std::size_t i = 0; i < count; ++i) {
      seen.at[seen.count] = {.slab = slab,
                             .vector = static_cast<std::int16_t>(pair[i].vector),
                             .second = static_cast<std::int16_t>(pair[i].second),
                             .lowest = scale.lowest,
                             .highest = scale.highest};
      seen.count += sweep_pair(slab, pair[i], part, scale, has_rise, seen.least[seen.count]);
    }
  }

  /// Records what a pair's rays reach at planes.
  /// @param has_rise  what rays gain between planes was computed
  /// @param least     smallest distance of any value of each layer below the words' highest; the
  ///                  maximum where the layer need not be walked
  /// @return          false where no layer must be walked
  HWY_NOINLINE bool sweep_pair(int slab, const SlabPair& pair, const SlabPart& part, const WordScale& scale,
                               bool has_rise, std::int16_t (*least)[32]) {
    const double low_w = 4.0 * slab;
    // A position is off by at most one part of 2^10.
    const int clear = state_.is_come_to(low_w) ? static_cast<int>(state_.clear_of_edges * 0x1p15F) + 33 : 0x4000;
    LayerValues values = values_of(pair, part, scratch_.line_parts, low_w, scratch_.planes, has_rise, clear);
    const VecS before = reached_below(pair, scale), nowhere = hn::Set(shorts, 32767);
    const auto lanes = [](std::uint32_t rays) { return hn::Mask<decltype(shorts)>{static_cast<__mmask32>(rays)}; };
    VecS reached = before;
    const float first = static_cast<float>(low_w), beside = 2 * state_.margin;
    if ((pair.rays & ~rays_between(pair, first - beside, first + 4 + beside)) == 0) {
      for (std::size_t k = 0; k < layers; ++k) {
        reached = hn::Min(reached, values.reached[k]);
        values.least[k] = hn::IfThenElse(lanes(pair.rays), values.least[k], nowhere);
      }
    } else {
      for (std::size_t k = 0; k < layers; ++k) {
        const float plane = first + static_cast<float>(k);
        const auto is_whole = lanes(rays_between(pair, plane - beside, plane + 1 + beside));
        const auto has_part = lanes(rays_between(pair, plane + 1, plane) & pair.rays);
        reached = hn::IfThenElse(is_whole, hn::Min(reached, values.reached[k]), reached);
        // Nothing is known about a part of a layer.
        const VecS known = hn::IfThenElse(is_whole, values.least[k], hn::Set(shorts, -32768));
        values.least[k] = hn::IfThenElse(has_part, known, nowhere);
      }
    }
    std::uint32_t any = 0;
    for (std::size_t k = 0; k < layers; ++k) {
      any |= static_cast<std::uint32_t>(hn::Lt(values.least[k], reached).raw);
      hn::Store(values.least[k], shorts, least[k]);
    }
    const auto risen = static_cast<std::uint32_t>(hn::Lt(reached, before).raw) & pair.rays;
    if (risen != 0) take_over(slab, pair, scale, reached, risen);
    count_visits(pair);
    return any != 0;
  }

  /// What the rays of a pair have reached, as a distance below the words' highest, rounded up.
  HWY_INLINE VecS reached_below(const SlabPair& pair, const WordScale& scale) const {
    const auto of = [&](std::size_t vector) HWY_ATTR {
      const VecF reached = hn::Load(floats, scratch_.lines.reached + vector * float_lanes);
      const VecF below = hn::Mul(hn::Sub(hn::Set(floats, static_cast<float>(scale.highest)), reached),
                                 hn::Set(floats, static_cast<float>(scale.unit())));
      const VecF inside = hn::Max(hn::Min(below, hn::Set(floats, 32766.0F)), hn::Set(floats, -1.0F));
      return hn::ConvertTo(ints, hn::Add(inside, hn::Set(floats, 1.0F)));
    };
    return lower_words(of(pair.vector), of(pair.second));
  }

  HWY_INLINE void take_over(int slab, const SlabPair& pair, const WordScale& scale, VecS reached, std::uint32_t risen) {
    HWY_ALIGN std::int16_t below[32];
    hn::Store(reached, shorts, below);
    const double size = 1 / scale.unit();  // exact: a power of two
    const float place = static_cast<float>(4 * slab + 4) + state_.margin;
    for (std::uint32_t bits = risen; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      const double value = scale.highest - below[lane] * size;
      state_.set_reached(pair.vector * float_lanes + lane, value, float_not_above(value), place);
    }
    state_.has_risen = true;
  }

  /// Counts a slab as a box and its layers.
  HWY_INLINE void count_visits(const SlabPair& pair) const {
    const auto count = [&](std::size_t vector, std::uint32_t rays) HWY_ATTR {
      float* const visits = scratch_.visits + vector * float_lanes;
      const VecF more = hn::IfThenElseZero(MaskF{static_cast<__mmask16>(rays)}, hn::Set(floats, 1.0F + layers));
      hn::Store(hn::Add(hn::Load(floats, visits), more), floats, visits);
    };
    count(pair.vector, pair.rays & 0xffff);
    if (pair.second != pair.vector) count(pair.second, pair.rays >> 16);
  }

  /// Walks from cell to cell in the layers that are left.
  template <class T>
  HWY_NOINLINE void walk_seen() {
    SeenLayers& seen = scratch_.seen_layers;
    for (std::size_t i = 0; i < seen.count;) {
      const int slab = seen.at[i].slab;
      pairs_.move_to(slab);
      SlabPair left[PairsAtSlab::most];
      std::size_t count = 0;
      for (; i < seen.count && seen.at[i].slab == slab && count < PairsAtSlab::most; ++i) {
        const SeenLayers::At& at = seen.at[i];
        SlabPair& pair = left[count];
        pair = pairs_.pair_of(static_cast<std::size_t>(at.vector), static_cast<std::size_t>(at.second));
        pair.lowest = at.lowest, pair.highest = at.highest;
        const VecS reached = reached_below(pair, {at.lowest, at.highest});
        pair.rays = 0;
        for (std::size_t k = 0; k < layers; ++k) {
          pair.may[k] = static_cast<std::uint32_t>(hn::Lt(hn::Load(shorts, seen.least[i][k]), reached).raw);
          pair.rays |= pair.may[k];
        }
        count += pair.rays != 0;
      }
      if (count == 0) continue;
      // Rays that lie close together share a window, with or without those that have nothing left.
      if (!pairs_.part_around(left, count).window.is_narrow())
        for (std::size_t pair = 0; pair < count; ++pair) pairs_.shrink_to(left[pair].rays, slab, left[pair]);
      pairs_.in_windows(left, count, [&](const SlabPair* pair, std::size_t fitting, const SlabPart& part) HWY_ATTR {
        walk<T>(slab, pair, fitting, part);
      });
    }
    seen.count = 0;
  }

  /// More than positions from a slab's corner are off, as in blocks.
  static constexpr float margin = 0x1p-18F;

  HWY_INLINE CellBox box_of(int slab, const SlabPart& part, const WordScale& scale) const {
    const int row = part.window.edge(), plane = row * row;
    const int first[2] = {part.first[0] - part.window.first[0], part.first[1] - part.window.first[1]};
    const auto last = [&](int m) { return static_cast<float>(part.last[m] - part.first[m]); };
    const double range = (scale.highest - scale.lowest) * scale.unit();
    const float cut = scale.shift < 0 ? 0.75F : 0;  // words are less by a half at most
    return {.low_w = 4.0 * slab,
            .last = {static_cast<float>(layers - 1), last(0), last(1)},
            .first = first[0] + first[1] * row,
            .stride = {plane, 1, row},
            .highest = static_cast<double>(scale.highest),
            .unit = scale.unit(),
            .error = static_cast<float>(range) * (12 * margin + 0x1p-20F) + cut,
            .margin = margin,
            .is_come_to = state_.is_come_to(4.0 * slab)};
  }

  template <class T>
  HWY_NOINLINE void walk(int slab, const SlabPair* pair, std::size_t count, const SlabPart& part) {
    const WordScale scale = scale_of(pair, count);
    reader_.template read_layers<T>(part.window, 4 * slab, scale, scratch_.layers);
    const CellBox box = box_of(slab, part, scale);
    RaysAtBlock& at_slab = scratch_.at_block;
    at_slab.count = 0;
    for (std::size_t i = 0; i < count; ++i) {
      put_layers(box, part, pair[i].vector, pair[i].may, 0);
      if (pair[i].second != pair[i].vector) put_layers(box, part, pair[i].second, pair[i].may, 16);
    }
    state_.close_box();
    const LayerCells cells{scratch_.layers.below, part.window.edge()};
    looks_.open_box(box.highest, box.unit, box.low_w);
    for (std::size_t first = 0; first < at_slab.count; first += float_lanes)
      walk_cells(state_, looks_, box, cells, ways_at_box(at_slab, first));
  }

  /// Adds the layers of a vector's rays to those that are walked.
  HWY_INLINE void put_layers(const CellBox& box, const SlabPart& part, std::size_t vector, const std::uint32_t* may,
                             int shift) {
    std::uint32_t any = 0;
    for (std::size_t k = 0; k < layers; ++k) any |= may[k] >> shift & 0xffff;
    if (any == 0) return;
    const GroupLines& lines = scratch_.lines;
    const std::size_t r = vector * float_lanes;
    double low[3];
    low[axes_[0]] = box.low_w;
    for (int m = 0; m < 2; ++m) low[axes_[1 + m]] = part.first[m];
    SearchState::PartsInBox parts =
        state_.parts_in_box(r, hn::Load(floats, lines.from + r), hn::Load(floats, lines.to + r), low);
    const VecF from = parts.from, to = parts.to;
    const VecF below = hn::Sub(hn::Load(floats, lines.reached + r), hn::Set(floats, static_cast<float>(box.highest)));
    const VecF lower = hn::NegMulAdd(hn::Abs(below), hn::Set(floats, 0x1p-22F), below);
    const VecF reached =
        hn::Max(hn::Mul(lower, hn::Set(floats, static_cast<float>(box.unit))), hn::Set(floats, WordTable::lowest));
    for (std::size_t k = 0; k < layers; ++k) {
      const std::uint32_t rays = may[k] >> shift & 0xffff;
      if (rays == 0) continue;
      parts.from = hn::Max(from, hn::Set(floats, static_cast<float>(k)));
      parts.to = hn::Min(to, hn::Set(floats, static_cast<float>(k + 1)));
      state_.put_at_box(r, MaskF{static_cast<__mmask16>(rays)}, parts, box.low_w, reached);
    }
  }

  SearchState& state_;
  CandidateRefinement& looks_;
  const MaximumField& field_;
  MaximumScratch& scratch_;
  int axes_[3];
  int block_count_[3];
  PlaneReader reader_;
  PairsAtSlab pairs_;
  float steepest_[2];  ///< largest slope of any ray
  int slope_[2];       ///< the same in parts of 2^15, rounded up
};

#endif

}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
