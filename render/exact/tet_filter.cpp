#include "render/exact/tet_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace rhoray::render {

namespace {

/// Unbounded when an overflow has destroyed the limits.
Enclosure hull(const Enclosure& a, const Enclosure& b) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double lo = std::min(a.lo, b.lo), hi = std::max(a.hi, b.hi);
  const bool is_known = a.lo <= a.hi && b.lo <= b.hi;
  return is_known ? Enclosure{lo, hi} : Enclosure{-infinity, infinity};
}

}  // namespace

PicturePlane::PicturePlane(const Ray& ray, double isovalue) : ray_(ray), isovalue_(isovalue) {
  const Vec3& d = ray.direction;
  for (int axis = 1; axis < 3; ++axis)
    if (std::abs(d[axis]) > std::abs(d[z_])) z_ = axis;
}

std::optional<MetTet> PicturePlane::look(const ExactTet& tet) const {
  CertainPassage passage{};
  Enclosure depth{};
  const Seen seen = look(tet, passage, depth);
  if (seen == Seen::missed) return std::nullopt;
  if (seen == Seen::passed) return MetTet{&tet, hull(passage.t_in.enclosure(), passage.t_out.enclosure()), passage};
  return MetTet{&tet, depth, std::nullopt};
}

PicturePlane::Seen PicturePlane::look(const ExactTet& tet, CertainPassage& passage, Enclosure& depth) const {
  std::array<Vertex, 4> v;
  for (std::size_t i = 0; i < 4; ++i) v[i] = see(tet.point[i], tet.value[i]);
  depth = v[0].t.enclosure();
  for (std::size_t i = 1; i < 4; ++i) depth = hull(depth, v[i].t.enclosure());
  Ball edge[4][4];
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) edge[i][j] = v[i].x * v[j].y - v[i].y * v[j].x;

  std::size_t passed = 0;
  Vertex through[2];
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    const std::size_t i = left_out == 0 ? 1 : 0, j = left_out <= 1 ? 2 : 1, k = left_out == 3 ? 2 : 3;
    const Ball weights[] = {edge[j][k], Ball{-edge[i][k].middle, edge[i][k].radius}, edge[i][j]};
    const auto [least, most] = std::minmax({weights[0].sign(), weights[1].sign(), weights[2].sign()});
    if (least < 0 && most > 0) continue;           // passes beside this face
    if (least * most != 1) return Seen::in_doubt;  // a sign is not certain
    if (passed == 2) return Seen::in_doubt;
    const Ball sum = weights[0] + weights[1] + weights[2];
    through[passed].t = (weights[0] * v[i].t + weights[1] * v[j].t + weights[2] * v[k].t) / sum;
    through[passed].value = (weights[0] * v[i].value + weights[1] * v[j].value + weights[2] * v[k].value) / sum;
    ++passed;
  }
  if (passed == 0) return Seen::missed;
  if (passed != 2) return Seen::in_doubt;
  const int order = (through[1].t - through[0].t).sign();
  if (order == 0) return Seen::in_doubt;
  if (order < 0) std::swap(through[0], through[1]);
  passage = {through[0].t, through[1].t, through[0].value, through[1].value, &tet};
  return clip(passage);
}

PicturePlane::Vertex PicturePlane::see(const Vec3& point, double value) const {
  const int x = (z_ + 1) % 3, y = (z_ + 2) % 3;
  const auto from_origin = [&](int axis) { return Ball{point[axis]} - Ball{ray_.origin[axis]}; };
  const Ball t = from_origin(z_) / Ball{ray_.direction[z_]};
  return {from_origin(x) - t * Ball{ray_.direction[x]}, from_origin(y) - t * Ball{ray_.direction[y]}, t,
          Ball{value} - Ball{isovalue_}};
}

PicturePlane::Seen PicturePlane::clip(CertainPassage& passage) const {
  const CertainPassage whole = passage;
  const auto cut = [&](double limit, Ball& t, Ball& value) {
    const Ball share = (Ball{limit} - whole.t_in) / (whole.t_out - whole.t_in);
    t = Ball{limit};
    value = whole.value_in + share * (whole.value_out - whole.value_in);
  };
  const auto side_of = [](const Ball& t, double limit) {
    return std::isfinite(limit) ? (t - Ball{limit}).sign() : limit > 0 ? -1 : 1;
  };
  const int in_min = side_of(whole.t_in, ray_.t_min), in_max = side_of(whole.t_in, ray_.t_max);
  const int out_min = side_of(whole.t_out, ray_.t_min), out_max = side_of(whole.t_out, ray_.t_max);
  if (out_min < 0 || in_max > 0) return Seen::missed;
  if (in_min == 0 || in_max == 0 || out_min == 0 || out_max == 0) return Seen::in_doubt;
  if (in_min < 0) cut(ray_.t_min, passage.t_in, passage.value_in);
  if (out_max > 0) cut(ray_.t_max, passage.t_out, passage.value_out);
  return passage.value_in.sign() != 0 && passage.value_out.sign() != 0 ? Seen::passed : Seen::in_doubt;
}

}  // namespace rhoray::render
