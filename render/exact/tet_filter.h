#pragma once

#include <optional>

#include "render/exact/ball.h"
#include "render/exact/exact_tet.h"
#include "render/traverse/ray.h"

/// Facts about tetrahedra along a ray that double precision proves.
namespace rhoray::render {

/// The values of t at which the ray enters and leaves, and value - isovalue there. `in` is
/// certainly before `out`, and all signs are certain.
struct CertainPassage {
  Ball t_in, t_out, value_in, value_out;
  const ExactTet* tet;
};

/// A tetrahedron that the ray may hit.
struct MetTet {
  const ExactTet* tet;
  Enclosure t;                            ///< range in which the ray may be in it
  std::optional<CertainPassage> passage;  ///< nothing when in doubt
};

/// Tests tetrahedra along the ray, in a picture plane in which the ray is at (0, 0). The ray must
/// outlive it.
class PicturePlane {
 public:
  PicturePlane(const Ray& ray, double isovalue);

  /// Returns nothing for a tetrahedron that the ray certainly misses.
  std::optional<MetTet> look(const ExactTet& tet) const;

 private:
  struct Vertex {
    Ball x, y, t, value;
  };
  enum class Seen { missed, passed, in_doubt };

  /// @param depth  of the vertices along the ray
  Seen look(const ExactTet& tet, CertainPassage& passage, Enclosure& depth) const;
  Vertex see(const Vec3& point, double value) const;
  /// Clips a passage to [t_min, t_max].
  Seen clip(CertainPassage& passage) const;

  const Ray& ray_;
  double isovalue_;
  int z_ = 0;
};

}  // namespace rhoray::render
