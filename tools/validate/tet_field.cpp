#include "tools/validate/tet_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "formats/base/error.h"

namespace rhoray::tools::validate {

namespace {

Vec3 vec(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}

}  // namespace

TetField::TetField(const formats::TetMesh& mesh, const std::string& field) : mesh_(mesh) {
  const auto found = field.empty() ? std::optional<std::size_t>(0) : mesh.find_field(field);
  if (!found) throw Error(ErrorCode::usage, concat(mesh.file().name(), ": no field '", field, "'"));
  const auto take = [&](const auto values) { values_.assign(values.begin(), values.end()); };
  if (mesh.description().fields[*found].type == formats::ElementType::F32)
    take(mesh.values<float>(*found));
  else
    take(mesh.values<double>(*found));

  std::vector<std::uint32_t> order(cell_count());
  std::iota(order.begin(), order.end(), 0U);
  const auto rises = [&](std::uint32_t a, std::uint32_t b) { return mesh_.cell_id(a) < mesh_.cell_id(b); };
  std::sort(order.begin(), order.end(), rises);
  by_id_ = std::move(order);
}

Box3 TetField::box() const {
  Box3 box;
  for (const auto& p : mesh_.points()) box.extendBy(vec(p));
  return box;
}

TetField::Cell TetField::cell(std::size_t c) const {
  Cell cell;
  cell.vertex = mesh_.cell(c);
  for (std::size_t v = 0; v < 4; ++v) {
    cell.point[v] = mesh_.points()[cell.vertex[v]];
    cell.value[v] = values_[cell.vertex[v]];
  }
  return cell;
}

std::span<const std::uint32_t> TetField::cells_of_id(std::uint64_t id) const {
  const auto id_of = [&](std::uint32_t cell) { return mesh_.cell_id(cell); };
  return {std::ranges::lower_bound(by_id_, id, {}, id_of), std::ranges::upper_bound(by_id_, id, {}, id_of)};
}

bool TetField::straddles(const Cell& cell, double isovalue) {
  bool below = false, above = false;
  for (const double value : cell.value) {
    if (!std::isfinite(value)) return false;
    (value >= isovalue ? above : below) = true;
  }
  return below && above;
}

Box3 TetField::Cell::box() const {
  Box3 box;
  for (const auto& p : point) box.extendBy(vec(p));
  return box;
}

double TetField::Cell::longest_edge() const {
  double longest = 0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b) longest = std::max(longest, (vec(point[a]) - vec(point[b])).length());
  return longest;
}

double TetField::Cell::smallest_coordinate(const Vec3& p) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < 4; ++v) {
    const Vec3 a = vec(point[(v + 1) % 4]), b = vec(point[(v + 2) % 4]) - a, c = vec(point[(v + 3) % 4]) - a;
    const Vec3 normal = b.cross(c);
    const double height = normal.dot(vec(point[v]) - a);
    if (height == 0) return std::numeric_limits<double>::quiet_NaN();
    smallest = std::min(smallest, normal.dot(p - a) / height);
  }
  return smallest;
}

Vec3 TetField::Cell::gradient() const {
  const Vec3 a = vec(point[1]) - vec(point[0]), b = vec(point[2]) - vec(point[0]), c = vec(point[3]) - vec(point[0]);
  const Vec3 sum =
      (value[1] - value[0]) * b.cross(c) + (value[2] - value[0]) * c.cross(a) + (value[3] - value[0]) * a.cross(b);
  return sum / a.dot(b.cross(c));
}

}  // namespace rhoray::tools::validate
