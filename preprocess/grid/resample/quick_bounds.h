#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "preprocess/grid/resample/brick_faces.h"
#include "preprocess/grid/resample/faces.h"
#include "preprocess/grid/resample/field_view.h"
#include "preprocess/grid/resample/lattice.h"

namespace rhoray::preprocess {

/// By cell: bit f is set where face f has no neighbour, so that the mesh may end or disagree there.
/// Faces in a side of the lattice are left out: no leaf cell reaches beyond them.
std::vector<std::uint8_t> find_open_faces(const CleanMesh& mesh, const FaceNeighbors& neighbors,
                                          const SampleLattice& lattice);

/// Bounds of the difference between the trilinear field and the mesh's field in the leaf cells of a
/// brick, from the gradients alone.
///
/// A trilinear function that agrees with a field L at the corners c of a leaf cell is a weighted
/// mean of L(c). Its weights preserve linear functions. Suppose that the gradients of L, on the way
/// from a point x to the corners, differ from some vector G by at most r on each axis (half their
/// range). Then L(c) - G (c - x) differs from L(x) by at most r |c - x|. The weighted mean of |c -
/// x| is at most half a step on each axis:
///
///      |trilinear - L|  <=  a quarter of the sum of the gradients' ranges on the three axes
///
/// The bound is infinite where a cell without a gradient or an open face makes the way to the
/// corners uncertain. A cell counts as touching a leaf cell unless its box or its faces' planes
/// separate them. Blocks of 2 x 2 x 2 leaf cells are bounded first, then the leaf cells of the
/// selected blocks.
class QuickBounds {
 public:
  static constexpr std::size_t block_count = 64;

  QuickBounds(const CleanMesh& mesh, const std::vector<Point>& steps, const FaceNeighbors& neighbors,
              const std::vector<std::uint8_t>& open_faces)
      : mesh_(mesh), steps_(steps), neighbors_(neighbors), open_faces_(open_faces) {}

  /// Finds the cells in each block of a brick, for all fields.
  /// @param cells  those of the brick; must stay valid until the next one
  void enter(const Point& first, std::span<const std::uint32_t> cells);

  /// Bounds blocks, in units of the field. No leaf cell of a block has a larger bound.
  void bound_blocks(const FieldView& field);
  double of_block(std::size_t block) const { return static_cast<double>(of_blocks_[block]); }

  /// After bound_blocks: bounds the leaf cells of some blocks, for the same field.
  /// @param blocks  a bit for each
  void bound_cells(std::uint64_t blocks, BrickFaces& faces);
  /// Bound of leaf cell `cell` (0 to 7, x fastest) of a block passed to bound_cells.
  double of_cell(std::size_t block, std::size_t cell) const { return static_cast<double>(of_cells_[block][cell]); }

  /// The first sample of a block's leaf cell, relative to that of the brick.
  static std::array<std::size_t, 3> place(std::size_t block, std::size_t cell) {
    return {block % 4 * 2 + cell % 2, block / 4 % 4 * 2 + cell / 2 % 2, block / 16 * 2 + cell / 4};
  }

  /// After bound_cells: calls visit(n) for the brick's cells that touch a leaf cell of a block
  /// passed to it. n is the index in the brick's list.
  template <class Visit>
  void for_each_cell_at(std::size_t block, std::size_t cell, Visit&& visit) const {
    for (std::uint32_t t = last_touch_[block]; t != none; t = touches_[t].previous)
      if ((touches_[t].leaf_cells >> cell & 1) != 0) visit(touches_[t].shape);
  }

 private:
  using Four = float __attribute__((vector_size(16)));
  using FourBits = std::int32_t __attribute__((vector_size(16)));
  static constexpr std::uint32_t none = 0xffffffff;

  /// A cell as half spaces, one lane for each face, and a box. Both are larger than the cell by
  /// more than rounding.
  struct Shape {
    Four x, y, z;  ///< inward normals
    Four offset;   ///< their products with a point inside are at least -offset
    Four reach;    ///< distance of the corners of a leaf cell from its centre along a normal
    std::array<float, 3> low, high;
    std::uint64_t blocks;  ///< those that it touches
  };
  /// The lowest and highest gradients on the three axes, for N blocks or leaf cells.
  template <std::size_t N>
  struct Ranges {
    std::array<std::array<float, N>, 3> low, high;
  };
  struct Slope {
    std::array<float, 3> low, high;
  };
  /// The leaf cells of a block that a cell touches.
  struct Touch {
    std::uint32_t shape, previous;
    std::uint8_t leaf_cells;
  };

  static Shape shape_of(const std::array<std::array<float, 4>, 3>& points);
  static std::uint64_t blocks_of(const Shape& shape);
  static std::uint8_t leaf_cells_of(const Shape& shape, std::size_t block);
  static Slope slope_of(const Gradient& gradient, const Point& base, double unit);
  template <std::size_t N>
  static void clear(Ranges<N>& ranges);
  template <std::size_t N>
  static void include(const Slope& slope, std::uint32_t lanes, std::size_t first, Ranges<N>& ranges);
  template <std::size_t N>
  static std::array<float, N> bounds_of(const Ranges<N>& ranges);
  void mark_open_faces(std::size_t n, std::size_t block, std::uint8_t leaf_cells, BrickFaces& faces);

  const CleanMesh& mesh_;
  const std::vector<Point>& steps_;
  const FaceNeighbors& neighbors_;
  const std::vector<std::uint8_t>& open_faces_;

  std::span<const std::uint32_t> cells_;
  std::vector<Shape> shapes_;      ///< by the brick's cells
  std::vector<Slope> slopes_;      ///< of the field, by the brick's cells
  std::uint64_t open_blocks_ = 0;  ///< with a cell that has an open face
  Ranges<block_count> ranges_;
  std::array<float, block_count> of_blocks_{};
  std::array<Ranges<8>, block_count> cell_ranges_;
  std::array<std::array<float, 8>, block_count> of_cells_{};
  std::array<std::uint32_t, block_count> last_touch_{};
  std::vector<Touch> touches_;
};

}  // namespace rhoray::preprocess
