#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "formats/base/text.h"
#include "formats/tet_mesh.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "render/load.h"
#include "render/ray_caster.h"
#include "tests/support/fields.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"
#include "tools/validate/compare.h"

namespace rhoray::tests {

namespace validate = tools::validate;

/// A packed file made by the test, and the renderer on it.
class ValidatedFile {
 public:
  explicit ValidatedFile(const preprocess::NeutralMesh& mesh) : dataset_(packed(mesh)) {}
  explicit ValidatedFile(const preprocess::NeutralVolume& samples) : dataset_(packed(samples)) {}

  const render::Dataset& dataset() const { return dataset_; }
  validate::TetField tets() const { return {formats::TetMesh(dataset_.file()), ""}; }
  validate::GridField grid() const { return {formats::BrickGrid(dataset_.file()), ""}; }

  validate::Tracer renderer(double isovalue, const render::Method& method = {}) const {
    return [this, isovalue, method](std::span<const render::Ray> rays, std::span<render::Hit> hits) {
      render::RayCaster(dataset_, isovalue, method, 0).first_crossings(rays, hits);
    };
  }

  validate::Comparison compare(const validate::RayQuery& query, const validate::Tracer& tracer) const {
    const auto no_progress = [](std::uint64_t) {};
    const Affine world = render::world_from_ray_frame(dataset_);
    if (dataset_.is_mesh()) return validate::compare_tets(tets(), world, query, tracer, no_progress);
    return validate::compare_grid(grid(), world, query, tracer, no_progress);
  }
  validate::Report report(const validate::RayQuery& query, const validate::Tracer& tracer) const {
    return compare(query, tracer).report;
  }
  validate::Report report(const validate::RayQuery& query) const { return report(query, renderer(query.isovalue)); }

 private:
  render::Dataset packed(const preprocess::NeutralMesh& mesh) {
    preprocess::pack_mesh(mesh, folder_ / "packed.rho", {});
    return render::Dataset::load(folder_ / "packed.rho");
  }
  render::Dataset packed(const preprocess::NeutralVolume& samples) {
    preprocess::pack_volume(samples, folder_ / "packed.rho", {});
    return render::Dataset::load(folder_ / "packed.rho");
  }

  TemporaryFolder folder_;
  render::Dataset dataset_;
};

/// Wraps a tracer and changes every hit with `spoil`, which receives the number of the hit.
inline validate::Tracer spoiled(validate::Tracer tracer,
                                std::function<void(std::size_t, const render::Ray&, render::Hit&)> spoil) {
  return [tracer = std::move(tracer), spoil = std::move(spoil)](std::span<const render::Ray> rays,
                                                                std::span<render::Hit> hits) {
    tracer(rays, hits);
    std::size_t number = 0;
    for (std::size_t r = 0; r < rays.size(); ++r)
      if (!hits[r].is_miss()) spoil(number++, rays[r], hits[r]);
  };
}

/// Expects that the checks catch a faulty renderer. `test_validate --gtest_output=xml:FILE` reports
/// the checks under `what`.
inline void expect_caught(const std::string& what, const validate::Report& report) {
  std::string outside;
  for (const validate::Check& check : report.checks)
    if (check.is_broken()) outside += concat(outside.empty() ? "" : "; ", check.name, " ", check.found);
  EXPECT_NE(outside, "") << what;
  testing::Test::RecordProperty(what, concat("of ", report.total().rays, " rays: ", outside));
}

// Faulty renderers.

inline validate::Tracer dropping_one_hit_in_a_thousand(const validate::Tracer& tracer) {
  return spoiled(tracer, [](std::size_t number, const render::Ray&, render::Hit& hit) {
    if (number % 1000 == 999) hit = {};
  });
}

/// @param distance  in lengths of the rays' directions
inline validate::Tracer shifting_hits(const validate::Tracer& tracer, double distance) {
  return spoiled(tracer, [=](std::size_t, const render::Ray&, render::Hit& hit) { hit.t += distance; });
}

/// Hits of a proving method that claim to be exact.
inline validate::Tracer understating_bounds(const validate::Tracer& tracer) {
  return spoiled(tracer, [](std::size_t, const render::Ray&, render::Hit& hit) { hit.error = 0; });
}

inline validate::Tracer reporting_the_second_hit(const validate::Tracer& tracer, double step) {
  return spoiled(tracer, [=](std::size_t number, const render::Ray& ray, render::Hit& hit) {
    if (number % 100 != 99) return;
    const render::Ray onward{ray.origin + (hit.t + step) * ray.direction, ray.direction};
    render::Hit second;
    tracer(std::span(&onward, 1), std::span(&second, 1));
    const double first_t = hit.t;
    hit = second;
    hit.t += first_t + step;
  });
}

inline validate::Tracer turning_normals(const validate::Tracer& tracer) {
  return spoiled(tracer, [](std::size_t number, const render::Ray&, render::Hit& hit) {
    if (number % 1000 == 999) hit.gradient = Vec3(hit.gradient.y, hit.gradient.z, hit.gradient.x);
  });
}

inline validate::Tracer losing_normals(const validate::Tracer& tracer) {
  return spoiled(tracer, [](std::size_t number, const render::Ray&, render::Hit& hit) {
    if (number % 1000 == 999) hit.gradient = Vec3(std::numeric_limits<double>::quiet_NaN());
  });
}

/// Adds a hit where the data's box begins, on some rays that miss everything.
inline validate::Tracer inventing_hits(validate::Tracer tracer, double t) {
  return [tracer = std::move(tracer), t](std::span<const render::Ray> rays, std::span<render::Hit> hits) {
    tracer(rays, hits);
    std::size_t misses = 0;
    for (render::Hit& hit : hits)
      if (hit.is_miss() && ++misses % 100 == 0) hit = {.t = t, .cell = 0, .gradient = {1, 0, 0}};
  };
}

inline validate::Quantiles quantiles(const validate::Report& report, const std::string& measure,
                                     const std::string& unit) {
  for (const validate::Measure& each : report.measures)
    if (each.name == measure && each.unit == unit) return each.quantiles;
  return {};
}

inline double found(const validate::Report& report, const std::string& check) {
  for (const validate::Check& each : report.checks)
    if (each.name == check) return each.found;
  return validate::not_measured;
}

}  // namespace rhoray::tests
