#include "render/exact/ball.h"

namespace rhoray::render {

namespace {

/// The polar form of a cubic: its value with one argument for each step of de Casteljau's scheme.
Ball polar(const std::array<Ball, 4>& b, double s1, double s2, double s3) {
  const Ball w1{s1, 0}, w2{s2, 0}, w3{s3, 0};
  const Ball c0 = between(b[0], b[1], w1), c1 = between(b[1], b[2], w1), c2 = between(b[2], b[3], w1);
  return between(between(c0, c1, w2), between(c1, c2, w2), w3);
}

Ball third_of_sum(const Ball& a, const Ball& b, const Ball& c) {
  using namespace ball_detail;
  const double size = std::abs(a.middle) + std::abs(b.middle) + std::abs(c.middle);
  return {(a.middle + b.middle + c.middle) / 3,
          (a.radius + b.radius + c.radius) / 3 * (1 + 8 * unit) + 4 * unit * size};
}

}  // namespace

Ball BallCubic::at(double s) const {
  return polar(b, s, s, s);
}

BallCubic BallCubic::on(double l, double r) const {
  return {{polar(b, l, l, l), polar(b, l, l, r), polar(b, l, r, r), polar(b, r, r, r)}};
}

BallCubic along(const std::array<double, 8>& corner, double offset, const std::array<Ball, 3>& p0,
                const std::array<Ball, 3>& p1) {
  std::array<Ball, 8> f;
  for (std::size_t c = 0; c < 8; ++c) {
    f[c].middle = corner[c] - offset;
    f[c].radius = 2 * ball_detail::unit * std::abs(f[c].middle);
  }
  // Values at the corners of the box between p0 and p1: corner (a, b, c) at a + 2 b + 4 c.
  std::array<Ball, 8> g;
  std::array<Ball, 4> rows[2];
  for (std::size_t r = 0; r < 4; ++r) {
    rows[0][r] = between(f[2 * r], f[2 * r + 1], p0[0]);
    rows[1][r] = between(f[2 * r], f[2 * r + 1], p1[0]);
  }
  for (std::size_t a = 0; a < 2; ++a)
    for (std::size_t b = 0; b < 2; ++b) {
      const Ball& v = b == 0 ? p0[1] : p1[1];
      const Ball low = between(rows[a][0], rows[a][1], v), high = between(rows[a][2], rows[a][3], v);
      g[a + 2 * b] = between(low, high, p0[2]);
      g[a + 2 * b + 4] = between(low, high, p1[2]);
    }
  return {{g[0], third_of_sum(g[1], g[2], g[4]), third_of_sum(g[3], g[5], g[6]), g[7]}};
}

}  // namespace rhoray::render
