#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tools/validate/geometry.h"
#include "tools/validate/tet_field.h"

namespace rhoray::tools::validate {

/// Decides exactly where a ray crosses the isosurface of a field on tetrahedra. A crossing is a
/// change between value < isovalue and value >= isovalue along the ray, for t >= 0, computed from
/// the doubles of mesh and ray. Uncertain signs are decided in rational arithmetic. A single point
/// that reaches the isovalue from below counts. Safe to call from several threads.
class ExactTets {
 public:
  /// @param straddling  the cells with points on both sides; the field must outlive this
  ExactTets(const TetField& field, const std::vector<std::uint32_t>& straddling, double isovalue);
  ~ExactTets();
  ExactTets(ExactTets&&) noexcept;
  ExactTets& operator=(ExactTets&&) noexcept;

  struct Crossing {
    double t = 0;            ///< rounded; known exactly or up to a relative error of 1e-13
    std::uint32_t cell = 0;  ///< a cell that contains it
  };

  /// The ray's crossing inside one cell.
  std::optional<double> crossing_in(const render::Ray& ray, std::uint32_t cell) const;

  /// The first crossing in all cells.
  std::optional<Crossing> first_crossing(const render::Ray& ray) const;

 private:
  struct Boxes;
  const TetField* field_;
  double isovalue_;
  std::unique_ptr<Boxes> boxes_;
};

}  // namespace rhoray::tools::validate
