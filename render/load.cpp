#include "render/load.h"

#include <algorithm>
#include <chrono>
#include <mutex>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/text.h"
#include "formats/color_grid.h"
#include "formats/range_proof.h"
#include "render/dataset/load_view.h"
#include "render/dataset/loaded_dataset.h"

namespace rhoray::render {

namespace {

/// Returns a world-axes box around a box in the data's frame.
Box3 box_world(const Box3& box, const Affine& world_from_data) {
  Box3 out;
  if (box.isEmpty()) return out;
  for (int corner = 0; corner < 8; ++corner)
    out.extendBy(world_from_data.point(
        {corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z}));
  return out;
}

/// Returns a box around the lowest-level macrocells whose values are on both sides of the isovalue.
template <class Geometry>
Box3 crossed_box(const PlacedGrid<Geometry>& view, double isovalue) {
  const WalkLattice lattice = view.lattice();
  const std::int64_t edge = lattice.cell_edge(1);
  const Index3 count = whole_level(lattice, edge).end;
  const auto planes = view.geometry().planes();
  Box3 box;
  Index3 c;
  for (c.z = 0; c.z < count.z; ++c.z)
    for (c.y = 0; c.y < count.y; ++c.y)
      for (c.x = 0; c.x < count.x; ++c.x) {
        const Interval<double> range = view.range(1, c);
        if (!(range.lo < isovalue && isovalue <= range.hi)) continue;
        for (const Index3& corner : {c, c + Index3(1, 1, 1)}) {
          Vec3 p;
          for (int a = 0; a < 3; ++a) p[a] = planes.position(a, std::min(corner[a] * edge, lattice.leaf_count[a]));
          box.extendBy(p);
        }
      }
  return box;
}

/// Returns a box around the crossings of all edges: a tetrahedron's part of the isosurface is the
/// polygon between them.
Box3 crossed_box(const TetData& view, double isovalue) {
  Box3 box;
  for (std::uint64_t cell = 0; cell < view.description().cell_count; ++cell) {
    const auto vertices = view.sorted_vertices(static_cast<std::uint32_t>(cell));
    const auto values = view.values_at(vertices);
    const auto [lo, hi] = std::minmax({values[0], values[1], values[2], values[3]});
    if (!(lo < isovalue && isovalue <= hi) || !has_data(values)) continue;
    const auto points = view.points_at(vertices);
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b) {
        if ((values[a] >= isovalue) == (values[b] >= isovalue)) continue;
        const double share = (isovalue - values[a]) / (values[b] - values[a]);
        const Vec3 from(points[a][0], points[a][1], points[a][2]), to(points[b][0], points[b][1], points[b][2]);
        box.extendBy((1 - share) * from + share * to);
      }
  }
  return box;
}

Box3 crossed_box(const TriangleData&, double) {
  return {};
}

/// A NanoVDB grid stores no ranges: they were computed from the voxels in this process.
std::uint64_t proven_bytes(const GridData& view, const std::string& field, unsigned threads) {
  return view.packed() ? formats::prove_ranges(*view.packed(), *view.packed()->find_field(field), threads) : 0;
}

std::uint64_t proven_bytes(const TetData& view, const std::string& field, unsigned threads) {
  return formats::prove_ranges(view.mesh(), *view.mesh().find_field(field), threads);
}

std::uint64_t proven_bytes(const TriangleData&, const std::string&, unsigned) {
  return 0;
}

}  // namespace

void check_field_name(const formats::PackedFile& file, const std::string& field,
                      const std::vector<std::string>& names) {
  if (field.empty() || std::find(names.begin(), names.end(), field) != names.end()) return;
  std::string known;
  for (const std::string& name : names) known += concat(known.empty() ? "" : ", ", "'", name, "'");
  throw Error(ErrorCode::usage, concat(file.name(), ": no field '", field, "'; it has ", known));
}

struct Dataset::ProofState {
  std::mutex guard;
  bool is_done = false;
};

Dataset::Dataset(std::shared_ptr<const LoadedDataset> implementation)
    : implementation_(std::move(implementation)), proof_(std::make_shared<ProofState>()) {}

Dataset Dataset::load(const std::filesystem::path& path, const std::string& field, formats::Space world) {
  const DefaultFloatingPoint default_floating_point;
  return load(formats::PackedFile::open(path), field, world);
}

Dataset Dataset::load(const formats::PackedFile& file, const std::string& field, formats::Space world) {
  const DefaultFloatingPoint default_floating_point;
  if (auto implementation = load_view(file, field, world)) return Dataset(std::move(implementation));
  if (file.description().kind == formats::ColorGrid::kind)
    throw Error(ErrorCode::invalid, concat(file.name(), ": holds colours; expected a grid, a mesh or a surface"),
                "use it as a texture of other data: --texture FILE, or the key \"texture\" of a scene's layer");
  throw Error(ErrorCode::unsupported,
              concat(file.name(), ": kind '", file.description().kind, "'; expected 'grid', 'tets' or 'surface'"));
}

const formats::PackedFile& Dataset::file() const {
  return implementation_->file;
}
const formats::FieldSummary& Dataset::field() const {
  return implementation_->field;
}
std::vector<std::string> Dataset::field_names() const {
  return implementation_->field_names;
}
std::optional<formats::FieldSummary> Dataset::field(const std::string& name) const {
  if (name == field().name) return field();
  for (const formats::FieldSummary& summary : implementation_->fields)
    if (summary.name == name) return summary;
  return std::nullopt;
}
formats::Space Dataset::space() const {
  return implementation_->space;
}
const std::string& Dataset::length_unit() const {
  return implementation_->length_unit;
}
bool Dataset::is_mesh() const {
  return implementation_->file.description().kind == "tets";
}
bool Dataset::is_surface() const {
  return std::holds_alternative<TriangleData>(implementation_->view);
}
bool Dataset::is_level_set() const {
  return implementation_->is_level_set;
}
const std::vector<std::string>& Dataset::notes() const {
  return implementation_->notes;
}

RangeProof Dataset::prove_ranges(unsigned threads) const {
  const std::lock_guard lock(proof_->guard);
  if (proof_->is_done) return {};
  const auto start = std::chrono::steady_clock::now();
  const std::uint64_t bytes =
      std::visit([&](const auto& view) { return proven_bytes(view, field().name, threads); }, implementation_->view);
  proof_->is_done = true;
  return {.bytes = bytes, .wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
}

Box3 Dataset::bounds() const {
  const DefaultFloatingPoint default_floating_point;
  return box_world(implementation_->bounds_data, implementation_->world_from_data);
}

Box3 Dataset::isosurface_bounds(double isovalue) const {
  const DefaultFloatingPoint default_floating_point;
  const Box3 box = std::visit([&](const auto& view) { return crossed_box(view, isovalue); }, implementation_->view);
  return box_world(box, implementation_->world_from_data);
}

}  // namespace rhoray::render
