#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "preprocess/grid/resample/certify.h"
#include "preprocess/grid/resample/extend.h"
#include "preprocess/grid/resample/locate.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {

inline NeutralMesh with_random_values(NeutralMesh mesh, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  mesh.point_fields = {
      {.name = "value", .unit = {}, .component_count = 1, .was_single_precision = false, .values = {}}};
  for (std::size_t p = 0; p < mesh.points.size(); ++p) mesh.point_fields[0].values.push_back(unit(random));
  return mesh;
}

/// A mesh on its way through the verb's steps.
struct Sampled {
  CleanMesh mesh;
  std::vector<ScalarField> fields;
  SampleLattice lattice;
  TouchedBricks touched;
  BrickSamples samples;
  Certificates certificates;
  mutable std::size_t bare_point_count = 0;

  Sampled(const NeutralMesh& source, const LatticeRequest& request) {
    std::vector<std::string> notes;
    mesh = clean_mesh(source, "mesh");
    fields = choose_fields(source, mesh, {}, false, "mesh", notes).of_points;
    lattice = choose_samples(mesh.box, request);
    touched = find_touched_bricks(mesh, lattice, {});
    samples = sample_fields(mesh, fields, lattice, touched, {});
    const std::vector<Point> steps = points_in_steps(mesh, lattice);
    std::vector<FieldView> views;
    for (std::size_t f = 0; f < fields.size(); ++f)
      views.push_back(view_of(mesh, fields[f], steps, lattice, samples.conflicts[f]));
    extend_samples(mesh, views, steps, lattice, touched, samples, {});
    certificates = certify(mesh, views, steps, match_faces(mesh.points, mesh.cells), lattice, touched, samples, {});
  }

  double sample(std::int64_t i, std::int64_t j, std::int64_t k, std::size_t field = 0) const {
    constexpr std::int64_t n = SampleLattice::brick_edge;
    const std::uint32_t slot = touched.slot({i / n, j / n, k / n});
    if (slot == TouchedBricks::none) return std::nan("");
    const auto at = slot * static_cast<std::size_t>(SampleLattice::brick_samples) +
                    static_cast<std::size_t>(((k % n) * n + j % n) * n + i % n);
    return std::visit([&](const auto& values) { return static_cast<double>(values[at]); }, samples.fields[field]);
  }

  std::array<double, 3> place(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return {lattice.places[0][static_cast<std::size_t>(i)], lattice.places[1][static_cast<std::size_t>(j)],
            lattice.places[2][static_cast<std::size_t>(k)]};
  }

  template <class Act>
  void for_each_sample(Act&& act) const {
    for (std::int64_t k = 0; k < lattice.count.z; ++k)
      for (std::int64_t j = 0; j < lattice.count.y; ++j)
        for (std::int64_t i = 0; i < lattice.count.x; ++i) act(i, j, k);
  }

  /// Calls act(leaf cell, |trilinear - linear|) at points strewn densely over every tetrahedron,
  /// its faces and edges too; on a side of a leaf cell for that beyond it, or before it where that
  /// has no trilinear field. Points in leaf cells without a trilinear field are only counted
  /// (bare_point_count).
  /// @param order  a tetrahedron's edge is cut into as many parts
  template <class Act>
  void for_each_difference(int order, Act&& act) const {
    const std::vector<double> values =
        std::visit([](const auto& v) { return std::vector<double>(v.begin(), v.end()); }, fields[0].values);
    for (const auto& cell : mesh.cells)
      for (int a = 0; a <= order; ++a)
        for (int b = 0; a + b <= order; ++b)
          for (int c = 0; a + b + c <= order; ++c) {
            const std::array<int, 4> counts{a, b, c, order - a - b - c};
            std::array<double, 3> p{};
            double linear = 0;
            for (std::size_t v = 0; v < 4; ++v) {
              const double weight = static_cast<double>(counts[v]) / order;
              for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += weight * mesh.points[cell[v]][axis];
              linear += weight * values[cell[v]];
            }
            const std::array<double, 3> steps = lattice.in_steps(p);
            const Vec3 at(steps[0], steps[1], steps[2]);
            Index3 leaf;
            for (int axis = 0; axis < 3; ++axis)
              leaf[axis] =
                  std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(at[axis])), 0, lattice.count[axis] - 2);
            if (std::isnan(linear)) continue;
            double difference = std::abs(trilinear(leaf, at) - linear);
            for (int below = 1; below < 8 && std::isnan(difference); ++below) {
              const Index3 step(below & 1, below >> 1 & 1, below >> 2);
              bool is_in_side = true;
              for (int axis = 0; axis < 3; ++axis)
                is_in_side = is_in_side &&
                             (step[axis] == 0 || (leaf[axis] > 0 && at[axis] < 1e-9 + static_cast<double>(leaf[axis])));
              if (!is_in_side) continue;
              difference = std::abs(trilinear(leaf - step, at) - linear);
              if (!std::isnan(difference)) leaf -= step;
            }
            if (std::isnan(difference))
              ++bare_point_count;
            else
              act(leaf, difference);
          }
  }

  /// The trilinear field of a leaf cell.
  /// @param at  in steps
  double trilinear(const Index3& leaf, const Vec3& at) const {
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Index3 sample_at = leaf + Index3(corner & 1, corner >> 1 & 1, corner >> 2);
      double weight = 1;
      for (int a = 0; a < 3; ++a) {
        const double in_leaf = at[a] - static_cast<double>(leaf[a]);
        weight *= sample_at[a] == leaf[a] ? 1 - in_leaf : in_leaf;
      }
      sum += weight * sample(sample_at.x, sample_at.y, sample_at.z);
    }
    return sum;
  }

  /// The cell of every sample, x fastest; Places::outside where there is none.
  std::vector<std::uint32_t> owners() const {
    std::map<std::uint32_t, Places> places;
    for (std::size_t slot = 0; slot < touched.bricks.size(); ++slot)
      locate(mesh.points, mesh.cells, touched.lists.view().list(touched.bricks[slot]), lattice,
             rows_of_samples(lattice, touched.at(slot)), places[static_cast<std::uint32_t>(slot)], nullptr);
    std::vector<std::uint32_t> owners;
    for_each_sample([&](std::int64_t i, std::int64_t j, std::int64_t k) {
      constexpr std::int64_t n = SampleLattice::brick_edge;
      const std::uint32_t slot = touched.slot({i / n, j / n, k / n});
      const auto in_brick = static_cast<std::size_t>(((k % n) * n + j % n) * n + i % n);
      owners.push_back(slot == TouchedBricks::none ? Places::outside : places[slot].cell[in_brick]);
    });
    return owners;
  }
};

}  // namespace rhoray::preprocess
