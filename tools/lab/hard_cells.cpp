#include "tools/lab/hard_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rhoray::study {

namespace {

Vec3 any_point(Dice& dice) {
  return {dice.unit(), dice.unit(), dice.unit()};
}

/// A point of the face on the given side of an axis.
Vec3 point_on_face(Dice& dice, int axis, bool upper) {
  Vec3 p = any_point(dice);
  p[axis] = upper ? 1 : 0;
  return p;
}

/// Chooses a chord from one face to another.
void choose_chord(Dice& dice, CellCase& made) {
  const int first = dice.below(6), second = (first + 1 + dice.below(5)) % 6;
  made.p0 = point_on_face(dice, first / 2, first % 2 == 1);
  made.p1 = point_on_face(dice, second / 2, second % 2 == 1);
}

CellCase any_cell(Dice& dice) {
  CellCase made;
  for (double& f : made.cell.corner) f = dice.between(-1, 1);
  choose_chord(dice, made);
  made.isovalue = dice.between(-0.5, 0.5);
  return made;
}

/// The isovalue differs from an extremum inside the chord by 1 ulp to 1e-6 of the value, on either
/// side, or equals it.
CellCase near_tangent(Dice& dice) {
  for (;;) {
    CellCase made = any_cell(dice);
    const render::Cubic cubic = made.cell.along(made.p0, made.p1, 0);
    const render::Cubic::CriticalPoints critical = cubic.critical_points();
    if (critical.count == 0) continue;
    const double extremum = cubic.at(critical.s[static_cast<std::size_t>(dice.below(critical.count))]).value;
    const double share = dice.below(8) == 0 ? 0 : std::exp2(dice.between(-52, -20));
    made.isovalue = extremum * (1 + (dice.coin() ? share : -share));
    return made;
  }
}

/// The field b 2 s (1 - s) along the diagonal of a face, in any orientation, with its maximum b / 2
/// as isovalue.
CellCase double_root(Dice& dice) {
  CellCase made;
  const int u = dice.below(3), v = (u + 1 + dice.below(2)) % 3, w = 3 - u - v;
  const double a = dice.below(100) - 50, b = (1 + dice.below(50)) * (dice.coin() ? 1 : -1);
  for (std::size_t c = 0; c < 8; ++c) made.cell.corner[c] = a + (((c >> u) & 1) != ((c >> v) & 1) ? b : 0);
  made.p0[u] = made.p0[v] = 0;
  made.p1[u] = made.p1[v] = 1;
  made.p0[w] = dice.unit();
  made.p1[w] = dice.unit();
  made.isovalue = a + b / 2;
  return made;
}

CellCase axis_parallel(Dice& dice) {
  CellCase made = any_cell(dice);
  const int axis = dice.below(3);
  made.p0 = point_on_face(dice, axis, false);
  for (int other = 0; other < 3; ++other)
    made.p1[other] =
        other == axis ? 1 : std::clamp(made.p0[other] + dice.between(-1, 1) * std::exp2(-dice.below(60)), 0.0, 1.0);
  if (dice.coin()) std::swap(made.p0, made.p1);
  return made;
}

CellCase tiny_chord(Dice& dice) {
  CellCase made = any_cell(dice);
  const int axis = dice.below(3);
  made.p0 = point_on_face(dice, axis, false);
  const double length = std::exp2(dice.between(-40, -10));
  for (int a = 0; a < 3; ++a) made.p1[a] = std::clamp(made.p0[a] + length * dice.between(-1, 1), 0.0, 1.0);
  const double s = dice.unit();
  made.isovalue = made.cell.at((1 - s) * made.p0 + s * made.p1);
  return made;
}

CellCase large_offset(Dice& dice) {
  CellCase made = any_cell(dice);
  for (double& f : made.cell.corner) f += 1e6;
  made.isovalue += 1e6;
  return made;
}

/// Values of an 8-bit scan, with the isovalue one of them. Sometimes the chord meets edges and
/// corners.
CellCase whole_values(Dice& dice) {
  CellCase made;
  const int base = dice.below(250);
  for (double& f : made.cell.corner) f = base + dice.below(6);
  choose_chord(dice, made);
  if (dice.below(4) == 0)
    for (int axis = 0; axis < 3; ++axis) made.p0[axis] = std::round(made.p0[axis]);
  if (dice.below(4) == 0)
    for (int axis = 0; axis < 3; ++axis) made.p1[axis] = std::round(made.p1[axis]);
  made.isovalue = made.cell.corner[static_cast<std::size_t>(dice.below(8))];
  return made;
}

CellCase mixed_magnitudes(Dice& dice) {
  CellCase made = any_cell(dice);
  for (double& f : made.cell.corner) f *= std::exp2(dice.below(200) - 100);
  made.isovalue = dice.coin() ? 0 : dice.between(-1, 1) * std::exp2(dice.below(200) - 100);
  return made;
}

constexpr CellClass classes[] = {
    {"random", "corners in [-1, 1], from face to face", any_cell},
    {"near-tangent", "isovalue within 1e-6 of an extremum along the chord, down to 1 ulp", near_tangent},
    {"double-root", "isovalue exactly at the extremum", double_root},
    {"axis-parallel", "chords within 2^-60 to 1 of an axis", axis_parallel},
    {"tiny-chord", "chords of 1e-3 to 1e-12 of a cell, near the surface", tiny_chord},
    {"large-offset", "values 1e6 +- 1", large_offset},
    {"whole-values", "whole numbers, isovalue one of them, chords through corners too", whole_values},
    {"mixed-magnitudes", "values from 1e-30 to 1e30 in one cell", mixed_magnitudes}};

}  // namespace

std::span<const CellClass> cell_classes() {
  return classes;
}

}  // namespace rhoray::study
