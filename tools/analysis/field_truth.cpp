#include "tools/analysis/field_truth.h"

#include <algorithm>

#include "formats/tet_mesh.h"
#include "tools/validate/grid_field.h"

namespace rhoray::tools {

struct FieldTruth::Data {
  std::optional<validate::GridField> grid;
  std::optional<formats::TetMesh> mesh;
};

FieldTruth::FieldTruth(const render::Dataset& dataset) : data_(std::make_unique<Data>()) {
  const std::string& kind = dataset.file().description().kind;
  if (dataset.is_mesh())
    data_->mesh.emplace(dataset.file());
  else if (kind == "grid")
    data_->grid.emplace(formats::BrickGrid(dataset.file()), dataset.field().name);
}

FieldTruth::~FieldTruth() = default;

double FieldTruth::cells_per_t(const render::Ray& ray, const render::Hit& truth) const {
  if (data_->grid) return data_->grid->in_cells(ray.direction, ray.at(truth.t));
  if (!data_->mesh) return ray.direction.length();
  const auto corners = data_->mesh->cell(truth.tet);
  const auto points = data_->mesh->points();
  double longest = 0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b) {
      const std::array<double, 3>&p = points[corners[a]], &q = points[corners[b]];
      longest = std::max(longest, Vec3(p[0] - q[0], p[1] - q[1], p[2] - q[2]).length());
    }
  return ray.direction.length() / longest;
}

std::optional<double> FieldTruth::value(const render::Ray& ray, const render::Hit& truth, double isovalue,
                                        double t) const {
  if (data_->grid) return data_->grid->value(data_->grid->index_from_frame(ray.at(t)));
  return isovalue + truth.gradient.dot(ray.direction) * (t - truth.t);
}

}  // namespace rhoray::tools
