#pragma once

#include <memory>
#include <span>

#include "tools/lab/peers/peer.h"

class vtkPolyData;

namespace rhoray::study {

/// Triangles of an isosurface, extracted once for all systems that use them.
class Triangles {
 public:
  class Extractor;

  /// @param variant  distinguishes this maker's triangles from others in the names of systems; may
  ///   be empty
  Triangles(std::unique_ptr<Extractor> extractor, const std::string& maker, const std::string& variant);
  ~Triangles();

  const std::string& maker() const { return maker_; }  ///< "FlyingEdges"
  std::string named(const std::string& system) const;  ///< "Embree, packets", with the variant

  /// False if the maker gave up before the surface was complete.
  bool is_complete() const;

  /// Extracts the surface, unless that of this isovalue exists already. Returns the time of
  /// extraction, once and for this isovalue.
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

// For grids: vtkFlyingEdges3D, vtkMarchingCubes, vtkSynchronizedTemplates3D.
std::shared_ptr<Triangles> flying_edges();
std::shared_ptr<Triangles> marching_cubes();
std::shared_ptr<Triangles> synchronized_templates();

/// For a grid, by CGAL's surface mesher with the settings of `rhoray validate`
/// (tools/validate/grid_surface.h).
/// @param facet_count  approximate number of triangles
std::shared_ptr<Triangles> cgal_mesher(double facet_count);

/// For tetrahedra: vtkContour3DLinearGrid, which examines every cell, or only those selected by its
/// tree of value ranges.
std::shared_ptr<Triangles> linear_grid_contour(bool with_tree);

}  // namespace rhoray::study
