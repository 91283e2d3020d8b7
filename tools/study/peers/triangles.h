#pragma once

#include <memory>
#include <span>

#include "tools/study/peers/peer.h"

class vtkPolyData;

namespace rhoray::study {

/// The isosurface of vtkFlyingEdges3D, extracted once for all systems that want triangles.
class Triangles {
 public:
  Triangles();
  ~Triangles();

  /// Extracts the surface, unless that of this isovalue is there. Returns what extraction took in CPU milliseconds.
  double extract(const PeerData& data, double isovalue);

  std::size_t vertex_count() const;
  std::size_t triangle_count() const;
  void copy_vertices(std::span<float> out) const;           ///< 3 numbers each
  void copy_triangles(std::span<std::uint32_t> out) const;  ///< 3 vertices each
  double memory_mb() const;
  vtkPolyData* vtk() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace rhoray::study
