#include "render/frame/box_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/query/compiled_for.h"

namespace rhoray::render {

namespace {

constexpr double rounding = 0x1p-44;
constexpr double infinity = std::numeric_limits<double>::infinity();

Vec3 magnitudes(const Vec3& v) {
  return {std::abs(v.x), std::abs(v.y), std::abs(v.z)};
}

/// Upper bound on the magnitudes of the terms when a map is applied to v, whatever their signs.
Vec3 terms_of_vector(const Affine& map, const Vec3& v) {
  return std::abs(v.x) * magnitudes(map.x_axis) + std::abs(v.y) * magnitudes(map.y_axis) +
         std::abs(v.z) * magnitudes(map.z_axis);
}

/// The same for a cross product.
Vec3 terms_of_cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x};
}

template <class Act>
void for_each_corner(const Box3& box, const Act& act) {
  for (int corner = 0; corner < 8; ++corner)
    act(Vec3(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
             corner & 4 ? box.max.z : box.min.z));
}

}  // namespace

BoxProjection::BoxProjection(const CameraRays& camera, const Affine& data_from_world, const Affine& world_from_data,
                             const Box3& bounds)
    : eye_(data_from_world.point(camera.origin(0, 0))), orthographic_(camera.is_orthographic()) {
  const Vec3 f = data_from_world.vector(camera.forward()), u = data_from_world.vector(camera.across()),
             v = data_from_world.vector(camera.down());
  const Vec3 f_terms = terms_of_vector(data_from_world, camera.forward()),
             u_terms = terms_of_vector(data_from_world, camera.across()),
             v_terms = terms_of_vector(data_from_world, camera.down());

  // Magnitudes along the axes: of positions in the dataset, and of the eye transformed from world
  // units.
  Vec3 places =
      magnitudes(eye_) + magnitudes(data_from_world.origin) + terms_of_vector(data_from_world, camera.position());
  if (orthographic_) places += u_terms + v_terms;
  double reach = orthographic_ ? camera.across().length() + camera.down().length() : 0;
  Vec3 farthest(0, 0, 0);
  double distance = 0;
  for_each_corner(bounds, [&](const Vec3& corner) {
    for (int axis = 0; axis < 3; ++axis) farthest[axis] = std::max(farthest[axis], std::abs(corner[axis]));
    distance = std::max(distance, world_from_data.vector(corner - eye_).length());
  });
  reach += distance;
  places += farthest + terms_of_vector(data_from_world, Vec3(reach, reach, reach));

  const double det = f.dot(u.cross(v)), sign = det < 0 ? -1 : 1;
  const auto function = [&](const Vec3& a, const Vec3& b, const Vec3& a_terms, const Vec3& b_terms) {
    return Function{sign * a.cross(b), rounding * terms_of_cross(a_terms, b_terms).dot(places)};
  };
  depth_ = function(u, v, u_terms, v_terms);
  across_ = function(v, f, v_terms, f_terms);
  down_ = function(f, u, f_terms, u_terms);
  det_ = std::abs(det);
  det_slack_ = rounding * terms_of_cross(u_terms, v_terms).dot(f_terms);
  // Far from where products overflow or vanish; false for a NaN.
  const auto is_usual = [](double x) { return x > 0x1p-900 && x < 0x1p900; };
  is_certain_ = is_usual(det_) && det_ > 2 * det_slack_ && is_usual(depth_.slack) && is_usual(across_.slack) &&
                is_usual(down_.slack);
}

BoxProjection::OntoLattice::OntoLattice(const BoxProjection& projection, const SurfaceBoxes& boxes,
                                        const PixelLattice& lattice, Machine machine)
    : det_(projection.det_),
      det_slack_(projection.det_slack_),
      margin_(boxes.margin),
      orthographic_(projection.orthographic_),
      machine_(machine) {
  const auto function = [&](const BoxProjection::Function& of) {
    const Vec3 factor = boxes.unit * of.factor;
    return Function{{factor.x, factor.y, factor.z}, of.factor.dot(boxes.anchor - projection.eye_), of.slack};
  };
  depth_ = function(projection.depth_);
  across_ = function(projection.across_);
  down_ = function(projection.down_);
  // Pixel x has the picture coordinate (2 x + 1) / width - 1, and is column (x - x_first) /
  // spacing.
  const auto steps = [&](int size, int first) {
    return Steps{0.5 * size / lattice.spacing, (0.5 * size - 0.5 - first) / lattice.spacing};
  };
  columns_ = steps(lattice.width, lattice.x_first);
  rows_ = steps(lattice.height, lattice.y_first);
}

RHORAY_INLINE void BoxProjection::OntoLattice::project_inline(const OntoLattice& onto, const BoxNode& node,
                                                              ProjectedNode& out) {
  constexpr std::size_t size = BoxNode::size;
  constexpr double column_rounding = 0x1p-10;
  const OntoLattice by = onto;
  double corner[3][8][size], least[3][size], most[3][size];
  const Function* functions[3] = {&by.depth_, &by.across_, &by.down_};
  for (int q = 0; q < 3; ++q) {
    const Function& f = *functions[q];
    for (std::size_t i = 0; i < size; ++i) {
      const double x0 = f.factor[0] * (node.low[0][i] - by.margin_) + f.constant,
                   x1 = f.factor[0] * (node.high[0][i] + by.margin_) + f.constant;
      const double y0 = f.factor[1] * (node.low[1][i] - by.margin_), y1 = f.factor[1] * (node.high[1][i] + by.margin_);
      const double z0 = f.factor[2] * (node.low[2][i] - by.margin_), z1 = f.factor[2] * (node.high[2][i] + by.margin_);
      corner[q][0][i] = x0 + y0 + z0, corner[q][1][i] = x1 + y0 + z0;
      corner[q][2][i] = x0 + y1 + z0, corner[q][3][i] = x1 + y1 + z0;
      corner[q][4][i] = x0 + y0 + z1, corner[q][5][i] = x1 + y0 + z1;
      corner[q][6][i] = x0 + y1 + z1, corner[q][7][i] = x1 + y1 + z1;
      least[q][i] = (x0 < x1 ? x0 : x1) + (y0 < y1 ? y0 : y1) + (z0 < z1 ? z0 : z1) - f.slack;
      most[q][i] = (x0 > x1 ? x0 : x1) + (y0 > y1 ? y0 : y1) + (z0 > z1 ? z0 : z1) + f.slack;
    }
  }
  const auto bound = [&](int q, const Steps& steps, double* first, double* last) __attribute__((always_inline)) {
    const double slack = functions[q]->slack;
    const double divisor_slack = by.orthographic_ ? by.det_slack_ : by.depth_.slack;
    for (std::size_t i = 0; i < size; ++i) {
      double low = infinity, high = -infinity;
      for (int c = 0; c < 8; ++c) {
        const double place = corner[q][c][i] / (by.orthographic_ ? by.det_ : corner[0][c][i]);
        low = place < low ? place : low;
        high = place > high ? place : high;
      }
      const double least_divisor = by.orthographic_ ? by.det_ - by.det_slack_ : least[0][i];
      const double magnitude = -low > high ? -low : high;
      const double off = (slack + magnitude * divisor_slack) / least_divisor;
      // Whether all corners are in front of the eye.
      const bool in_front = by.orthographic_ || least_divisor > divisor_slack;
      const double open_low = least[q][i] > 0 ? least[q][i] / most[0][i] : -infinity;
      const double open_high = most[q][i] < 0 ? most[q][i] / most[0][i] : infinity;
      low = in_front ? low - off : open_low;
      high = in_front ? high + off : open_high;
      const bool exists = node.low[0][i] <= node.high[0][i] && !(most[0][i] < 0);
      first[i] = exists ? low * steps.scale + steps.offset - column_rounding : 1;
      last[i] = exists ? high * steps.scale + steps.offset + column_rounding : 0;
    }
  };
  bound(1, by.columns_, out.first_column, out.last_column);
  bound(2, by.rows_, out.first_row, out.last_row);
}

void BoxProjection::OntoLattice::project(const BoxNode& node, ProjectedNode& out) const {
  compiled_for<project_inline>(machine_)(*this, node, out);
}

}  // namespace rhoray::render
