// Decides in double precision which of the candidate cells holds a ray's largest value. Included
// again for each machine.
#if defined(RHORAY_WIDE_TET_MAXIMUM_SUSPECTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_TET_MAXIMUM_SUSPECTS_INL_H
#undef RHORAY_WIDE_TET_MAXIMUM_SUSPECTS_INL_H
#else
#define RHORAY_WIDE_TET_MAXIMUM_SUSPECTS_INL_H
#endif

#include <algorithm>
#include <cstring>
#include <utility>

#include "render/tets/largest/rays-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {
namespace {

using Longs = hn::RebindToSigned<Doubles>;
inline constexpr Longs longs{};

/// For smaller ranges no shares are computed: they all count as zero.
inline constexpr double least_range = 1e-290;

#if HWY_NATIVE_FMA

/// Processes as many suspects side by side as a vector has doubles, operation for operation as the
/// scalar kernel: ValuesAlong in render/tets/reference/largest.h with render/cell/tet_crossing.h,
/// and BoxRay in cluster_walk.h.
class TetDecisions {
 public:
  HWY_INLINE TetDecisions(const TetMaximumField& field, const RayArrays& rays, const TetRays& group)
      : field_(field), rays_(rays), axes_{group.u, group.v, group.w} {}

  HWY_INLINE void look_at(const TetSuspect* suspects, std::size_t count, LargestSoFar* found) {
    std::size_t taken = 0;
    for (std::size_t s = 0; s < count; ++s) {
      if (suspects[s].most < found[suspects[s].ray].value) continue;
      take(suspects[s], taken++);
      if (taken == double_lanes) offer(std::exchange(taken, 0), found);
    }
    if (taken == 0) return;
    for (std::size_t i = taken; i < double_lanes; ++i) repeat(i);
    offer(taken, found);
  }

 private:
  HWY_INLINE void take(const TetSuspect& suspect, std::size_t i) {
    const std::uint64_t cluster = suspect.tet / field_.cluster_size;
    const std::uint32_t* const table = field_.tables + field_.table_starts[cluster];
    std::uint8_t corner[4];
    std::memcpy(corner, field_.corners + 4 * std::size_t{suspect.tet}, sizeof corner);
    // Tables are in increasing order: sorted by table index, vertices are also sorted by point
    // index.
    for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}, {1, 2}}) {
      const std::uint8_t low = corner[a] < corner[b] ? corner[a] : corner[b],
                         high = corner[a] < corner[b] ? corner[b] : corner[a];
      corner[a] = low, corner[b] = high;
    }
    for (std::size_t c = 0; c < 4; ++c) vertex_[c][i] = table[corner[c]];
    const formats::BoxBlock& block = field_.boxes[0][cluster / formats::ClusterShape::width];
    const std::size_t entry = cluster % formats::ClusterShape::width;
    for (std::size_t a = 0; a < 3; ++a) box_[a][i] = block.lo[a][entry], box_[3 + a][i] = block.hi[a][entry];
    ray_[i] = suspect.ray;
    tet_[i] = suspect.tet;
  }

  HWY_INLINE void repeat(std::size_t i) {
    for (auto& vertex : vertex_) vertex[i] = vertex[0];
    for (auto& side : box_) side[i] = side[0];
    ray_[i] = ray_[0], tet_[i] = tet_[0];
  }

  struct Vertex {
    VecD x, y, t, value;
  };
  /// For the edge from a to b: whether it passes left of the ray, and its weight.
  struct Edge {
    MaskD left;
    VecD weight;
  };
  struct Crossing {
    VecD t, value;
  };

  HWY_INLINE VecD of_rays(const double* from) const { return hn::GatherIndex(doubles, from, hn::Load(longs, ray_)); }

  HWY_INLINE VecD value_at(const std::int64_t* vertex) const {
    const auto index = hn::Load(longs, vertex);
    if (!field_.is_single) return hn::GatherIndex(doubles, static_cast<const double*>(field_.values), index);
    HWY_ALIGN double values[double_lanes];
    for (std::size_t i = 0; i < double_lanes; ++i) values[i] = static_cast<const float*>(field_.values)[vertex[i]];
    return hn::Load(doubles, values);
  }

  /// BoxRay::meet for one box per ray.
  HWY_INLINE MaskD meets_box(const VecD* origin, const VecD* direction, VecD t_min, VecD t_max) const {
    // The unit is a power of two, so its inverse is exact.
    const VecD per_unit = hn::Set(doubles, 1 / field_.box_unit), zero = hn::Zero(doubles);
    VecD t_in = hn::Set(doubles, -infinite), t_out = hn::Set(doubles, infinite);
    for (int m = 0; m < 3; ++m) {
      const auto a = static_cast<std::size_t>(axes_[m]);
      const VecD from = hn::Mul(origin[m], per_unit);
      const VecD exact = hn::Div(hn::Set(doubles, 1.0), hn::Mul(direction[m], per_unit));
      const VecD inverse = hn::IfThenElseZero(is_finite(exact), exact);
      const MaskD moves = hn::Ne(inverse, zero), rises = hn::Gt(inverse, zero);
      const VecD low = hn::PromoteTo(doubles, hn::Load(half_floats, box_[a])),
                 high = hn::PromoteTo(doubles, hn::Load(half_floats, box_[3 + a]));
      const VecD near = hn::Mul(hn::Sub(hn::IfThenElse(rises, low, high), from), inverse),
                 far = hn::Mul(hn::Sub(hn::IfThenElse(rises, high, low), from), inverse);
      const MaskD beside = hn::Not(hn::And(hn::Le(low, from), hn::Le(from, high)));
      t_in = hn::IfThenElse(hn::And(moves, hn::Lt(t_in, near)), near, t_in);
      t_out = hn::IfThenElse(hn::And(moves, hn::Lt(far, t_out)), far, t_out);
      t_in = hn::IfThenElse(hn::AndNot(moves, beside), hn::Set(doubles, infinite), t_in);
    }
    const auto margin = [&](VecD t) HWY_ATTR {
      return hn::Add(hn::Mul(hn::Abs(t), hn::Set(doubles, 0x1p-50)), hn::Set(doubles, 1e-300));
    };
    t_in = hn::Sub(t_in, margin(t_in)), t_out = hn::Add(t_out, margin(t_out));
    t_in = hn::IfThenElse(hn::Lt(t_in, t_min), t_min, t_in);
    t_out = hn::IfThenElse(hn::Lt(t_max, t_out), t_max, t_out);
    return hn::Le(t_in, t_out);
  }

  HWY_INLINE static Edge edge(const Vertex& a, const Vertex& b) {
    const VecD p = hn::Mul(a.x, b.y), q = hn::Mul(a.y, b.x);
    const VecD p_rest = hn::MulSub(a.x, b.y, p), q_rest = hn::MulSub(a.y, b.x, q);
    const auto decided = [](VecD greater, VecD less, MaskD otherwise) HWY_ATTR {
      const MaskD differ = hn::Ne(greater, less);
      return hn::Or(hn::And(differ, hn::Gt(greater, less)), hn::AndNot(differ, otherwise));
    };
    return {decided(p, q, decided(p_rest, q_rest, decided(a.y, b.y, hn::Gt(b.x, a.x)))),
            hn::Abs(hn::Add(hn::Sub(p, q), hn::Sub(p_rest, q_rest)))};
  }

  /// The weighted sums of a face, and the weight to divide them by.
  struct FaceSums {
    VecD t, value, weight;
  };
  HWY_INLINE static FaceSums face_sums(const Vertex& i, const Vertex& j, const Vertex& k, VecD wi, VecD wj, VecD wk) {
    const VecD one = hn::Set(doubles, 1.0);
    VecD sum = hn::Add(hn::Add(wi, wj), wk);
    const MaskD has_area = hn::Gt(sum, hn::Zero(doubles));
    wi = hn::IfThenElse(has_area, wi, one), wj = hn::IfThenElse(has_area, wj, one);
    wk = hn::IfThenElse(has_area, wk, one), sum = hn::IfThenElse(has_area, sum, hn::Set(doubles, 3.0));
    const auto mean = [&](VecD a, VecD b, VecD c)
                          HWY_ATTR { return hn::Add(hn::Add(hn::Mul(wi, a), hn::Mul(wj, b)), hn::Mul(wk, c)); };
    return {mean(i.t, j.t, k.t), mean(i.value, j.value, k.value), sum};
  }

  HWY_INLINE static FaceSums chosen(MaskD mask, const FaceSums& yes, const FaceSums& no) {
    return {hn::IfThenElse(mask, yes.t, no.t), hn::IfThenElse(mask, yes.value, no.value),
            hn::IfThenElse(mask, yes.weight, no.weight)};
  }

  HWY_INLINE static Crossing mean(const FaceSums& sums) {
    return {hn::Div(sums.t, sums.weight), hn::Div(sums.value, sums.weight)};
  }

  /// pass_through: the crossings of the first two faces that the ray passes.
  /// @return  rays that pass two
  HWY_INLINE static MaskD pass_through(const Vertex* v, Crossing& in, Crossing& out) {
    const Edge e01 = edge(v[0], v[1]), e02 = edge(v[0], v[2]), e03 = edge(v[0], v[3]);
    const Edge e12 = edge(v[1], v[2]), e13 = edge(v[1], v[3]), e23 = edge(v[2], v[3]);
    const auto crossed = [](const Edge& a, const Edge& b, const Edge& other)
                             HWY_ATTR { return hn::AndNot(hn::Xor(a.left, b.left), hn::Xor(a.left, other.left)); };
    const MaskD face[4] = {crossed(e12, e23, e13), crossed(e02, e23, e03), crossed(e01, e13, e03),
                           crossed(e01, e12, e02)};
    const FaceSums sums[4] = {face_sums(v[1], v[2], v[3], e23.weight, e13.weight, e12.weight),
                              face_sums(v[0], v[2], v[3], e23.weight, e03.weight, e02.weight),
                              face_sums(v[0], v[1], v[3], e13.weight, e03.weight, e01.weight),
                              face_sums(v[0], v[1], v[2], e12.weight, e02.weight, e01.weight)};
    FaceSums first = sums[0], second = sums[1];
    MaskD one = face[0], two = no_lane(doubles);
    for (int f = 1; f < 4; ++f) {
      const MaskD is_second = hn::AndNot(two, hn::And(one, face[f]));
      second = chosen(is_second, sums[f], second);
      two = hn::Or(two, is_second);
      first = chosen(hn::AndNot(one, face[f]), sums[f], first);
      one = hn::Or(one, face[f]);
    }
    const Crossing a = mean(first), b = mean(second);
    const MaskD is_swapped = hn::Lt(b.t, a.t);
    in = {hn::IfThenElse(is_swapped, b.t, a.t), hn::IfThenElse(is_swapped, b.value, a.value)};
    out = {hn::IfThenElse(is_swapped, a.t, b.t), hn::IfThenElse(is_swapped, a.value, b.value)};
    return two;
  }

  /// clip
  HWY_INLINE static MaskD clip(Crossing& in, Crossing& out, VecD t_min, VecD t_max) {
    const MaskD stays = hn::And(hn::Ge(out.t, t_min), hn::Le(in.t, t_max));
    const MaskD begins = hn::Lt(in.t, t_min), ends = hn::Gt(out.t, t_max);
    if (hn::AllFalse(doubles, hn::Or(begins, ends))) return stays;
    const Crossing from = in, to = out;
    const auto value_at = [&](VecD t) HWY_ATTR {
      const VecD s = hn::Div(hn::Sub(t, from.t), hn::Sub(to.t, from.t));
      return hn::Add(hn::Mul(hn::Sub(hn::Set(doubles, 1.0), s), from.value), hn::Mul(s, to.value));
    };
    in = {hn::IfThenElse(begins, t_min, in.t), hn::IfThenElse(begins, value_at(t_min), in.value)};
    out = {hn::IfThenElse(ends, t_max, out.t), hn::IfThenElse(ends, value_at(t_max), out.value)};
    return stays;
  }

  HWY_NOINLINE void offer(std::size_t count, LargestSoFar* found) const {
    VecD origin[3], direction[3];
    for (int m = 0; m < 3; ++m)
      origin[m] = of_rays(rays_.origin[axes_[m]]), direction[m] = of_rays(rays_.direction[axes_[m]]);
    const VecD t_min = of_rays(rays_.t_min), t_max = of_rays(rays_.t_max), zero = hn::Zero(doubles);
    const VecD inverse = hn::Div(hn::Set(doubles, 1.0), direction[2]);
    VecD slope[2];
    for (int m = 0; m < 2; ++m) {
      const VecD s = hn::Mul(direction[m], inverse);
      slope[m] = hn::IfThenElse(hn::Lt(hn::Abs(s), hn::Set(doubles, 1e-100)), zero, s);
    }
    Vertex v[4];
    MaskD counts = meets_box(origin, direction, t_min, t_max);
    VecD left, right, below, above, most;
    for (std::size_t c = 0; c < 4; ++c) {
      const auto index = hn::Load(longs, vertex_[c]);
      const auto place = hn::Add(index, hn::Add(index, index));
      const auto from_origin = [&](int m) HWY_ATTR {
        return hn::Sub(hn::GatherIndex(doubles, field_.points + axes_[m], place), origin[m]);
      };
      const VecD z = from_origin(2);
      v[c] = {hn::Sub(from_origin(0), hn::Mul(slope[0], z)), hn::Sub(from_origin(1), hn::Mul(slope[1], z)),
              hn::Mul(z, inverse), value_at(vertex_[c])};
      counts = hn::And(counts, is_finite(v[c].value));
      left = c == 0 ? v[0].x : hn::Min(left, v[c].x), right = c == 0 ? v[0].x : hn::Max(right, v[c].x);
      below = c == 0 ? v[0].y : hn::Min(below, v[c].y), above = c == 0 ? v[0].y : hn::Max(above, v[c].y);
      most = c == 0 ? v[0].value : hn::IfThenElse(hn::Lt(most, v[c].value), v[c].value, most);
    }
    counts = hn::And(counts, hn::And(hn::And(hn::Le(left, zero), hn::Ge(right, zero)),
                                     hn::And(hn::Le(below, zero), hn::Ge(above, zero))));
    if (hn::AllFalse(doubles, counts)) return;
    Crossing in, out;
    counts = hn::And(counts, pass_through(v, in, out));
    counts = hn::And(counts, clip(in, out, t_min, t_max));
    HWY_ALIGN double value[2][double_lanes], t[2][double_lanes];
    hn::Store(hn::IfThenElse(hn::Lt(most, in.value), most, in.value), doubles, value[0]);
    hn::Store(hn::IfThenElse(hn::Lt(most, out.value), most, out.value), doubles, value[1]);
    hn::Store(in.t, doubles, t[0]), hn::Store(out.t, doubles, t[1]);
    const std::uint64_t passed = bits_of(doubles, counts);
    for (std::size_t i = 0; i < count; ++i) {
      if ((passed >> i & 1) == 0) continue;
      const std::uint64_t id = field_.cell_id(field_.context, tet_[i]);
      for (int side = 0; side < 2; ++side) found[ray_[i]].offer(value[side][i], t[side][i], id);
    }
  }

  const TetMaximumField& field_;
  const RayArrays& rays_;
  const int axes_[3];
  HWY_ALIGN std::int64_t vertex_[4][double_lanes];
  HWY_ALIGN std::int64_t ray_[double_lanes];
  HWY_ALIGN float box_[6][double_lanes];  ///< low, then high
  std::uint32_t tet_[double_lanes];
};

#endif

/// Suspects not yet decided, and the values that rays have reached.
class TetSuspects {
 public:
  HWY_INLINE TetSuspects(const TetMaximumField& field, const RayArrays& rays, const TetRays& group, TetScratch& scratch)
      : field_(field), rays_(rays), group_(group), scratch_(scratch) {
    const double size = field.range.hi - field.range.lo;
    per_range_ = size > least_range ? 1 / size : 0;
  }

  HWY_INLINE void add(double most, std::uint64_t cell, std::size_t lane) {
    scratch_.suspects[scratch_.suspect_count++] = {most, static_cast<std::uint32_t>(cell),
                                                   static_cast<std::uint32_t>(ray_of(lane))};
  }

  /// Makes room for one suspect per lane. Where most suspects are kept, values are equal: deciding
  /// some then rules out those behind.
  HWY_INLINE void make_room() {
    if (scratch_.suspect_count < TetScratch::suspect_capacity) return;
    forget_those_below_reached();
    if (scratch_.suspect_count >= TetScratch::suspect_capacity * 3 / 4) decide();
  }

  /// Decides all suspects.
  HWY_NOINLINE void decide() {
    forget_those_below_reached();
    look();
    for (std::size_t s = 0; s < scratch_.suspect_count; ++s) {
      const std::size_t ray = scratch_.suspects[s].ray, lane = lane_of(ray);
      if (scratch_.found[ray].value > scratch_.reached[lane]) raise(lane, scratch_.found[ray].value);
    }
    scratch_.suspect_count = 0;
  }

  HWY_INLINE void raise(std::size_t lane, double reached) {
    scratch_.reached[lane] = reached;
    scratch_.reached_share[lane] = static_cast<float>((reached - field_.range.lo) * per_range_) - 0x1p-23f;
  }

 private:
  HWY_INLINE void forget_those_below_reached() {
    std::size_t kept = 0;
    for (std::size_t s = 0; s < scratch_.suspect_count; ++s) {
      const TetSuspect& suspect = scratch_.suspects[s];
      if (!(suspect.most < scratch_.reached[lane_of(suspect.ray)])) scratch_.suspects[kept++] = suspect;
    }
    scratch_.suspect_count = kept;
  }

  /// Without fused operations the scalar kernel's own code decides.
  HWY_INLINE void look() {
#if HWY_NATIVE_FMA
    TetDecisions(field_, rays_, group_).look_at(scratch_.suspects, scratch_.suspect_count, scratch_.found);
#else
    field_.look(field_.context, rays_, scratch_.suspects, scratch_.suspect_count, scratch_.found);
#endif
  }

  const TetMaximumField& field_;
  const RayArrays& rays_;
  [[maybe_unused]] const TetRays& group_;
  TetScratch& scratch_;
  double per_range_;
};

}  // namespace
}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
