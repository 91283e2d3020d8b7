#include "tests/hard_cases/trilinear_root_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rhoray::tests {

namespace {

using study::CellCase;

/// Chooses a chord between opposite faces of the cell, along a random axis.
void choose_chord(study::Dice& dice, CellCase& made) {
  const int axis = dice.below(3);
  made.p0 = {dice.unit(), dice.unit(), dice.unit()};
  made.p1 = {dice.unit(), dice.unit(), dice.unit()};
  made.p0[axis] = 0, made.p1[axis] = 1;
  if (dice.coin()) std::swap(made.p0, made.p1);
}

/// corner (i, j, k) = a + b i + c j + d k + e i j + f j k + g i k + h i j k; h alone makes the
/// cubic term.
CellCase from_terms(study::Dice& dice, const std::array<double, 8>& terms) {
  CellCase made;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const bool i = corner & 1, j = corner & 2, k = corner & 4;
    const std::array<bool, 8> counts{true, i, j, k, i && j, j && k, i && k, i && j && k};
    double sum = 0;
    for (std::size_t t = 0; t < 8; ++t) sum += counts[t] ? terms[t] : 0;
    made.cell.corner[corner] = sum;
  }
  choose_chord(dice, made);
  return made;
}

/// Sets the isovalue to the field's value at a random point of the chord.
void meet_the_chord(study::Dice& dice, CellCase& made) {
  const double s = dice.unit();
  made.isovalue = made.cell.at((1 - s) * made.p0 + s * made.p1);
}

/// A cubic term between one unit of rounding and a thousandth of the others, or none. Half of them
/// also lack or nearly lack quadratic terms.
CellCase hardly_cubic(study::Dice& dice) {
  std::array<double, 8> terms;
  for (double& t : terms) t = dice.between(-1, 1);
  terms[7] = dice.below(4) == 0 ? 0 : terms[7] * std::exp2(dice.between(-53, -10));
  if (dice.coin())
    for (std::size_t t = 4; t < 7; ++t) terms[t] *= dice.coin() ? 0 : std::exp2(dice.between(-53, -10));
  CellCase made = from_terms(dice, terms);
  meet_the_chord(dice, made);
  return made;
}

/// (s - r)^3 along the diagonal, as (x - r)(y - r)(z - r). The isovalue is 0, or differs from it by
/// one unit of rounding or more.
CellCase triple_root(study::Dice& dice) {
  CellCase made;
  const double r = dice.coin() ? std::exp2(-1 - dice.below(20)) : dice.between(0.01, 0.99);
  const double scale = std::exp2(dice.below(41) - 20);
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double product = scale;
    for (std::size_t axis = 0; axis < 3; ++axis) product *= (corner >> axis & 1 ? 1 : 0) - r;
    made.cell.corner[corner] = product;
  }
  made.p0 = Vec3(0), made.p1 = Vec3(1);
  if (dice.coin()) std::swap(made.p0, made.p1);
  if (dice.coin()) made.isovalue = scale * (dice.coin() ? 1 : -1) * std::exp2(dice.between(-60, -10));
  return made;
}

/// All corners have one value, except some that differ by up to three units in the last place. The
/// isovalue is one of these values.
CellCase flat(study::Dice& dice) {
  CellCase made;
  const double base = dice.between(-1, 1) * std::exp2(dice.below(41) - 20);
  for (double& f : made.cell.corner) {
    f = base;
    for (int step = dice.below(4); step > 0; --step) f = std::nextafter(f, dice.coin() ? HUGE_VAL : -HUGE_VAL);
  }
  if (dice.below(8) == 0) made.cell.corner.fill(base);
  choose_chord(dice, made);
  made.isovalue = made.cell.corner[static_cast<std::size_t>(dice.below(8))];
  return made;
}

/// The isovalue is the value at an end of the chord, or differs from it by one unit in the last
/// place. At either end, the change of side has hardly begun or hardly ended.
CellCase one_ulp_bracket(study::Dice& dice) {
  CellCase made;
  for (double& f : made.cell.corner) f = dice.between(-1, 1);
  choose_chord(dice, made);
  const double end = made.cell.at(dice.coin() ? made.p0 : made.p1);
  const int kind = dice.below(3);
  made.isovalue = kind == 0 ? end : std::nextafter(end, kind == 1 ? HUGE_VAL : -HUGE_VAL);
  return made;
}

constexpr study::CellClass classes[] = {
    {"hardly-cubic", "A, or A and B, near 0 or 0", hardly_cubic},
    {"triple-root", "a triple root, or three beside it", triple_root},
    {"flat", "values that differ by some units in the last place, or not at all", flat},
    {"one-ulp-bracket", "the isovalue beside the value at an end", one_ulp_bracket}};

}  // namespace

std::span<const study::CellClass> root_cells() {
  return classes;
}

}  // namespace rhoray::tests
