#include "render/load.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "formats/base/box_corners.h"
#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "formats/base/stoppable_mutex.h"
#include "formats/base/text.h"
#include "formats/color_grid.h"
#include "formats/range_proof.h"
#include "render/dataset/load_view.h"
#include "render/dataset/loaded_dataset.h"
#include "render/dataset/shown_boxes.h"
#include "render/grid/occupancy.h"
#include "render/triangles/corner_normals.h"
#include "render/triangles/facets.h"
#include "render/triangles/feature_edges.h"
#include "render/triangles/point_gradients.h"

namespace rhoray::render {

namespace {

/// Returns a world-axes box around a box in the data's frame.
Box3 box_world(const Box3& box, const Affine& world_from_data) {
  Box3 out;
  if (box.isEmpty()) return out;
  for (const Vec3& corner : corners_of(box)) out.extendBy(world_from_data.point(corner));
  return out;
}

/// A NanoVDB grid stores no ranges: they were computed from the voxels in this process.
std::uint64_t proven_bytes(const GridData& view, const std::string& field, unsigned threads, const Watch& watch) {
  return view.packed() ? formats::prove_ranges(*view.packed(), *view.packed()->find_field(field), threads, watch) : 0;
}

std::uint64_t proven_bytes(const TetData& view, const std::string& field, unsigned threads, const Watch& watch) {
  return formats::prove_ranges(view.mesh(), *view.mesh().find_field(field), threads, watch);
}

std::uint64_t proven_bytes(const TriangleData&, const std::string&, unsigned, const Watch&) {
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

std::vector<std::string> color_names(const LoadedDataset& dataset) {
  std::vector<std::string> names = dataset.field_names;
  for (const formats::FieldSummary& field : dataset.cell_fields)
    if (std::find(names.begin(), names.end(), field.name) == names.end()) names.push_back(field.name);
  return names;
}

struct Dataset::ProofState {
  StoppableMutex guard;  ///< one caller proves; others wait
  bool is_done = false;
};

/// The boundaries that are in use: what is prepared to trace them stays when a scene changes.
struct Dataset::Boundaries {
  using Key = std::tuple<std::string, int, std::vector<int>>;  ///< of a label: its field, and those left out
  StoppableMutex guard;
  std::map<Key, std::weak_ptr<const LoadedDataset>> known;

  template <class Load>
  std::shared_ptr<const LoadedDataset> of(const Key& key, const std::stop_token& stop, const Load& load) {
    const StoppableLock lock(guard, stop);
    std::weak_ptr<const LoadedDataset>& place = known[key];
    std::shared_ptr<const LoadedDataset> boundary = place.lock();
    if (!boundary) place = boundary = load();
    return boundary;
  }
};

Dataset::Dataset(std::shared_ptr<const LoadedDataset> implementation)
    : implementation_(std::move(implementation)),
      proof_(std::make_shared<ProofState>()),
      boundaries_(std::make_shared<Boundaries>()) {}

Dataset Dataset::load(const std::filesystem::path& path, const std::string& field, formats::Space world,
                      const Watch& watch) {
  const DefaultFloatingPoint default_floating_point;
  return load(formats::PackedFile::open(path), field, world, watch);
}

Dataset Dataset::load(const formats::PackedFile& file, const std::string& field, formats::Space world,
                      const Watch& watch) {
  const DefaultFloatingPoint default_floating_point;
  if (auto implementation = load_view(file, field, world, watch)) return Dataset(std::move(implementation));
  if (file.description().kind == formats::ColorGrid::kind)
    throw Error(ErrorCode::unsupported, concat(file.name(), ": holds colours; expected a grid, a mesh or a surface"),
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
std::vector<std::string> Dataset::color_names() const {
  return render::color_names(*implementation_);
}
std::optional<formats::FieldSummary> Dataset::field(const std::string& name) const {
  for (const formats::FieldSummary& summary : implementation_->cell_fields)
    if (summary.name == name) return summary;
  if (name == field().name) return field();
  for (const formats::FieldSummary& summary : implementation_->fields)
    if (summary.name == name) return summary;
  return std::nullopt;
}
std::span<const formats::FieldSummary> Dataset::point_fields() const {
  return implementation_->fields;
}
std::span<const formats::FieldSummary> Dataset::cell_fields() const {
  return implementation_->cell_fields;
}
formats::Space Dataset::space() const {
  return implementation_->space;
}
const std::string& Dataset::length_unit() const {
  return implementation_->length_unit;
}
bool Dataset::is_mesh() const {
  return std::holds_alternative<TetData>(implementation_->view);
}
bool Dataset::is_surface() const {
  return std::holds_alternative<TriangleData>(implementation_->view);
}
bool Dataset::has_fields() const {
  return !implementation_->field_names.empty();
}
bool Dataset::is_level_set() const {
  return implementation_->is_level_set;
}
bool Dataset::is_y_up() const {
  return implementation_->is_y_up;
}
const std::vector<std::string>& Dataset::notes() const {
  return implementation_->notes;
}

Dataset Dataset::boundary(const Watch& watch) const {
  const DefaultFloatingPoint default_floating_point;
  return Dataset(boundaries_->of({}, watch.stop, [&] { return load_boundary(*implementation_, watch); }));
}

Dataset Dataset::boundary(const std::string& cell_field, int label, std::span<const int> without,
                          const Watch& watch) const {
  const DefaultFloatingPoint default_floating_point;
  return Dataset(boundaries_->of({cell_field, label, {without.begin(), without.end()}}, watch.stop,
                                 [&] { return load_boundary(*implementation_, cell_field, label, without, watch); }));
}

FeatureEdges Dataset::feature_edges(double angle_deg, unsigned threads) const {
  const DefaultFloatingPoint default_floating_point;
  const auto* view = std::get_if<TriangleData>(&implementation_->view);
  if (view == nullptr) throw Error(ErrorCode::usage, concat(file().name(), ": is no surface and has no edges"));
  FeatureEdges found{.edges = render::feature_edges(*view, angle_deg, threads)};
  double length = 0;
  for (auto& [from, to] : found.edges) {
    length += (to - from).length();  // a surface's own frame is only shifted
    from = implementation_->world_from_data.point(from), to = implementation_->world_from_data.point(to);
  }
  if (length > 0) found.mean_distance = area_of(*view) / length;
  return found;
}

RangeProof Dataset::prove_ranges(unsigned threads, const Watch& watch) const {
  const StoppableLock lock(proof_->guard, watch.stop);
  if (proof_->is_done) return {};
  end_if_stopped(watch.stop);
  const auto start = std::chrono::steady_clock::now();
  const std::uint64_t bytes = std::visit(
      [&](const auto& view) { return proven_bytes(view, field().name, threads, watch); }, implementation_->view);
  proof_->is_done = true;
  return {.bytes = bytes, .wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
}

std::uint64_t Dataset::prepared_bytes() const {
  const LoadedDataset& dataset = *implementation_;
  std::uint64_t bytes = dataset.occupancies->size_bytes();
  if (dataset.facets) bytes += dataset.facets->size_bytes();
  if (dataset.point_gradients) bytes += dataset.point_gradients->size_bytes();
  if (dataset.corner_normals) bytes += dataset.corner_normals->size_bytes();
  return bytes;
}

void Dataset::drop_prepared() const {
  const LoadedDataset& dataset = *implementation_;
  dataset.occupancies->clear();
  if (dataset.facets) dataset.facets->clear();
  if (dataset.point_gradients) dataset.point_gradients->clear();
  if (dataset.corner_normals) dataset.corner_normals->clear();
}

Box3 Dataset::bounds() const {
  const DefaultFloatingPoint default_floating_point;
  return box_world(implementation_->bounds_data, implementation_->world_from_data);
}

Box3 Dataset::isosurface_bounds(double isovalue) const {
  Box3 bounds;
  if (is_surface()) return bounds;
  for (const auto& corners : shown_boxes(isovalue))
    for (const Vec3& corner : corners) bounds.extendBy(corner);
  return bounds;
}

std::vector<std::array<Vec3, 8>> Dataset::shown_boxes(double isovalue, const Watch& watch) const {
  const DefaultFloatingPoint default_floating_point;
  std::vector<std::array<Vec3, 8>> boxes;
  for (const Box3& box : render::shown_boxes(*implementation_, isovalue, watch)) {
    boxes.push_back(corners_of(box));
    for (Vec3& corner : boxes.back()) corner = implementation_->world_from_data.point(corner);
  }
  return boxes;
}

}  // namespace rhoray::render
