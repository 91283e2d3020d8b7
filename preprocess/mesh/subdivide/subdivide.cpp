#include "preprocess/subdivide.h"
#include "formats/base/floating_point.h"
#include "formats/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "preprocess/mesh/subdivide/cell_kinds.h"
#include "preprocess/mesh/subdivide/cut_cell.h"
#include "preprocess/mesh/subdivide/polyhedron.h"
#include "preprocess/mesh/subdivide/refine.h"
#include "preprocess/mesh/subdivide/shape_functions.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t cells_per_part = 4096;
/// marks a part's own new point, by its number in the part
constexpr std::uint64_t is_center = std::uint64_t{1} << 63;

std::uint64_t id_of_cell(const CellMesh& mesh, std::uint64_t cell) {
  return mesh.cell_ids.empty() ? cell : mesh.cell_ids[cell];
}

Error with_cell(const Error& error, std::uint64_t id) {
  return {error.code(), concat("cell ", id, ": ", error.what()), error.hint()};
}

std::span<const std::uint64_t> nodes_of(const CellMesh& mesh, std::uint64_t cell) {
  return std::span(mesh.cell_nodes)
      .subspan(mesh.cell_offsets[cell], mesh.cell_offsets[cell + 1] - mesh.cell_offsets[cell]);
}

/// Count and ids of the source cells with one kind of problem.
struct CellTally {
  std::uint64_t count = 0;
  std::vector<std::uint64_t> first_ids;

  void add(std::uint64_t id) {
    ++count;
    if (first_ids.size() < 3) first_ids.push_back(id);
  }
  void add(const CellTally& other) {
    count += other.count;
    for (const std::uint64_t id : other.first_ids)
      if (first_ids.size() < 3) first_ids.push_back(id);
  }
  /// "5 cells", "(first cells 3, 8, 9)"
  std::string cells() const { return concat(with_commas(count), count == 1 ? " cell" : " cells"); }
  std::string which() const {
    std::string text = concat(count > 3 ? " (first cells " : count == 1 ? " (cell " : " (cells ", first_ids.front());
    for (std::size_t i = 1; i < first_ids.size(); ++i) text += concat(", ", first_ids[i]);
    return text + ")";
  }
};

struct Center {
  std::vector<std::uint64_t> ids;
  std::vector<double> weights;
};

/// Result for a range of consecutive cells.
struct Part {
  std::vector<std::array<std::uint64_t, 4>> tets;
  std::vector<std::uint64_t> cells;  ///< of each tetrahedron
  std::vector<Center> centers;
  std::vector<CornerTetrahedronOfCell> curved;  ///< still to be refined
  CellTally vanished, overlapping;
  std::uint64_t inverted_count = 0;
  std::optional<Error> refusal;
};

/// The curved cells of a mesh and their shape functions.
class CurvedCells {
 public:
  explicit CurvedCells(const CellMesh& mesh) {
    for (std::uint64_t cell = 0; cell < mesh.kinds.size(); ++cell) {
      const CellKind kind = mesh.kinds[cell];
      const std::size_t node_count = nodes_of(mesh, cell).size();
      if (ShapeFunctions::is_linear(kind, node_count)) continue;
      cells_.push_back({cell, shape_of(mesh, cell, kind, node_count)});
    }
  }

  std::span<const CurvedCell> cells() const { return cells_; }

  std::optional<std::uint32_t> position_of(std::uint64_t cell) const {
    const auto found = std::lower_bound(cells_.begin(), cells_.end(), cell,
                                        [](const CurvedCell& curved, std::uint64_t c) { return curved.cell < c; });
    if (found == cells_.end() || found->cell != cell) return std::nullopt;
    return static_cast<std::uint32_t>(found - cells_.begin());
  }

 private:
  const ShapeFunctions* shape_of(const CellMesh& mesh, std::uint64_t cell, CellKind kind, std::size_t node_count) {
    std::unique_ptr<ShapeFunctions>& shape = shapes_[{kind, node_count}];
    try {
      if (!shape) shape = std::make_unique<ShapeFunctions>(kind, node_count);
    } catch (const Error& error) {
      throw with_cell(error, id_of_cell(mesh, cell));
    }
    return shape.get();
  }

  std::map<std::pair<CellKind, std::size_t>, std::unique_ptr<ShapeFunctions>> shapes_;
  Array<CurvedCell> cells_;
};

void check_nodes(const CellMesh& mesh, std::uint64_t cell, const KindOfCell& kind) {
  const std::span<const std::uint64_t> nodes = nodes_of(mesh, cell);
  const std::size_t corner_count = frame_of(kind.corners).corner_count;
  if (kind.kind == kind.corners && nodes.size() != corner_count)
    throw Error(ErrorCode::invalid,
                concat("found ", nodes.size(), " nodes; expected ", corner_count, ", as ", kind.plural, " have"));
  for (const std::uint64_t node : nodes)
    if (node >= mesh.points.size())
      throw Error(ErrorCode::invalid,
                  concat("found point ", static_cast<std::int64_t>(node), "; expected 0 to ", mesh.points.size() - 1));
}

/// Cuts one cell at a time into tetrahedra over its corners.
class CellCutter {
 public:
  CellCutter(const CellMesh& mesh, const CurvedCells& curved, Part& part) : mesh_(mesh), curved_(curved), part_(part) {}

  void cut(std::uint64_t cell) {
    const KindOfCell& kind = description_of(mesh_.kinds[cell]);
    if (kind.kind == CellKind::polyhedron) {
      take_polyhedron(cut_, nodes_of(mesh_, cell), mesh_.points);
      fill_cell(cut_, {.either_winding = true, .may_add_center = true});
      return take_linear(cell);
    }
    check_nodes(mesh_, cell, kind);
    const std::optional<std::uint32_t> curved = curved_.position_of(cell);
    const CellFrame& frame = frame_of(kind.corners);
    take_corners(cell, frame);
    fill_cell(cut_, {.either_winding = frame.either_winding,
                     .may_add_center = !curved,
                     .hexahedron_across = corner_across(cut_, kind.corners)});
    if (!curved) return take_linear(cell);
    if (cut_.tets.empty()) part_.vanished.add(id_of_cell(mesh_, cell));
    for (const CornerTetrahedron& tet : cut_.tets) part_.curved.push_back({*curved, tet});
  }

 private:
  void take_corners(std::uint64_t cell, const CellFrame& frame) {
    const std::span<const std::uint64_t> corners = nodes_of(mesh_, cell).first(frame.corner_count);
    cut_.ids.assign(corners.begin(), corners.end());
    cut_.places.clear();
    for (const std::uint64_t corner : corners) cut_.places.push_back(mesh_.points[corner]);
    add_faces(cut_, frame);
  }

  void take_linear(std::uint64_t cell) {
    const std::uint64_t center = is_center | part_.centers.size();
    if (!cut_.center_weights.empty()) part_.centers.push_back({cut_.ids, cut_.center_weights});
    for (const CornerTetrahedron& tet : cut_.tets) {
      auto& added = part_.tets.emplace_back();
      for (std::size_t i = 0; i < 4; ++i) added[i] = tet[i] < cut_.ids.size() ? cut_.ids[tet[i]] : center;
      part_.cells.push_back(cell);
    }
    if (cut_.tets.empty()) part_.vanished.add(id_of_cell(mesh_, cell));
    if (cut_.inverted_count == 0) return;
    part_.overlapping.add(id_of_cell(mesh_, cell));
    part_.inverted_count += cut_.inverted_count;
  }

  const CellMesh& mesh_;
  const CurvedCells& curved_;
  Part& part_;
  CutCell cut_;
};

void cut_part(const CellMesh& mesh, const CurvedCells& curved, std::size_t begin, std::size_t end, Part& part) {
  CellCutter cutter(mesh, curved, part);
  for (std::uint64_t cell = begin; cell < end; ++cell) try {
      // unchanged; packing decides about its vertices
      if (mesh.kinds[cell] == CellKind::tetrahedron) {
        check_nodes(mesh, cell, description_of(CellKind::tetrahedron));
        const std::span<const std::uint64_t> nodes = nodes_of(mesh, cell);
        part.tets.push_back({nodes[0], nodes[1], nodes[2], nodes[3]});
        part.cells.push_back(cell);
      } else {
        cutter.cut(cell);
      }
    } catch (const Error& error) {
      part.refusal = with_cell(error, id_of_cell(mesh, cell));
      return;
    }
}

std::vector<Part> cut_cells(const CellMesh& mesh, const CurvedCells& curved, const Progress& progress) {
  std::vector<Part> parts((mesh.kinds.size() + cells_per_part - 1) / cells_per_part);
  ProgressMeter meter(progress, "cutting cells into tetrahedra", mesh.kinds.size());
  parallel_for_each(parts.size(), [&](std::size_t p) {
    const std::size_t begin = p * cells_per_part, end = std::min(mesh.kinds.size(), begin + cells_per_part);
    cut_part(mesh, curved, begin, end, parts[p]);
    meter.add(end - begin);
  });
  for (const Part& part : parts)
    if (part.refusal) throw *part.refusal;
  return parts;
}

/// For each point field, whether it is selected, itself or by a component. A field without a name
/// always counts.
std::vector<bool> counted_fields(const CellMesh& mesh, const std::vector<std::string>& names) {
  std::vector<bool> counted;
  for (const NeutralField& field : mesh.point_fields)
    counted.push_back(names.empty() || field.name.empty() ||
                      std::any_of(names.begin(), names.end(), [&](const std::string& name) {
                        return name == field.name || name.starts_with(field.name + ".");
                      }));
  return counted;
}

RefinedCells refine_curved(CellMesh& mesh, const CurvedCells& curved, const std::vector<Part>& parts,
                           const RefineOptions& options, const Progress& progress) {
  if (curved.cells().empty()) return {};
  std::vector<CornerTetrahedronOfCell> tets;
  for (const Part& part : parts) tets.insert(tets.end(), part.curved.begin(), part.curved.end());
  return refine(mesh, curved.cells(), tets, options, progress);
}

/// Adds the points inside linear cells at the end of the mesh's points. Each is a mean of its
/// cell's corners, with their values.
void add_centers(CellMesh& mesh, const std::vector<Part>& parts) {
  const auto mean = [](const Center& center, auto&& value_of) {
    double sum = 0;
    for (std::size_t i = 0; i < center.ids.size(); ++i) sum += center.weights[i] * value_of(center.ids[i]);
    return sum;
  };
  for (const Part& part : parts)
    for (const Center& center : part.centers) {
      std::array<double, 3> place;
      for (std::size_t axis = 0; axis < 3; ++axis)
        place[axis] = mean(center, [&](std::uint64_t id) { return mesh.points[id][axis]; });
      mesh.points.push_back(place);
      for (NeutralField& field : mesh.point_fields) {
        const auto components = static_cast<std::size_t>(field.component_count);
        for (std::size_t c = 0; c < components; ++c)
          field.values.push_back(mean(center, [&](std::uint64_t id) { return field.values[id * components + c]; }));
      }
    }
}

/// The tetrahedra of all cells in the order of the cells, and the cell of each.
struct Assembled {
  Array<std::array<std::uint64_t, 4>> tets;
  Array<std::uint64_t> cells;
};

/// @param first_center  index of the first part's first new point
Assembled assemble(const std::vector<Part>& parts, const RefinedCells& refined, std::span<const CurvedCell> curved,
                   std::uint64_t first_center) {
  Assembled all;
  std::size_t count = refined.tets.size();
  for (const Part& part : parts) count += part.tets.size();
  all.tets.reserve(count);
  all.cells.reserve(count);
  std::size_t next_refined = 0;
  const auto add_refined_before = [&](std::uint64_t cell) {
    for (; next_refined < refined.tets.size(); ++next_refined) {
      const std::uint64_t source = curved[refined.curved_cells[next_refined]].cell;
      if (source >= cell) return;
      all.tets.push_back(refined.tets[next_refined]);
      all.cells.push_back(source);
    }
  };
  for (const Part& part : parts) {
    for (std::size_t t = 0; t < part.tets.size(); ++t) {
      add_refined_before(part.cells[t]);
      std::array<std::uint64_t, 4> tet = part.tets[t];
      for (std::uint64_t& vertex : tet)
        if (vertex & is_center) vertex = first_center + (vertex & ~is_center);
      all.tets.push_back(tet);
      all.cells.push_back(part.cells[t]);
    }
    first_center += part.centers.size();
  }
  add_refined_before(std::numeric_limits<std::uint64_t>::max());
  return all;
}

/// Keeps the points that a tetrahedron uses, and points of the source that no cell used before:
/// packing reports those. Nodes of curved cells and new points that no tetrahedron needs are left
/// out.
void drop_unneeded_points(CellMesh& mesh, std::size_t source_point_count, std::span<const CurvedCell> curved,
                          Assembled& all) {
  constexpr std::uint64_t dropped = std::numeric_limits<std::uint64_t>::max();
  Array<std::uint64_t> number(mesh.points.size(), 0);
  for (const CurvedCell& cell : curved)
    for (const std::uint64_t node : nodes_of(mesh, cell.cell)) number[node] = dropped;
  std::fill(number.begin() + static_cast<std::ptrdiff_t>(source_point_count), number.end(), dropped);
  for (const auto& tet : all.tets)
    for (const std::uint64_t vertex : tet) number[vertex] = 0;

  std::size_t count = 0;
  for (std::size_t p = 0; p < number.size(); ++p) {
    if (number[p] == dropped) continue;
    number[p] = count;
    mesh.points[count] = mesh.points[p];
    for (NeutralField& field : mesh.point_fields) {
      const auto components = static_cast<std::size_t>(field.component_count);
      for (std::size_t c = 0; c < components; ++c)
        field.values[count * components + c] = field.values[p * components + c];
    }
    ++count;
  }
  mesh.points.resize(count);
  for (NeutralField& field : mesh.point_fields)
    field.values.resize(count * static_cast<std::size_t>(field.component_count));
  for (auto& tet : all.tets)
    for (std::uint64_t& vertex : tet) vertex = number[vertex];
}

/// Rounds values computed here, so that fields of 32-bit floats hold only such values; the other
/// values already are.
void round_single_precision(std::vector<NeutralField>& fields) {
  for (NeutralField& field : fields)
    if (field.was_single_precision)
      for (double& value : field.values) value = static_cast<double>(static_cast<float>(value));
}

void repeat_cell_fields(NeutralMesh& result, std::vector<NeutralField>& fields, const Array<std::uint64_t>& cells) {
  for (NeutralField& field : fields) {
    const auto components = static_cast<std::size_t>(field.component_count);
    Array<double> values(cells.size() * components);
    for (std::size_t t = 0; t < cells.size(); ++t)
      for (std::size_t c = 0; c < components; ++c) values[t * components + c] = field.values[cells[t] * components + c];
    field.values = std::move(values);
    result.cell_fields.push_back(std::move(field));
  }
}

// Notes

void note_counts(const CellMesh& mesh, const Array<std::uint64_t>& cells, std::vector<std::string>& notes) {
  struct Count {
    std::uint64_t cells = 0, tets = 0;
  };
  std::map<CellKind, Count> counts;
  for (const CellKind kind : mesh.kinds) ++counts[kind].cells;
  for (const std::uint64_t cell : cells) ++counts[mesh.kinds[cell]].tets;
  for (const auto& [kind, count] : counts)
    if (kind != CellKind::tetrahedron)
      notes.push_back(concat(counted(count.cells, kind), " became ", counted(count.tets, CellKind::tetrahedron)));
}

void note_findings(const std::vector<Part>& parts, std::vector<std::string>& notes) {
  CellTally vanished, overlapping;
  std::uint64_t center_count = 0, inverted_count = 0;
  for (const Part& part : parts) {
    vanished.add(part.vanished);
    overlapping.add(part.overlapping);
    center_count += part.centers.size();
    inverted_count += part.inverted_count;
  }
  if (center_count > 0)
    notes.push_back(concat(with_commas(center_count), center_count == 1 ? " point" : " points",
                           " added inside cells that cannot be cut otherwise"));
  if (vanished.count > 0) notes.push_back(concat(vanished.cells(), " of zero volume left out", vanished.which()));
  if (overlapping.count > 0)
    notes.push_back(concat(overlapping.cells(), overlapping.count == 1 ? " has" : " have",
                           " no inner point that sees all faces; ", counted(inverted_count, CellKind::tetrahedron),
                           " there are inverted and overlap", overlapping.which()));
}

std::string share_text(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", share);
  return text;
}

/// @param counted  for each field whether its error was measured
void note_error(const RefinementError& error, const std::vector<NeutralField>& fields, const std::vector<bool>& counted,
                double max_error, std::vector<std::string>& notes) {
  double largest = error.geometric;
  std::string note = concat("tetrahedra made of curved cells: largest geometric error ", share_text(error.geometric),
                            " of the box diagonal");
  for (std::size_t f = 0; f < fields.size(); ++f) {
    if (!counted[f]) continue;
    largest = std::max(largest, error.of_fields[f]);
    note += concat(", of field \"", fields[f].name, "\" ", share_text(error.of_fields[f]), " of its range");
  }
  if (largest > max_error)
    note += concat("; more than the ", share_text(max_error), " requested, because edges are not cut shorter");
  notes.push_back(note);
}

std::string percent_text(double share) {
  return share < 0.01 ? "less than 1 %" : concat(std::lround(100 * share), " %");
}

/// Notes the errors for which cuts were made, the most frequent first.
void note_cuts(const RefinedCells& refined, const std::vector<NeutralField>& fields, std::vector<std::string>& notes) {
  if (refined.cut_cells == 0) return;
  struct Reason {
    std::uint64_t cuts;
    std::string name;
  };
  std::vector<Reason> reasons{{refined.cut_for[0], "the shape"}};
  for (std::size_t f = 0; f < fields.size(); ++f)
    reasons.push_back({refined.cut_for[1 + f], concat("field \"", fields[f].name, "\"")});
  std::erase_if(reasons, [](const Reason& reason) { return reason.cuts == 0; });
  std::stable_sort(reasons.begin(), reasons.end(), [](const Reason& a, const Reason& b) { return a.cuts > b.cuts; });
  const auto total = static_cast<double>(std::accumulate(refined.cut_for.begin(), refined.cut_for.end(), 0ULL));
  std::string note = concat(with_commas(refined.cut_cells), refined.cut_cells == 1 ? " curved cell" : " curved cells",
                            " cut finer than the corners require: ");
  for (std::size_t r = 0; r < reasons.size(); ++r)
    note += concat(r == 0 ? "" : ", ", percent_text(static_cast<double>(reasons[r].cuts) / total),
                   r == 0 ? " of the cuts for " : " for ", reasons[r].name);
  notes.push_back(note);
}

NeutralMesh move_over(CellMesh& mesh) {
  NeutralMesh result;
  result.points = std::move(mesh.points);
  result.point_fields = std::move(mesh.point_fields);
  result.length_unit = std::move(mesh.length_unit);
  result.notes = std::move(mesh.notes);
  result.sources = std::move(mesh.sources);
  return result;
}

/// A mesh of tetrahedra alone needs no work.
NeutralMesh move_tetrahedra(CellMesh& mesh) {
  NeutralMesh result = move_over(mesh);
  result.cells.resize(mesh.kinds.size());
  if (!mesh.kinds.empty())
    std::memcpy(result.cells.data(), mesh.cell_nodes.data(), mesh.cell_nodes.size() * sizeof(std::uint64_t));
  result.cell_ids = std::move(mesh.cell_ids);
  result.cell_fields = std::move(mesh.cell_fields);
  return result;
}

NeutralMesh subdivided(CellMesh mesh, const SubdivideOptions& options, const Progress& progress) {
  RHORAY_CHECK(mesh.cell_offsets.size() == mesh.kinds.size() + 1 && mesh.cell_offsets.back() == mesh.cell_nodes.size());
  if (!(options.max_error > 0) || !std::isfinite(options.max_error))
    throw Error(ErrorCode::usage, concat("largest error: found ", options.max_error, "; expected a number above 0"));
  const bool is_simple =
      mesh.cell_nodes.size() == 4 * mesh.kinds.size() &&
      std::all_of(mesh.kinds.begin(), mesh.kinds.end(), [](CellKind kind) { return kind == CellKind::tetrahedron; });
  if (is_simple) return move_tetrahedra(mesh);

  const CurvedCells curved(mesh);
  const std::size_t source_point_count = mesh.points.size();
  const std::vector<Part> parts = cut_cells(mesh, curved, progress);
  const std::vector<bool> counted = counted_fields(mesh, options.fields);
  const RefinedCells refined = refine_curved(
      mesh, curved, parts, {.max_error = options.max_error, .counted = counted, .finest = options.finest}, progress);
  const std::uint64_t first_center = mesh.points.size();
  add_centers(mesh, parts);
  Assembled all = assemble(parts, refined, curved.cells(), first_center);

  note_counts(mesh, all.cells, mesh.notes);
  note_findings(parts, mesh.notes);
  if (!curved.cells().empty()) {
    note_cuts(refined, mesh.point_fields, mesh.notes);
    note_error(refined.error, mesh.point_fields, counted, options.max_error, mesh.notes);
    drop_unneeded_points(mesh, source_point_count, curved.cells(), all);
  }
  round_single_precision(mesh.point_fields);

  NeutralMesh result = move_over(mesh);
  result.cells = std::move(all.tets);
  result.cell_ids.resize(all.cells.size());
  for (std::size_t t = 0; t < all.cells.size(); ++t) result.cell_ids[t] = id_of_cell(mesh, all.cells[t]);
  repeat_cell_fields(result, mesh.cell_fields, all.cells);
  return result;
}

}  // namespace

NeutralMesh subdivide(CellMesh mesh, const SubdivideOptions& options, const Progress& progress) {
  const DefaultFloatingPoint default_floating_point;
  return subdivided(std::move(mesh), options, progress);
}

}  // namespace rhoray::preprocess
