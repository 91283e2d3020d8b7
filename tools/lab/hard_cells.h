#pragma once

#include <cstdint>
#include <random>
#include <span>

#include "render/exact.h"

namespace rhoray::study {

/// A trilinear cell, a chord through it and an isovalue.
struct CellCase {
  render::TrilinearCell cell{};
  Vec3 p0, p1;
  double isovalue = 0;
};

/// Random numbers that are the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}

  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }  ///< in [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }
  int below(int count) { return static_cast<int>(random_() % static_cast<std::uint64_t>(count)); }
  bool coin() { return below(2) == 0; }

 private:
  std::mt19937_64 random_;
};

/// A method to make cells that are hard in one respect.
struct CellClass {
  const char* name;
  const char* story;
  CellCase (*make)(Dice&);
};

std::span<const CellClass> cell_classes();

}  // namespace rhoray::study
