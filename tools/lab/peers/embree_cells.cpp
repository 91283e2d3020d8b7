#include "tools/lab/peers/embree_cells.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "formats/base/text.h"

namespace rhoray::study {

namespace {

/// A cell as linear functions of the position: the field and the four barycentric weights. The
/// position is relative to the mesh's centre, so that floats suffice.
struct Cell {
  float field[4];      ///< coefficients of x, y, z, 1
  float weight[4][4];  ///< the same for each weight
  float lo, hi;        ///< of the field's values
  float box[6];        ///< smallest x, y, z, largest x, y, z
};

struct Cells {
  std::vector<Cell> cells;
  Vec3 middle;
  float isovalue = 0;
};

void put(float* out, const Vec3& gradient, double at_middle) {
  for (int a = 0; a < 3; ++a) out[a] = static_cast<float>(gradient[a]);
  out[3] = static_cast<float>(at_middle);
}

Cell cell_of(const Vec3 (&p)[4], const double (&f)[4]) {
  Cell cell{};
  const double volume = (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0]));
  Vec3 gradient(0);
  double at_middle = 0;
  for (int v = 0; v < 4; ++v) {
    const Vec3 &a = p[(v + 1) % 4], &b = p[(v + 2) % 4], &c = p[(v + 3) % 4];
    // 1 at vertex v, 0 on the face.
    const Vec3 across = (b - a).cross(c - a) * ((v % 2 == 0 ? -1 : 1) / volume);
    const double offset = -across.dot(a);
    put(cell.weight[v], across, offset);
    gradient += across * f[v];
    at_middle += offset * f[v];
  }
  put(cell.field, gradient, at_middle);
  cell.lo = static_cast<float>(*std::min_element(f, f + 4));
  cell.hi = static_cast<float>(*std::max_element(f, f + 4));
  for (int a = 0; a < 3; ++a) {
    const auto [lo, hi] = std::minmax({p[0][a], p[1][a], p[2][a], p[3][a]});
    // More than the rounding to float.
    const double reach = 1e-6 * std::max(std::abs(lo), std::abs(hi));
    cell.box[a] = static_cast<float>(lo - reach);
    cell.box[a + 3] = static_cast<float>(hi + reach);
  }
  return cell;
}

void bounds_of_cell(const RTCBoundsFunctionArguments* asked) {
  const Cell& cell = static_cast<const Cells*>(asked->geometryUserPtr)->cells[asked->primID];
  *asked->bounds_o = {cell.box[0], cell.box[1], cell.box[2], 0, cell.box[3], cell.box[4], cell.box[5], 0};
}

/// Weights may be below 0 by this much: neighbours overlap by more than the rounding.
constexpr float slack = 1e-6F;

// clang 14 takes each word of such a list for a target of its own.
#if !defined(__clang__)
__attribute__((target_clones("arch=skylake-avx512", "avx2,fma", "default")))
#endif
void meet_16(
    const Cell& cell, float isovalue, const int* valid, RTCRayHit16& rays, unsigned cell_number, unsigned geometry) {
  const auto& ray = rays.ray;
  auto& hit = rays.hit;
  for (int i = 0; i < 16; ++i) {
    const auto at = [&](const float* plane) {
      return plane[0] * ray.org_x[i] + plane[1] * ray.org_y[i] + plane[2] * ray.org_z[i] + plane[3];
    };
    const auto along = [&](const float* plane) {
      return plane[0] * ray.dir_x[i] + plane[1] * ray.dir_y[i] + plane[2] * ray.dir_z[i];
    };
    const float t = (isovalue - at(cell.field)) / along(cell.field);
    const float smallest = std::min(
        std::min(at(cell.weight[0]) + t * along(cell.weight[0]), at(cell.weight[1]) + t * along(cell.weight[1])),
        std::min(at(cell.weight[2]) + t * along(cell.weight[2]), at(cell.weight[3]) + t * along(cell.weight[3])));
    const bool hits = (valid[i] != 0) & (smallest >= -slack) & (t > ray.tnear[i]) & (t < ray.tfar[i]);
    rays.ray.tfar[i] = hits ? t : ray.tfar[i];
    hit.Ng_x[i] = hits ? cell.field[0] : hit.Ng_x[i];
    hit.Ng_y[i] = hits ? cell.field[1] : hit.Ng_y[i];
    hit.Ng_z[i] = hits ? cell.field[2] : hit.Ng_z[i];
    hit.primID[i] = hits ? cell_number : hit.primID[i];
    hit.geomID[i] = hits ? geometry : hit.geomID[i];
  }
}

/// Intersects one ray of N, in the style of Embree's own examples of user geometry.
template <unsigned N>
void meet_ray(const Cell& cell, float isovalue, RTCRayHitN* rayhit, unsigned i, unsigned cell_number,
              unsigned geometry) {
  RTCRayN* ray = RTCRayHitN_RayN(rayhit, N);
  RTCHitN* hit = RTCRayHitN_HitN(rayhit, N);
  const float from[3] = {RTCRayN_org_x(ray, N, i), RTCRayN_org_y(ray, N, i), RTCRayN_org_z(ray, N, i)};
  const float to[3] = {RTCRayN_dir_x(ray, N, i), RTCRayN_dir_y(ray, N, i), RTCRayN_dir_z(ray, N, i)};
  const auto at = [&](const float* plane) {
    return plane[0] * from[0] + plane[1] * from[1] + plane[2] * from[2] + plane[3];
  };
  const auto along = [&](const float* plane) { return plane[0] * to[0] + plane[1] * to[1] + plane[2] * to[2]; };
  const float t = (isovalue - at(cell.field)) / along(cell.field);
  if (!(t > RTCRayN_tnear(ray, N, i)) || !(t < RTCRayN_tfar(ray, N, i))) return;
  for (const auto& weight : cell.weight)
    if (!(at(weight) + t * along(weight) >= -slack)) return;
  RTCRayN_tfar(ray, N, i) = t;
  RTCHitN_Ng_x(hit, N, i) = cell.field[0];
  RTCHitN_Ng_y(hit, N, i) = cell.field[1];
  RTCHitN_Ng_z(hit, N, i) = cell.field[2];
  RTCHitN_primID(hit, N, i) = cell_number;
  RTCHitN_geomID(hit, N, i) = geometry;
}

template <CellCallback callback>
void meet_cell(const RTCIntersectFunctionNArguments* asked) {
  const Cells& cells = *static_cast<const Cells*>(asked->geometryUserPtr);
  const Cell& cell = cells.cells[asked->primID];
  const float isovalue = cells.isovalue;
  if (!(cell.lo < isovalue && isovalue <= cell.hi)) return;
  if (asked->N != 16) {
    if (asked->valid[0] != 0) meet_ray<1>(cell, isovalue, asked->rayhit, 0, asked->primID, asked->geomID);
  } else if constexpr (callback == CellCallback::sixteen_rays) {
    meet_16(cell, isovalue, asked->valid, *reinterpret_cast<RTCRayHit16*>(asked->rayhit), asked->primID, asked->geomID);
  } else {
    for (unsigned i = 0; i < 16; ++i)
      if (asked->valid[i] != 0) meet_ray<16>(cell, isovalue, asked->rayhit, i, asked->primID, asked->geomID);
  }
}

class CellScene final : public EmbreeScene {
 public:
  CellScene(bool only_crossed, CellCallback callback) : only_crossed_(only_crossed), callback_(callback) {}

  std::string named(const std::string& way) const override {
    return concat("Embree, ", only_crossed_ ? "crossed cells, " : "all cells, ",
                  callback_ == CellCallback::ray_by_ray ? "plain callback, " : "", way);
  }
  std::string shows() const override {
    return concat("user geometry of ", only_crossed_ ? "the cells that the isovalue crosses" : "all cells",
                  callback_ == CellCallback::ray_by_ray ? ", a callback that goes through its rays" : "");
  }
  Vec3 middle() const override { return cells_.middle; }

 private:
  Preparation build(const PeerData& data, double isovalue) override {
    Preparation preparation;
    cells_.isovalue = static_cast<float>(isovalue);
    if (!only_crossed_ && !cells_.cells.empty()) return preparation;
    preparation.extraction_ms = cpu_ms_of([&] { take_cells(data, isovalue); });
    preparation.build_ms = cpu_ms_of([&] { build_scene(); });
    if (!only_crossed_) {
      preparation.once_ms = preparation.extraction_ms + preparation.build_ms;
      preparation.extraction_ms = preparation.build_ms = 0;
    }
    return preparation;
  }

  void take_cells(const PeerData& data, double isovalue) {
    cells_.cells.clear();
    cells_.middle = data.bounds.center();
    const auto& values = data.mesh->point_fields[0].values;
    for (const auto& corners : data.mesh->cells) {
      const double f[4] = {values[corners[0]], values[corners[1]], values[corners[2]], values[corners[3]]};
      const auto [lo, hi] = std::minmax({f[0], f[1], f[2], f[3]});
      if (only_crossed_ && !(lo < isovalue && isovalue <= hi)) continue;
      Vec3 p[4];
      for (int v = 0; v < 4; ++v) {
        const auto& point = data.mesh->points[corners[static_cast<std::size_t>(v)]];
        p[v] = Vec3(point[0], point[1], point[2]) - cells_.middle;
      }
      cells_.cells.push_back(cell_of(p, f));
    }
  }

  void build_scene() {
    start();
    const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(cells_.cells.size()));
    rtcSetGeometryUserData(geometry, &cells_);
    rtcSetGeometryBoundsFunction(
        geometry, [](const RTCBoundsFunctionArguments* asked) { bounds_of_cell(asked); }, nullptr);
    rtcSetGeometryIntersectFunction(geometry, callback_ == CellCallback::sixteen_rays
                                                  ? meet_cell<CellCallback::sixteen_rays>
                                                  : meet_cell<CellCallback::ray_by_ray>);
    finish(geometry);
  }

  bool only_crossed_;
  CellCallback callback_;
  Cells cells_;
};

}  // namespace

std::shared_ptr<EmbreeScene> embree_cells(bool only_crossed, CellCallback callback) {
  return std::make_shared<CellScene>(only_crossed, callback);
}

}  // namespace rhoray::study
