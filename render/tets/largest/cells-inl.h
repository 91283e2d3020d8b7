// Tests a cluster's cells against the rays of a group: where may the largest value of a ray be?
// Included again for each machine.
#if defined(RHORAY_WIDE_TET_MAXIMUM_CELLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef RHORAY_WIDE_TET_MAXIMUM_CELLS_INL_H
#undef RHORAY_WIDE_TET_MAXIMUM_CELLS_INL_H
#else
#define RHORAY_WIDE_TET_MAXIMUM_CELLS_INL_H
#endif

#include <bit>
#include <cmath>
#include <cstring>

#include "render/tets/largest/cluster-inl.h"

HWY_BEFORE_NAMESPACE();
namespace rhoray::render::wide::HWY_NAMESPACE {
namespace {

using Codes = hn::RebindToUnsigned<Floats>;
using VecC = hn::Vec<Codes>;
using MaskC = hn::Mask<Codes>;
inline constexpr Codes codes{};

/// Upper bound of the error of a position in a ray's picture plane, in a cluster's frame, from
/// rounding to single precision. It holds for rays that pass the cluster's box within 2. With a =
/// 2^-24, it adds up a / 2 for the corner's u, a for slope times w (each has an error of a / 2),
/// and a for their difference. It also adds 2 a for the shift (up to 4), and 4 a for the last
/// difference (up to 6); a / 2 more without fused operations. TetRays::place_error is added. Other
/// rays miss all cells by far more than this error.
inline constexpr float rounded_place = 0x1p-20f;

/// More than the error of a value or a level in a cluster's frame: 2^-25 and 2^-24.
inline constexpr float rounded_value = 0x1p-22f;

class TetCells {
 public:
  HWY_INLINE TetCells(const TetMaximumField& field, const RayArrays& rays, const TetRays& group, TetScratch& scratch)
      : suspects(field, rays, group, scratch),
        field_(field),
        rays_(rays),
        group_(group),
        scratch_(scratch),
        clusters_(field, scratch) {}

  TetSuspects suspects;
  std::uint64_t looks = 0;  ///< cells tested against 16 rays

  /// Searches a cluster for suspects.
  /// @param lanes  that may hit it
  void look_into(std::uint64_t cluster, std::uint64_t lanes) {
    const LocalCluster& local = clusters_.made_ready(cluster);
    place_error_ = rounded_place + static_cast<float>(group_.place_error * local.scale) * 1.01f;
    if (!(place_error_ < 0x1p-3f)) return suspect_all(local, lanes);
    lanes = enter(local, lanes);
    if (lanes == 0) return;
    encode(local, lanes);
    compare_cells(local, lanes);
    leave(local, lanes);
  }

 private:
  /// Margin subtracted for rounding where a share of a cluster's range becomes a value.
  HWY_INLINE static double slack(const LocalCluster& local) { return 0x1p-50 * (std::abs(local.lowest) + local.range); }

  /// For rays that start so far away, in sizes of the cluster, that single precision cannot decide
  /// anything.
  HWY_NOINLINE void suspect_all(const LocalCluster& local, std::uint64_t lanes) {
    const std::uint64_t first = local.cluster * field_.cluster_size;
    for (std::uint64_t cell = first; cell < first + field_.cluster_size && cell < field_.cell_count; ++cell) {
      ++looks;
      for (std::uint64_t bits = lanes; bits != 0; bits &= bits - 1)
        suspects.add(local.highest, cell, static_cast<std::size_t>(std::countr_zero(bits)));
      suspects.make_room();
    }
  }

  /// Returns those lanes that found the cluster's largest value before they reach it.
  HWY_INLINE std::uint64_t satisfied(const LocalCluster& local, std::uint64_t lanes) const {
    const auto edge = [&](float at) { return local.center[group_.w] + at / local.scale; };
    const double low = edge(local.low[group_.w]), high = edge(local.high[group_.w]);
    std::uint64_t done = 0;
    for (std::uint64_t bits = lanes; bits != 0; bits &= bits - 1) {
      const std::size_t lane = static_cast<std::size_t>(std::countr_zero(bits)), ray = ray_of(lane);
      if (scratch_.found[ray].value != local.highest) continue;
      const double origin = rays_.origin[group_.w][ray], direction = rays_.direction[group_.w][ray];
      const double a = (low - origin) / direction, b = (high - origin) / direction, near = a < b ? a : b;
      if (near - 0x1p-48 * std::abs(near) > scratch_.found[ray].t) done |= std::uint64_t{1} << lane;
    }
    return done;
  }

  /// Computes shifts and levels of the rays in the cluster's frame.
  /// @return  the lanes that may find more than they have reached
  HWY_INLINE std::uint64_t enter(const LocalCluster& local, std::uint64_t lanes) {
    const VecD scale = hn::Set(doubles, local.scale), lowest = hn::Set(doubles, local.lowest);
    const auto center = [&](int axis) { return local.center[axis] - group_.middle[axis]; };
    const VecD at_w = hn::Set(doubles, center(group_.w));
    const int minor[2] = {group_.u, group_.v};
    const double margin = place_error_ / local.scale;
    const VecD low_w = hn::Set(doubles, center(group_.w) + local.low[group_.w] / local.scale - margin),
               high_w = hn::Set(doubles, center(group_.w) + local.high[group_.w] / local.scale + margin);
    std::uint64_t in_reach = 0, at_highest = 0;
    for (std::size_t r = 0; r < TetScratch::lanes; r += double_lanes) {
      if ((lanes >> r & double_bits) == 0) continue;
      for (int m = 0; m < 2; ++m) {
        const VecD place = hn::Sub(
            hn::MulAdd(hn::Load(doubles, scratch_.slope[m] + r), at_w, hn::Load(doubles, scratch_.shift[m] + r)),
            hn::Set(doubles, center(minor[m])));
        hn::Store(hn::DemoteTo(half_floats, hn::Mul(place, scale)), half_floats, scratch_.place[m] + r);
      }
      const VecD begin = hn::Load(doubles, scratch_.begin + r), end = hn::Load(doubles, scratch_.end + r);
      const auto along = [&](VecD x) HWY_ATTR {
        const VecD moved = hn::Mul(hn::Sub(x, at_w), scale), four = hn::Set(doubles, 4.0);
        return hn::DemoteTo(half_floats, hn::Max(hn::Min(moved, four), hn::Neg(four)));
      };
      if (!group_.go_through) {
        hn::Store(along(begin), half_floats, scratch_.local_begin + r);
        hn::Store(along(end), half_floats, scratch_.local_end + r);
      }
      const VecD reached = hn::Load(doubles, scratch_.reached + r);
      in_reach |= bits_of(doubles, hn::And(hn::Le(reached, hn::Set(doubles, local.highest)),
                                           hn::And(hn::Le(begin, high_w), hn::Ge(end, low_w))))
                  << r;
      at_highest |= bits_of(doubles, hn::Eq(reached, hn::Set(doubles, local.highest))) << r;
      const VecD over = hn::Mul(hn::Sub(hn::Max(reached, lowest), lowest), hn::Set(doubles, local.per_range));
      const auto level = hn::DemoteTo(half_floats, hn::Min(over, hn::Set(doubles, 1.0)));
      hn::Store(hn::Max(hn::Sub(level, hn::Set(half_floats, 0x1p-23f)), hn::Zero(half_floats)), half_floats,
                scratch_.level + r);
    }
    lanes &= in_reach;
    if ((lanes & at_highest) != 0) lanes &= ~satisfied(local, lanes & at_highest);
    return lanes;
  }

  /// Computes for each vertex one byte per pack. Its bits tell on which sides of the pack's rays
  /// the vertex is; sides are axis-aligned or diagonal. One bit tells whether all of the pack's
  /// rays have already reached its value. A cell whose vertices have a bit in common is not hit by
  /// the pack.
  HWY_INLINE void encode(const LocalCluster& local, std::uint64_t lanes) {
    float offset[16], slope[16], least[4];
    std::uint32_t absent = 0;
    const double at_w = local.center[group_.w] - group_.middle[group_.w];
    const double at[2] = {local.center[group_.u] - group_.middle[group_.u],
                          local.center[group_.v] - group_.middle[group_.v]};
    for (std::size_t p = 0; p < TetScratch::packs; ++p) {
      const std::uint64_t in_pack = lanes >> TetScratch::pack * p & pack_bits;
      if (in_pack == 0) {
        absent |= 0xffU << 8 * p;
        continue;
      }
      for (std::size_t l = 0; l < 4; ++l) {
        const double side = l % 2 == 0 ? -1 : 1;
        const double there = scratch_.line_offset[4 * p + l] + scratch_.line_slope[4 * p + l] * at_w - side * at[l / 2];
        offset[4 * p + l] = static_cast<float>(there * local.scale) + 2 * place_error_;
        slope[4 * p + l] = static_cast<float>(scratch_.line_slope[4 * p + l]);
      }
      least[p] = least_level(p, in_pack) - 2 * rounded_value;
    }
    for (std::size_t i = 0; i < local.vertex_count; i += float_lanes) {
      const VecF u = hn::Load(floats, local.place[group_.u] + i), v = hn::Load(floats, local.place[group_.v] + i);
      const VecF w = hn::Load(floats, local.place[group_.w] + i), value = hn::Load(floats, local.value + i);
      VecC code = hn::Set(codes, absent);
      for (std::size_t p = 0; p < TetScratch::packs; ++p) {
        if ((absent >> 8 * p & 1) != 0) continue;
        const auto note = [&](MaskF beside, int bit) HWY_ATTR {
          const VecC bits = hn::Set(codes, 1U << (8 * p + static_cast<std::size_t>(bit)));
          code = hn::Or(code, hn::IfThenElseZero(hn::RebindMask(codes, beside), bits));
        };
        const auto bound = [&](std::size_t l) HWY_ATTR {
          return hn::MulAdd(hn::Set(floats, slope[4 * p + l]), w, hn::Set(floats, offset[4 * p + l]));
        };
        const VecF inside[4] = {hn::Add(bound(0), u), hn::Sub(bound(1), u), hn::Add(bound(2), v), hn::Sub(bound(3), v)};
        const VecF zero = hn::Zero(floats);
        for (std::size_t l = 0; l < 4; ++l) note(hn::Lt(inside[l], zero), static_cast<int>(l));
        note(hn::Lt(value, hn::Set(floats, least[p])), 4);
        // Outside the diagonals of three of the four corners that the sides form: a byte has no
        // room for the last.
        note(hn::Lt(hn::Add(inside[0], inside[2]), zero), 5);
        note(hn::Lt(hn::Add(inside[1], inside[3]), zero), 6);
        note(hn::Lt(hn::Add(inside[0], inside[3]), zero), 7);
      }
      hn::Store(code, codes, scratch_.codes + i);
    }
  }

  HWY_INLINE float least_level(std::size_t p, std::uint64_t in_pack) const {
    VecF least = hn::Set(floats, 2.0f);
    for (std::size_t i = 0; i < TetScratch::pack; i += float_lanes)
      least = hn::Min(least, hn::IfThenElse(mask_of(floats, in_pack >> i),
                                            hn::Load(floats, scratch_.level + TetScratch::pack * p + i), least));
    return hn::GetLane(hn::MinOfLanes(floats, least));
  }

  HWY_INLINE void compare_cells(const LocalCluster& local, std::uint64_t lanes) {
    changed_ = 0;
    const std::uint64_t first = local.cluster * field_.cluster_size;
    const std::uint64_t left = field_.cell_count - first;
    const std::size_t count = left < field_.cluster_size ? left : field_.cluster_size;
    const std::uint8_t* const corners = field_.corners + 4 * first;
    constexpr bool has_gathers = float_lanes >= 8;
    if (!has_gathers || count % float_lanes != 0) {
      for (std::size_t c = 0; c < count; ++c) {
        const std::uint8_t* const corner = corners + 4 * c;
        const std::uint32_t common = scratch_.codes[corner[0]] & scratch_.codes[corner[1]] & scratch_.codes[corner[2]] &
                                     scratch_.codes[corner[3]];
        const std::uint32_t packs = ~(((common & 0x7f7f7f7fU) + 0x7f7f7f7fU) | common | 0x7f7f7f7fU);
        if (packs != 0) compare_with_packs(local, corner, first + c, packs, lanes);
      }
      return;
    }
#if HWY_TARGET <= HWY_AVX3 && HWY_TARGET != HWY_SCALAR
    if (local.vertex_count <= 4 * float_lanes) {
      const VecC table[4] = {hn::Load(codes, scratch_.codes), hn::Load(codes, scratch_.codes + float_lanes),
                             hn::Load(codes, scratch_.codes + 2 * float_lanes),
                             hn::Load(codes, scratch_.codes + 3 * float_lanes)};
      return compare_those_met(local, first, count, lanes, [&](VecC corner) HWY_ATTR {
        const auto place = hn::IndicesFromVec(codes, hn::And(corner, hn::Set(codes, 15U)));
        const MaskC is_odd = hn::TestBit(corner, hn::Set(codes, 16U)),
                    is_high = hn::TestBit(corner, hn::Set(codes, 32U));
        const auto either = [&](int t) HWY_ATTR {
          return hn::IfThenElse(is_odd, hn::TableLookupLanes(table[t + 1], place),
                                hn::TableLookupLanes(table[t], place));
        };
        return hn::IfThenElse(is_high, either(2), either(0));
      });
    }
#endif
    compare_those_met(local, first, count, lanes, [&](VecC corner) HWY_ATTR {
      return hn::GatherIndex(codes, scratch_.codes, hn::BitCast(ints, hn::And(corner, hn::Set(codes, 0xffU))));
    });
  }

  /// @param code_of  (vector of corners): codes of the vertices in their lowest bytes
  template <class CodeOf>
  HWY_INLINE void compare_those_met(const LocalCluster& local, std::uint64_t first, std::size_t count,
                                    std::uint64_t lanes, const CodeOf& code_of) {
    const VecC without_top = hn::Set(codes, 0x7f7f7f7fU);
    const std::uint8_t* const corners = field_.corners + 4 * first;
    for (std::size_t c = 0; c < count; c += float_lanes) {
      HWY_ALIGN std::uint32_t corners_of[float_lanes];
      std::memcpy(corners_of, corners + 4 * c, sizeof corners_of);
      const VecC corner = hn::Load(codes, corners_of);
      const VecC common = hn::And(hn::And(code_of(corner), code_of(hn::ShiftRight<8>(corner))),
                                  hn::And(code_of(hn::ShiftRight<16>(corner)), code_of(hn::ShiftRight<24>(corner))));
      // 0x80 in every byte that is zero.
      const VecC packs =
          hn::Not(hn::Or(hn::Or(hn::Add(hn::And(common, without_top), without_top), common), without_top));
      HWY_ALIGN std::uint32_t packs_of[float_lanes];
      hn::Store(packs, codes, packs_of);
      for (std::uint64_t bits = bits_of(codes, hn::Ne(packs, hn::Zero(codes))); bits != 0; bits &= bits - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(bits));
        compare_with_packs(local, corners + 4 * (c + i), first + c + i, packs_of[i], lanes);
      }
    }
  }

  /// @param packs  0x80 in the byte of each pack that may hit the cell
  HWY_INLINE void compare_with_packs(const LocalCluster& local, const std::uint8_t* corner, std::uint64_t cell,
                                     std::uint32_t packs, std::uint64_t lanes) {
    Corners at;
    if (!take_corners(local, corner, at)) return;
    for (; packs != 0; packs &= packs - 1) {
      const auto p = static_cast<std::size_t>(std::countr_zero(packs)) / 8;
      compare(local, at, cell, p, lanes >> TetScratch::pack * p & pack_bits);
    }
    suspects.make_room();
  }

  HWY_INLINE static float larger(float a, float b) {
    return a > b ? a : b;
  }

  struct Corners {
    float u[4], v[4], w[4], value[4];
    float largest;  ///< of values
  };

  /// @return  false where a value is missing
  HWY_INLINE bool take_corners(const LocalCluster& local, const std::uint8_t* corner, Corners& at) const {
    const float *const u = local.place[group_.u], *const v = local.place[group_.v], *const w = local.place[group_.w];
    for (int i = 0; i < 4; ++i)
      at.u[i] = u[corner[i]], at.v[i] = v[corner[i]], at.w[i] = w[corner[i]], at.value[i] = local.value[corner[i]];
    at.largest = larger(larger(at.value[0], at.value[1]), larger(at.value[2], at.value[3]));
    bool has_values = true;
    // NaN or infinite where there is no data.
    if (field_.has_gaps)
      for (const float value : at.value) has_values = has_values && std::abs(value) <= 2;
    return has_values;
  }

  /// The six edges of a cell as seen along a ray, and by how much its values exceed the ray's
  /// level. `left` is set where the edge from the lower to the higher corner may pass left of the
  /// ray, `right` where it may pass right of it.
  struct Seen {
    VecF edge[6], over[4];
    MaskF left[6], right[6];
    VecF edge_error, sum_error;
  };
  struct Face {
    int corner[3];
    int edge[3];  ///< edges j k, i k, i j
  };
  static constexpr int edge_from[6] = {0, 0, 0, 1, 1, 2}, edge_to[6] = {1, 2, 3, 2, 3, 3};
  static constexpr Face faces[4] = {
      {{1, 2, 3}, {5, 4, 3}}, {{0, 2, 3}, {5, 2, 1}}, {{0, 1, 3}, {4, 2, 0}}, {{0, 1, 2}, {3, 1, 0}}};

  /// The sum of the corners' values over the level, weighted by the opposite areas. It has the sign
  /// of the value over the level where the ray passes the face, or the opposite sign.
  HWY_INLINE static VecF weighted(const Seen& seen, const Face& face) {
    return hn::MulAdd(seen.edge[face.edge[0]], seen.over[face.corner[0]],
                      hn::NegMulAdd(seen.edge[face.edge[1]], seen.over[face.corner[1]],
                                    hn::Mul(seen.edge[face.edge[2]], seen.over[face.corner[2]])));
  }
  HWY_INLINE static MaskF turns_left(const Seen& seen, const Face& face) {
    return hn::And(hn::And(seen.left[face.edge[0]], seen.left[face.edge[2]]), seen.right[face.edge[1]]);
  }
  HWY_INLINE static MaskF turns_right(const Seen& seen, const Face& face) {
    return hn::And(hn::And(seen.right[face.edge[0]], seen.right[face.edge[2]]), seen.left[face.edge[1]]);
  }

  /// Tests a cell against the rays of a pack.
  HWY_NOINLINE void compare(const LocalCluster& local, const Corners& at, std::uint64_t cell, std::size_t p,
                            std::uint64_t in_pack) {
    ++looks;
    const VecF error = hn::Set(floats, place_error_), minus_error = hn::Set(floats, -place_error_);
    for (std::size_t i = 0; i < TetScratch::pack; i += float_lanes) {
      const std::size_t r = TetScratch::pack * p + i;
      const VecF slope_u = hn::Load(floats, scratch_.tree_slope[0] + r),
                 shift_u = hn::Load(floats, scratch_.place[0] + r);
      const VecF slope_v = hn::Load(floats, scratch_.tree_slope[1] + r),
                 shift_v = hn::Load(floats, scratch_.place[1] + r);
      VecF x[4], y[4];
      for (int c = 0; c < 4; ++c) {
        const VecF w = hn::Set(floats, at.w[c]);
        x[c] = hn::Sub(hn::NegMulAdd(slope_u, w, hn::Set(floats, at.u[c])), shift_u);
        y[c] = hn::Sub(hn::NegMulAdd(slope_v, w, hn::Set(floats, at.v[c])), shift_v);
      }
      const VecF left = hn::Min(hn::Min(x[0], x[1]), hn::Min(x[2], x[3]));
      const VecF right = hn::Max(hn::Max(x[0], x[1]), hn::Max(x[2], x[3]));
      const VecF below = hn::Min(hn::Min(y[0], y[1]), hn::Min(y[2], y[3]));
      const VecF above = hn::Max(hn::Max(y[0], y[1]), hn::Max(y[2], y[3]));
      const VecF level = hn::Load(floats, scratch_.level + r);
      const MaskF gains =
          hn::And(mask_of(floats, in_pack >> i), hn::Le(level, hn::Set(floats, at.largest + 2 * rounded_value)));
      const MaskF near =
          hn::And(hn::And(gains, hn::Le(hn::Max(left, below), error)), hn::Ge(hn::Min(right, above), minus_error));
      if (hn::AllFalse(floats, near)) continue;

      // Positions here are at most `size`. The error of an edge function covers products of
      // positions and errors, products of two errors, and the rounding of two products and a
      // difference.
      const VecF size = hn::Max(hn::Max(right, hn::Neg(left)), hn::Max(above, hn::Neg(below)));
      const VecF per_size = hn::MulAdd(hn::Set(floats, 0x1.1p-22f), size, hn::Set(floats, 4.1f * place_error_));
      Seen seen;
      seen.edge_error = hn::MulAdd(per_size, size, hn::Set(floats, 2.1f * place_error_ * place_error_));
      // Three weights have that error, values over the level one of 2^-23, sums are rounded; the
      // scalar kernel's means too.
      seen.sum_error = hn::MulAdd(hn::Mul(size, size), hn::Set(floats, 0x1p-19f + local.value_error),
                                  hn::Mul(hn::Set(floats, 3.1f), seen.edge_error));
      const VecF minus_edge_error = hn::Neg(seen.edge_error);
      for (int e = 0; e < 6; ++e) {
        const int a = edge_from[e], b = edge_to[e];
        seen.edge[e] = hn::NegMulAdd(y[a], x[b], hn::Mul(x[a], y[b]));
        seen.left[e] = hn::Ge(seen.edge[e], minus_edge_error);
        seen.right[e] = hn::Le(seen.edge[e], seen.edge_error);
      }
      for (int c = 0; c < 4; ++c) seen.over[c] = hn::Sub(hn::Set(floats, at.value[c]), level);
      const VecF minus_sum_error = hn::Neg(seen.sum_error);
      MaskF doubtful = no_lane(floats);
      for (const Face& face : faces) {
        const VecF sum = weighted(seen, face);
        const MaskF left_up = hn::And(turns_left(seen, face), hn::Ge(sum, minus_sum_error));
        const MaskF right_up = hn::And(turns_right(seen, face), hn::Le(sum, seen.sum_error));
        doubtful = hn::Or(doubtful, hn::Or(left_up, right_up));
      }
      doubtful = hn::And(doubtful, near);
      if (!hn::AllFalse(floats, doubtful)) note(local, seen, doubtful, at, cell, r);
    }
  }

  /// Records bounds of the values of suspects; the lower bounds raise the rays' levels.
  HWY_NOINLINE void note(const LocalCluster& local, const Seen& seen, MaskF doubtful, const Corners& at,
                         std::uint64_t cell, std::size_t r) {
    MaskF whole = doubtful;  // rays that go through all of the cell
    if (!group_.go_through) {
      whole = clip(at, r, doubtful);
      if (hn::AllFalse(floats, doubtful)) return;
    }
    const VecF zero = hn::Zero(floats), level = hn::Load(floats, scratch_.level + r);
    const VecF weight_error = hn::Mul(hn::Set(floats, 3.1f), seen.edge_error);
    VecF most = zero, least = zero;
    for (const Face& face : faces) {
      const VecF sum = weighted(seen, face);
      const MaskF to_left = turns_left(seen, face), to_right = turns_right(seen, face);
      const VecF up =
          hn::IfThenElse(hn::And(to_left, to_right), hn::Abs(sum), hn::IfThenElse(to_left, sum, hn::Neg(sum)));
      const VecF weight = hn::Add(hn::Add(hn::Abs(seen.edge[face.edge[0]]), hn::Abs(seen.edge[face.edge[1]])),
                                  hn::Abs(seen.edge[face.edge[2]]));
      const VecF smaller = hn::Sub(weight, weight_error);
      const VecF high =
          hn::IfThenElse(hn::Gt(smaller, zero), hn::Div(hn::Add(up, seen.sum_error), smaller), hn::Set(floats, 2.0f));
      most = hn::Max(most, hn::IfThenElseZero(hn::Or(to_left, to_right), high));
      // A face is certainly passed where each edge passes on one side only, and the orientation is
      // the same.
      const MaskF sure_left =
          hn::Not(hn::Or(hn::Or(seen.right[face.edge[0]], seen.right[face.edge[2]]), seen.left[face.edge[1]]));
      const MaskF sure_right =
          hn::Not(hn::Or(hn::Or(seen.left[face.edge[0]], seen.left[face.edge[2]]), seen.right[face.edge[1]]));
      const VecF low = hn::Div(hn::Sub(up, seen.sum_error), hn::Add(weight, weight_error));
      least = hn::Max(least, hn::IfThenElseZero(hn::Or(sure_left, sure_right), low));
    }
    most = hn::Add(hn::Min(hn::Add(level, most), hn::Set(floats, at.largest)), hn::Set(floats, rounded_value));
    const VecF raised =
        hn::Sub(hn::MulAdd(least, hn::Set(floats, 1 - 0x1p-20f), level), hn::Set(floats, rounded_value));
    const MaskF rises = hn::And(whole, hn::Gt(raised, level));
    const VecF now = hn::IfThenElse(rises, raised, level);
    hn::Store(now, floats, scratch_.level + r);
    changed_ |= bits_of(floats, rises) << r;
    HWY_ALIGN float most_of[float_lanes];
    hn::Store(most, floats, most_of);
    const double above = slack(local);
    for (std::uint64_t bits = bits_of(floats, doubtful); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      const double most_value = local.lowest + static_cast<double>(most_of[lane]) * local.range + above;
      suspects.add(local.per_range > 0 ? most_value : local.highest, cell, r + lane);
    }
  }

  /// Removes from `doubtful` the rays that end before the cell, or begin behind it.
  /// @return  the others that begin before it and end behind it
  HWY_INLINE MaskF clip(const Corners& at, std::size_t r, MaskF& doubtful) const {
    // The positions where rays begin and end have at most the error of other positions; times in
    // the scalar kernel have as much again.
    const float margin = 2 * place_error_;
    const VecF begin = hn::Load(floats, scratch_.local_begin + r), end = hn::Load(floats, scratch_.local_end + r);
    const float w_high = larger(larger(at.w[0], at.w[1]), larger(at.w[2], at.w[3]));
    const float w_low = -larger(larger(-at.w[0], -at.w[1]), larger(-at.w[2], -at.w[3]));
    doubtful = hn::And(doubtful, hn::And(hn::Le(begin, hn::Set(floats, w_high + margin)),
                                         hn::Ge(end, hn::Set(floats, w_low - margin))));
    return hn::And(doubtful, hn::And(hn::Le(begin, hn::Set(floats, w_low - margin)),
                                     hn::Ge(end, hn::Set(floats, w_high + margin))));
  }

  HWY_INLINE void leave(const LocalCluster& local, std::uint64_t lanes) {
    for (std::uint64_t bits = changed_ & lanes; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      const double reached = local.lowest + static_cast<double>(scratch_.level[lane]) * local.range - slack(local);
      if (reached > scratch_.reached[lane]) suspects.raise(lane, reached);
    }
  }

  static constexpr std::uint64_t pack_bits = (std::uint64_t{1} << TetScratch::pack) - 1;
  static constexpr std::uint64_t double_bits = (std::uint64_t{1} << double_lanes) - 1;

  const TetMaximumField& field_;
  const RayArrays& rays_;
  const TetRays& group_;
  TetScratch& scratch_;
  TetClusters clusters_;
  float place_error_ = 0;
  std::uint64_t changed_ = 0;  ///< lanes whose level was raised
};

}  // namespace
}  // namespace rhoray::render::wide::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
