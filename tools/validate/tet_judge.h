#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tools/validate/geometry.h"
#include "tools/validate/tet_field.h"

namespace rhoray::tools::validate {

/// Decides exactly where a ray crosses the isosurface of a field on tetrahedra: a change between value < isovalue and
/// value >= isovalue along the ray, on t >= 0, as the doubles of mesh and ray say it. Uncertain signs are decided in
/// rational numbers. Where the isovalue is met in one point from below that counts. May be asked from many threads.
class TetJudge {
 public:
  /// @param straddling  the cells with points on both sides; the field must outlive this
  TetJudge(const TetField& field, const std::vector<std::uint32_t>& straddling, double isovalue);
  ~TetJudge();
  TetJudge(TetJudge&&) noexcept;
  TetJudge& operator=(TetJudge&&) noexcept;

  struct Crossing {
    double t = 0;            ///< rounded from a number that is known to 1e-13 of itself, or exactly
    std::uint32_t cell = 0;  ///< one in which it lies
  };

  /// Where the ray crosses inside one cell.
  std::optional<double> crossing_in(const render::Ray& ray, std::uint32_t cell) const;

  /// The first crossing of all.
  std::optional<Crossing> first_crossing(const render::Ray& ray) const;

 private:
  struct Boxes;
  const TetField* field_;
  double isovalue_;
  std::unique_ptr<Boxes> boxes_;
};

}  // namespace rhoray::tools::validate
