#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

#include "preprocess/neutral.h"

namespace rhoray::tests {

using preprocess::CellKind;
using preprocess::CellMesh;

using Ids = std::vector<std::uint64_t>;

inline void add_cell(CellMesh& mesh, CellKind kind, const Ids& nodes) {
  mesh.kinds.push_back(kind);
  mesh.cell_nodes.insert(mesh.cell_nodes.end(), nodes.begin(), nodes.end());
  mesh.cell_offsets.push_back(mesh.cell_nodes.size());
}

/// A polyhedron by its faces.
inline void add_polyhedron(CellMesh& mesh, const std::vector<Ids>& faces) {
  Ids stream{faces.size()};
  for (const Ids& face : faces) {
    stream.push_back(face.size());
    stream.insert(stream.end(), face.begin(), face.end());
  }
  add_cell(mesh, CellKind::polyhedron, stream);
}

inline void add_field(CellMesh& mesh, const std::string& name, auto&& value_at) {
  preprocess::NeutralField field;
  field.name = name;
  field.was_single_precision = false;
  for (const auto& p : mesh.points) field.values.push_back(value_at(p[0], p[1], p[2]));
  mesh.point_fields.push_back(field);
}

/// Gives every point another number.
inline void shuffle_points(CellMesh& mesh, std::uint64_t seed) {
  Ids number(mesh.points.size());
  std::iota(number.begin(), number.end(), 0);
  std::mt19937_64 random(seed);
  std::shuffle(number.begin(), number.end(), random);
  const auto points = mesh.points;
  for (std::size_t p = 0; p < number.size(); ++p) mesh.points[number[p]] = points[p];
  for (preprocess::NeutralField& field : mesh.point_fields) {
    const auto values = field.values;
    for (std::size_t p = 0; p < number.size(); ++p) field.values[number[p]] = values[p];
  }
  for (std::size_t c = 0; c < mesh.kinds.size(); ++c) {
    std::uint64_t left_in_face = 0;
    for (std::uint64_t i = mesh.cell_offsets[c]; i < mesh.cell_offsets[c + 1]; ++i) {
      if (mesh.kinds[c] == CellKind::polyhedron && left_in_face == 0) {
        if (i == mesh.cell_offsets[c]) ++i;  // the face count
        left_in_face = mesh.cell_nodes[i];
        continue;
      }
      mesh.cell_nodes[i] = number[mesh.cell_nodes[i]];
      if (left_in_face > 0) --left_in_face;
    }
  }
}

/// The faces of a hexahedron, counter-clockwise from outside.
inline std::vector<Ids> hexahedron_faces(const Ids& h) {
  return {{h[0], h[4], h[7], h[3]}, {h[1], h[2], h[6], h[5]}, {h[0], h[1], h[5], h[4]},
          {h[3], h[7], h[6], h[2]}, {h[0], h[3], h[2], h[1]}, {h[4], h[5], h[6], h[7]}};
}

/// The box (0,0,0)-(n,n,n) filled with linear cells of every kind, glued face to face, under random
/// ids. Points inside are moved by up to `jitter`.
class MixedMesh {
 public:
  MixedMesh(std::uint64_t size, double jitter, std::uint64_t seed) : n_(size), random_(seed) {
    std::uniform_real_distribution<double> shift(-jitter, jitter);
    for (std::uint64_t k = 0; k <= n_; ++k)
      for (std::uint64_t j = 0; j <= n_; ++j)
        for (std::uint64_t i = 0; i <= n_; ++i) {
          std::array<double, 3> p{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
          const bool inside = i > 0 && j > 0 && k > 0 && i < n_ && j < n_ && k < n_;
          if (inside)
            for (double& x : p) x += shift(random_);
          mesh.points.push_back(p);
        }
    for (std::uint64_t j = 0; j < n_; ++j)
      for (std::uint64_t i = 0; i < n_;) i += add_columns(i, j);
    shuffle_points(mesh, seed + 1);
  }

  CellMesh mesh;

 private:
  std::uint64_t point(std::uint64_t i, std::uint64_t j, std::uint64_t k) const {
    return (k * (n_ + 1) + j) * (n_ + 1) + i;
  }

  Ids cube(std::uint64_t i, std::uint64_t j, std::uint64_t k) const {
    return {point(i, j, k),     point(i + 1, j, k),     point(i + 1, j + 1, k),     point(i, j + 1, k),
            point(i, j, k + 1), point(i + 1, j, k + 1), point(i + 1, j + 1, k + 1), point(i, j + 1, k + 1)};
  }

  /// Fills a column of cubes, or two side by side; returns how many.
  std::uint64_t add_columns(std::uint64_t i, std::uint64_t j) {
    const std::uint64_t choice = random_() % 5;
    const bool has_room = i + 1 < n_ && j % 2 == 0;  // no two cells share two faces
    for (std::uint64_t k = 0; k < n_; ++k) {
      const Ids h = cube(i, j, k);
      const Ids g = has_room ? cube(i + 1, j, k) : Ids{};
      if (choice == 0) {
        add_cell(mesh, CellKind::wedge, {h[0], h[1], h[2], h[4], h[5], h[6]});
        add_cell(mesh, CellKind::wedge, {h[0], h[3], h[2], h[4], h[7], h[6]});  // the other winding
      } else if (choice == 1 && has_room) {
        add_cell(mesh, CellKind::hexagonal_prism,
                 {h[0], h[1], g[1], g[2], h[2], h[3], h[4], h[5], g[5], g[6], h[6], h[7]});
      } else if (choice == 2 && has_room) {
        add_cell(mesh, CellKind::pentagonal_prism, {h[0], h[1], g[1], h[2], h[3], h[4], h[5], g[5], h[6], h[7]});
        add_cell(mesh, CellKind::wedge, {g[1], g[2], h[2], g[5], g[6], h[6]});
      } else {
        add_cube(h);
      }
    }
    return (choice == 1 || choice == 2) && has_room ? 2 : 1;
  }

  void add_cube(const Ids& h) {
    const std::vector<Ids> faces = hexahedron_faces(h);
    switch (random_() % 4) {
      case 0:
        return add_cell(mesh, CellKind::hexahedron, h);
      case 1:
        return add_cell(mesh, CellKind::voxel, {h[0], h[1], h[3], h[2], h[4], h[5], h[7], h[6]});
      case 2: {
        const std::uint64_t middle = mesh.points.size();
        std::array<double, 3> p{};
        for (const std::uint64_t id : h)
          for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += mesh.points[id][axis] / 8;
        mesh.points.push_back(p);
        for (const Ids& f : faces) add_cell(mesh, CellKind::pyramid, {f[3], f[2], f[1], f[0], middle});
        return;
      }
      default: {
        std::vector<Ids> turned = faces;  // as files have them, not all counter-clockwise
        for (Ids& face : turned)
          if (random_() % 2 == 0) std::reverse(face.begin(), face.end());
        add_polyhedron(mesh, turned);
      }
    }
  }

  std::uint64_t n_;
  std::mt19937_64 random_;
};

}  // namespace rhoray::tests
