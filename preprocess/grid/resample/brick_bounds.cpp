#include "preprocess/grid/resample/brick_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t edge = Neighborhood::edge;
// for one leaf cell's faces; a tenfold refinement would take a few hundred
constexpr std::size_t largest_piece_count = 4096;

std::size_t place_of(std::size_t block, std::size_t cell) {
  const auto [i, j, k] = QuickBounds::place(block, cell);
  return Neighborhood::place(i, j, k);
}

/// A bound in the brick need not be below this value.
double goal_of(const BrickErrors& errors, const FieldView& field, double good_enough) {
  return std::max({errors.attained * (1 + BrickBounds::relative_gap),
                   errors.attained + BrickBounds::gap_of_range * field.range, good_enough});
}

PatchPoint middle(const PatchPoint& a, const PatchPoint& b) {
  return {{0.5 * (a.at[0] + b.at[0]), 0.5 * (a.at[1] + b.at[1]), 0.5 * (a.at[2] + b.at[2])}, 0.5 * (a.value + b.value)};
}

}  // namespace

void BrickBounds::enter(std::size_t slot) {
  brick_ = touched_.at(slot);
  for (std::size_t a = 0; a < 3; ++a)
    first_[a] = static_cast<double>(brick_[static_cast<int>(a)] * SampleLattice::brick_edge);
  cells_ = touched_.lists.view().list(touched_.bricks[slot]);
  faces_.enter(first_, cells_);
  quick_.enter(first_, cells_);
}

void BrickBounds::bound(const FieldView& field, std::size_t f, double good_enough, BrickErrors& errors) {
  samples_nearby_.gather(touched_, brick_, samples_.fields[f]);
  if (samples_nearby_.covered_count() == 0) return;
  take_conflicts(field, errors);
  refine(field, good_enough, errors);
  errors.bound += field.noise;
}

/// Marks leaf cells around samples that several mesh cells claim. Their difference is attained, and
/// the quick bounds do not account for it. Samples in bricks beside this one count where they are
/// corners of its leaf cells.
void BrickBounds::take_conflicts(const FieldView& field, BrickErrors& errors) {
  conflicts_.reset();
  if (field.conflicts.empty()) return;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::uint32_t slot = touched_.slot(brick_ + Index3(corner & 1, corner >> 1 & 1, corner >> 2));
    if (slot == TouchedBricks::none) continue;
    auto conflict = std::lower_bound(field.conflicts.begin(), field.conflicts.end(), slot,
                                     [](const Conflict& c, std::uint32_t wanted) { return c.slot < wanted; });
    for (; conflict != field.conflicts.end() && conflict->slot == slot; ++conflict) {
      const std::size_t s = conflict->sample;
      const std::array<std::size_t, 3> sample{s % edge + (corner & 1 ? edge : 0),
                                              s / edge % edge + (corner & 2 ? edge : 0),
                                              s / edge / edge + (corner & 4 ? edge : 0)};
      take_conflict(sample, conflict->difference, errors);
    }
  }
}

void BrickBounds::take_conflict(const std::array<std::size_t, 3>& sample, double difference, BrickErrors& errors) {
  for (std::size_t around = 0; around < 8; ++around) {
    std::array<std::size_t, 3> cell;
    bool is_here = true;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t back = around >> a & 1;
      is_here = is_here && sample[a] >= back && sample[a] - back < edge;
      cell[a] = sample[a] - back;
    }
    if (!is_here) continue;
    const std::size_t p = Neighborhood::place(cell[0], cell[1], cell[2]);
    if (!samples_nearby_.is_covered(p)) continue;
    conflicts_.set(p);
    if (has_data(difference)) errors.attain(difference, plus(first_, corner_of(sample[0], sample[1], sample[2])));
  }
}

/// Examines the faces in leaf cells, those with the largest quick bounds first, until no other can
/// exceed goal_of.
void BrickBounds::refine(const FieldView& field, double good_enough, BrickErrors& errors) {
  errors.bound = errors.attained;
  quick_.bound_blocks(field);
  const double goal = goal_of(errors, field, good_enough);
  const std::uint64_t blocks = blocks_above(goal, field, errors);
  if (blocks != 0) {
    quick_.bound_cells(blocks, faces_);
    find_candidates(blocks, goal, field, errors);
    for (const Candidate& candidate : candidates_) {
      if (candidate.bound <= goal_of(errors, field, good_enough))
        errors.bound = std::max(errors.bound, candidate.bound);
      else
        refine_cell(candidate, field, good_enough, errors);
    }
  }
  errors.bound = std::max(errors.bound, errors.attained);
}

std::uint64_t BrickBounds::blocks_above(double goal, const FieldView& field, BrickErrors& errors) const {
  std::uint64_t blocks = 0;
  for (std::size_t block = 0; block < QuickBounds::block_count; ++block) {
    bool is_covered = samples_nearby_.is_whole(), has_conflict = false;
    for (std::size_t cell = 0; cell < 8 && !is_covered; ++cell)
      is_covered = samples_nearby_.is_covered(place_of(block, cell));
    if (!is_covered) continue;
    for (std::size_t cell = 0; cell < 8 && conflicts_.any(); ++cell)
      has_conflict = has_conflict || conflicts_[place_of(block, cell)];
    const double bound = quick_.of_block(block) * field.unit;
    if (bound <= goal && !has_conflict)
      errors.bound = std::max(errors.bound, bound);
    else
      blocks |= std::uint64_t{1} << block;
  }
  return blocks;
}

void BrickBounds::find_candidates(std::uint64_t blocks, double goal, const FieldView& field, BrickErrors& errors) {
  candidates_.clear();
  for (std::uint32_t block = 0; block < QuickBounds::block_count; ++block) {
    if ((blocks >> block & 1) == 0) continue;
    for (std::uint32_t cell = 0; cell < 8; ++cell) {
      const std::size_t p = place_of(block, cell);
      if (!samples_nearby_.is_covered(p)) continue;
      const double bound =
          conflicts_[p] ? std::numeric_limits<double>::infinity() : quick_.of_cell(block, cell) * field.unit;
      if (bound <= goal)
        errors.bound = std::max(errors.bound, bound);
      else
        candidates_.push_back({bound, block, cell});
    }
  }
  std::sort(candidates_.begin(), candidates_.end(), [&](const Candidate& a, const Candidate& b) {
    if (a.bound != b.bound) return a.bound > b.bound;
    return a.block != b.block ? a.block < b.block : a.cell < b.cell;
  });
}

void BrickBounds::refine_cell(const Candidate& candidate, const FieldView& field, double good_enough,
                              BrickErrors& errors) {
  const auto [i, j, k] = QuickBounds::place(candidate.block, candidate.cell);
  const LeafCell leaf{corner_of(i, j, k), samples_nearby_.corners(i, j, k)};
  const Point center = plus(leaf.low, {0.5, 0.5, 0.5});
  const CellPlane plane(leaf.corners);
  pieces_.clear();
  quick_.for_each_cell_at(candidate.block, candidate.cell, [&](std::size_t n) {
    for (std::size_t side = 0; side < 4; ++side) {
      if (neighbors_.cells[cells_[n]][side] < cells_[n])
        continue;  // handled with the other cell; `none` is above all cells
      const BrickFace& face = faces_.at(n, side);
      if (face.may_touch(center)) add_face(face, leaf, plane, field, good_enough, errors);
    }
  });
  for (std::size_t count = 0; !pieces_.empty() && count < largest_piece_count; ++count) {
    if (pieces_.front().upper <= goal_of(errors, field, good_enough)) break;
    std::pop_heap(pieces_.begin(), pieces_.end());
    const std::array<PatchPoint, 3> t = pieces_.back().triangle;
    pieces_.pop_back();
    const PatchPoint a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
    for (const auto& piece :
         {std::array{t[0], a, c}, std::array{a, t[1], b}, std::array{c, b, t[2]}, std::array{a, b, c}})
      add_piece(piece, leaf, field, good_enough, errors);
  }
  if (!pieces_.empty()) errors.bound = std::max(errors.bound, pieces_.front().upper);
}

void BrickBounds::add_face(const BrickFace& face, const LeafCell& leaf, const CellPlane& plane, const FieldView& field,
                           double good_enough, BrickErrors& errors) {
  const double face_bound = plane.bound_on(face, field, leaf.low);
  if (face_bound * (1 + relative_gap) <= goal_of(errors, field, good_enough)) {
    errors.bound = std::max(errors.bound, face_bound);
    return;
  }
  std::array<PatchPoint, 3> triangle;
  for (std::size_t v = 0; v < 3; ++v) {
    triangle[v] = {minus(face.corners[v], leaf.low), field.values[face.vertices[v]]};
    if (!has_data(triangle[v].value)) return;
  }
  const ClippedTriangle clipped(triangle);
  for (std::size_t c = 2; c < clipped.size(); ++c)
    add_piece({clipped[0], clipped[c - 1], clipped[c]}, leaf, field, good_enough, errors);
}

void BrickBounds::add_piece(const std::array<PatchPoint, 3>& triangle, const LeafCell& leaf, const FieldView& field,
                            double good_enough, BrickErrors& errors) {
  const PatchBounds bounds = patch_bounds(triangle, leaf.corners);
  errors.attain(bounds.attained, plus(first_, plus(leaf.low, bounds.at)));
  if (bounds.upper <= goal_of(errors, field, good_enough)) {
    errors.bound = std::max(errors.bound, bounds.upper);
    return;
  }
  pieces_.push_back({bounds.upper, triangle});
  std::push_heap(pieces_.begin(), pieces_.end());
}

}  // namespace rhoray::preprocess
