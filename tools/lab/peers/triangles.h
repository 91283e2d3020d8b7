#pragma once

#include <memory>
#include <span>

#include "tools/lab/peers/peer.h"

class vtkPolyData;

namespace rhoray::study {

/// Triangles of an isosurface, extracted once for all systems that want them.
class Triangles {
 public:
  class Extractor;

  /// @param variant  tells this maker's triangles from others in the names of systems; may be empty
  Triangles(std::unique_ptr<Extractor> extractor, const std::string& maker, const std::string& variant);
  ~Triangles();

  const std::string& maker() const { return maker_; }  ///< "FlyingEdges"
  std::string named(const std::string& system) const;  ///< "Embree, packets", with the variant

  /// False where the maker gave up before the surface was whole.
  bool is_complete() const;

  /// Extracts the surface, unless that of this isovalue is there. Returns what extraction took, once and for this
  /// isovalue.
  Preparation extract(const PeerData& data, double isovalue);

  std::size_t vertex_count() const;
  std::size_t triangle_count() const;
  void copy_vertices(std::span<float> out) const;           ///< 3 numbers each
  void copy_triangles(std::span<std::uint32_t> out) const;  ///< 3 vertices each
  double memory_mb() const;
  vtkPolyData* vtk() const;

 private:
  std::unique_ptr<Extractor> extractor_;
  std::string maker_, variant_;
  std::optional<double> isovalue_;
  Preparation preparation_;
};

// Of grids: vtkFlyingEdges3D, vtkMarchingCubes, vtkSynchronizedTemplates3D.
std::shared_ptr<Triangles> flying_edges();
std::shared_ptr<Triangles> marching_cubes();
std::shared_ptr<Triangles> synchronized_templates();

/// Of a grid, by CGAL's surface mesher with the settings of `rhoray validate` (tools/validate/grid_surface.h).
/// @param facet_count  about so many triangles
std::shared_ptr<Triangles> cgal_mesher(double facet_count);

/// Of tetrahedra: vtkContour3DLinearGrid, which looks at every cell, or only where its tree of value ranges says.
std::shared_ptr<Triangles> linear_grid_contour(bool with_tree);

}  // namespace rhoray::study
