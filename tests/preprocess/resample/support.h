#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "preprocess/resample/certify.h"
#include "preprocess/resample/locate.h"
#include "tests/support/meshes.h"

namespace rhoray::preprocess {

/// A mesh on its way through the verb's steps.
struct Sampled {
  CleanMesh mesh;
  std::vector<PointField> fields;
  SampleLattice lattice;
  TouchedBricks touched;
  BrickSamples samples;
  Certificates certificates;

  Sampled(const NeutralMesh& source, const LatticeWish& wish) {
    std::vector<std::string> notes;
    mesh = clean_mesh(source, "mesh");
    fields = choose_fields(source, mesh, {}, false, "mesh", notes);
    lattice = choose_samples(mesh.box, wish);
    touched = find_touched_bricks(mesh, lattice, {});
    samples = sample_fields(mesh, fields, lattice, touched, {});
    certificates = certify(mesh, fields, match_faces(mesh.points, mesh.cells), lattice, touched, samples, {});
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
