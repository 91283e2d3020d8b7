#include "data/recipes/torso_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

namespace rhoray::recipes::torso {

namespace {

constexpr double pi = std::numbers::pi;

/// The larger of two, rounded off where they differ by less than `width`.
double smooth_max(double a, double b, double width) {
  const double near = std::max(width - std::abs(a - b), 0.0);
  return std::max(a, b) + near * near / (4 * width);
}

/// A horizontal section of a body: an ellipse or superellipse around (0, middle_y).
struct Section {
  double z, half_x, half_y, middle_y;
};

/// The section at height z: a smooth curve through the table (Catmull-Rom tangents), constant
/// beyond its ends.
Section section_at(std::span<const Section> table, double z) {
  z = std::clamp(z, table.front().z, table.back().z);
  std::size_t i = 1;
  while (i + 1 < table.size() && table[i].z < z) ++i;
  const Section &a = table[i - 1], &b = table[i];
  const Section &before = table[i >= 2 ? i - 2 : 0], &after = table[std::min(i + 1, table.size() - 1)];
  const double length = b.z - a.z, t = (z - a.z) / length;
  const double h00 = (1 + 2 * t) * (1 - t) * (1 - t), h10 = t * (1 - t) * (1 - t);
  const double h01 = t * t * (3 - 2 * t), h11 = t * t * (t - 1);
  const auto blend = [&](double Section::*member) {
    const double slope_a = (b.*member - before.*member) / (b.z - before.z);
    const double slope_b = (after.*member - a.*member) / (after.z - a.z);
    return h00 * a.*member + h10 * length * slope_a + h01 * b.*member + h11 * length * slope_b;
  };
  return {z, blend(&Section::half_x), blend(&Section::half_y), blend(&Section::middle_y)};
}

/// Distance of p beyond the section's outline, measured along the line from its centre.
double beyond(const Section& s, const Vec3& p, double exponent) {
  const double x = p.x, y = p.y - s.middle_y;
  const double u = std::abs(x) / s.half_x, v = std::abs(y) / s.half_y;
  const double scaled =
      exponent == 2 ? std::sqrt(u * u + v * v) : std::pow(std::pow(u, exponent) + std::pow(v, exponent), 1 / exponent);
  const double radius = std::sqrt(x * x + y * y);
  // at the centre all directions are equal
  if (scaled < 1e-9) return -std::min(s.half_x, s.half_y);
  return radius - radius / scaled;
}

constexpr Section skin_table[] = {{-20, 172, 112, 0},  {0, 174, 114, 0},   {80, 178, 116, 2},  {170, 148, 99, 0},
                                  {260, 152, 104, -2}, {350, 164, 112, 0}, {430, 175, 114, 2}, {490, 186, 100, 8},
                                  {530, 166, 78, 14},  {560, 110, 62, 18}, {585, 68, 56, 18},  {610, 57, 54, 16},
                                  {660, 55, 54, 14}};
constexpr double body_height = 640;

constexpr Section cage_table[] = {{160, 114, 76, 2},  {250, 132, 86, 2}, {330, 138, 90, 2}, {400, 132, 86, 4},
                                  {460, 112, 72, 10}, {500, 84, 56, 16}, {525, 58, 42, 20}, {550, 30, 24, 22}};

Section cage_section(double z) {
  return section_at(cage_table, z);
}

/// Angle around the cage: 0 at the spine, pi at the sternum, symmetric.
double cage_angle(const Section& s, const Vec3& p) {
  return std::atan2(std::abs(p.x) / s.half_x, (p.y - s.middle_y) / s.half_y);
}

// Spine: half_x is the radius of the vertebral bodies, middle_y their centre, half_y unused (1).
constexpr Section spine_table[] = {{-20, 25, 1, 66}, {0, 25, 1, 66},   {100, 24, 1, 60}, {200, 21, 1, 63},
                                   {300, 18, 1, 68}, {400, 16, 1, 68}, {470, 14, 1, 62}, {530, 12, 1, 44},
                                   {600, 11, 1, 28}, {660, 11, 1, 26}};
constexpr double vertebra_pitch = 26;

double spine(const Vec3& p) {
  const Section s = section_at(spine_table, p.z);
  const double radius = s.half_x, along = p.z - vertebra_pitch * std::round(p.z / vertebra_pitch);
  const double from_axis = std::hypot(p.x, p.y - s.middle_y);
  const double body = smooth_max(from_axis - radius, std::abs(along) - 10, 4);
  const double canal_y = s.middle_y + radius + 6;
  const double arch = smooth_max(std::abs(std::hypot(p.x, p.y - canal_y) - 10) - 3, std::abs(along) - 8, 3);
  const double process_y = canal_y + 20;  // centre of the spinous process
  const double spinous = smooth_max(smooth_max(std::abs(p.x) - 3.5, std::abs(p.y - process_y) - 11, 3),
                                    std::abs(along + 0.3 * (p.y - canal_y)) - 6, 3);
  const double transverse =
      smooth_max(smooth_max(std::abs(p.x) - 15 - radius, std::abs(p.y - canal_y) - 4, 3), std::abs(along) - 5, 3);
  const double outside_canal = 7 - std::hypot(p.x, p.y - canal_y);
  const double arches = std::max(std::min({arch, spinous, transverse}), outside_canal);
  return smooth_max(std::min(body, arches), std::abs(p.z - body_height / 2) - (body_height / 2 - 8), 3);
}

struct Rib {
  double back_z;     // height at the spine
  double drop;       // how much lower it would reach the sternum
  double end_angle;  // angle where bone ends and cartilage begins
};

constexpr std::array<Rib, 12> ribs_table{{{515, 32, 0.95 * pi},
                                          {489, 42, 0.95 * pi},
                                          {463, 50, 0.95 * pi},
                                          {437, 56, 0.95 * pi},
                                          {411, 60, 0.95 * pi},
                                          {385, 62, 0.95 * pi},
                                          {359, 62, 0.94 * pi},
                                          {333, 62, 0.84 * pi},
                                          {307, 62, 0.76 * pi},
                                          {281, 60, 0.68 * pi},
                                          {255, 52, 0.48 * pi},
                                          {229, 44, 0.34 * pi}}};

double ribs(const Vec3& p, const Section& cage, double beyond_cage) {
  const double angle = cage_angle(cage, p), fall = (1 - std::cos(angle)) / 2;
  double nearest = 1e9;
  for (const Rib& rib : ribs_table) {
    const double above = 0.9 * (p.z - rib.back_z + rib.drop * fall);  // 0.9: ribs are inclined
    if (std::abs(above) > 30) continue;
    const double section = std::sqrt(beyond_cage * beyond_cage / (4.2 * 4.2) + above * above / (6.5 * 6.5));
    const double tube = 4.8 * (section - 1);
    nearest = std::min(nearest, smooth_max(tube, (angle - rib.end_angle) * cage.half_x, 4));
  }
  return nearest;
}

double sternum(const Vec3& p, double beyond_cage) {
  if (p.y > 0) return 1e9;
  // the manubrium, at the top, is wider
  const double half_width = 15 + 11 / (1 + std::exp((448 - p.z) / 6));
  const double plate = smooth_max(std::abs(beyond_cage) - 5, std::abs(p.x) - half_width, 4);
  return smooth_max(plate, std::abs(p.z - 390) - 92, 6);
}

double collar_bones(const Vec3& p) {
  const Vec3 from(20, -50, 482), to(150, 4, 506), mirrored(std::abs(p.x), p.y, p.z);
  const Vec3 along = to - from;
  const double t = std::clamp((mirrored - from).dot(along) / along.dot(along), 0.0, 1.0);
  const Vec3 bow(0, -8 * std::sin(2 * pi * t), 0);
  return (mirrored - (from + t * along + bow)).length() - 6;
}

double hip_bones(const Vec3& p) {
  const Section bowl{p.z, 118 + 0.25 * p.z, 76, 8};
  if (p.z > 120) return 1e9;
  const double angle = std::atan2(std::abs(p.x) / bowl.half_x, (p.y - bowl.middle_y) / bowl.half_y);
  const double from_crest = (angle - 0.42 * pi) / (0.34 * pi);
  const double blade = smooth_max(std::abs(beyond(bowl, p, 2)) - 4.5, p.z - 98 + 60 * from_crest * from_crest, 5);
  return smooth_max(blade, 10 - p.z, 5);
}

double lung(const Vec3& p, double side) {
  const Vec3 q(side * p.x, p.y, p.z);  // mirrored to the left side
  const double chest = rib_cage(p) + 11;
  if (chest > 40) return chest;
  const double mediastinum = 32 - 0.92 * q.x - 0.38 * q.y;
  const double dome = side > 0 ? 292 : 304;  // the liver lifts the diaphragm on the right
  const double diaphragm = 0.9 * (dome - 0.0035 * ((q.x - 75) * (q.x - 75) + q.y * q.y) - q.z);
  double d = smooth_max(chest, 10 - heart(p), 10);
  d = smooth_max(d, mediastinum, 14);
  d = smooth_max(d, diaphragm, 14);
  const Section vertebra = section_at(spine_table, p.z);
  d = smooth_max(d, vertebra.half_x + 8 - std::hypot(p.x, p.y - vertebra.middle_y), 10);
  return smooth_max(d, q.z - 505, 24);
}

}  // namespace

Vec3 heart_axis() {
  return Vec3(0.62, -0.55, -0.56).normalized();
}

double skin(const Vec3& p) {
  const double ends = std::abs(p.z - body_height / 2) - body_height / 2;
  return smooth_max(beyond(section_at(skin_table, p.z), p, 2.4), ends, 24);
}

double heart(const Vec3& p) {
  const Vec3 q = p - heart_centre;
  const double u = q.dot(heart_axis()), radius2 = q.dot(q);
  // an egg, thinner towards the apex
  const double girth = 43 * (1 - 0.2 * std::clamp(u / 60, -1.5, 1.5));
  const double scaled = std::sqrt(u * u / (60.0 * 60) + std::max(radius2 - u * u, 0.0) / (girth * girth));
  if (scaled < 1e-9) return -43;
  return std::sqrt(radius2) * (1 - 1 / scaled);
}

double rib_cage(const Vec3& p) {
  return smooth_max(beyond(cage_section(p.z), p, 2), p.z - 540, 20);
}

double left_lung(const Vec3& p) {
  return lung(p, 1);
}
double right_lung(const Vec3& p) {
  return lung(p, -1);
}

double bone(const Vec3& p) {
  const Section cage = cage_section(p.z);
  const double beyond_cage = beyond(cage, p, 2);
  return std::min({spine(p), ribs(p, cage, beyond_cage), sternum(p, beyond_cage), collar_bones(p), hip_bones(p)});
}

}  // namespace rhoray::recipes::torso
