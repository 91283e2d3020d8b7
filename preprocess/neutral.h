#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <memory_resource>
#include <string>
#include <vector>

#include "formats/base/affine.h"
#include "formats/label_names.h"
#include "formats/packed_file.h"
#include "formats/space.h"
#include "preprocess/source_file.h"

namespace rhoray::preprocess {

/// An array whose size grows with the data. The memory resource decides where it is stored. This is
/// the default resource, unless a run under a memory cap has set another.
template <class T>
using Array = std::pmr::vector<T>;

/// The content of a foreign file in Rhoray's own types, before anything is decided about it.
/// Importers make these; the commands (pack, tetrahedralize) take them. Between processes they
/// travel as packed files (process/messages.h).

/// An array of a file and how many numbers it has for each sample (components.h).
struct VectorArray {
  std::string name;
  int component_count = 2;
};

/// Samples on a regular lattice, x fastest: one value each, or colours.
struct NeutralVolume {
  Index3 sample_count;
  /// per sample, interleaved; colours have 3 (red, green, blue) or 4 (and alpha)
  int component_count = 1;
  formats::ElementType type = formats::ElementType::U8;
  Array<std::byte> owned_samples;       ///< either these
  std::shared_ptr<const void> mapping;  ///< or a mapping, or else the caller, keeps `samples` alive
  /// native byte order, component_count x volume(sample_count) elements
  std::span<const std::byte> samples;
  /// when not empty, `mapping` is of this file and holds `samples`
  std::filesystem::path samples_file;
  std::uint64_t samples_first_byte = 0;
  Affine world_from_grid;
  /// Positions of the samples along each axis in the frame of world_from_grid, ascending. Empty =
  /// at 0, 1, 2, ...
  std::array<std::vector<double>, 3> axes;
  std::string length_unit;
  formats::Space space = formats::Space::unknown;  ///< of world coordinates
  std::string field_name;
  std::string field_unit;
  formats::LabelNames label_names;
  /// names of further scalar fields in the file, as `--field` takes them
  std::vector<std::string> other_fields;
  std::vector<VectorArray> vectors;  ///< arrays of several numbers; `--field` takes their scalars
  std::vector<std::string> notes;    ///< what reading changed or left out, one sentence each
  std::vector<SourceFile> sources;   ///< the files that were read or looked for
};

/// Values at points or in cells: `component_count` numbers for each, interleaved.
struct NeutralField {
  std::string name;
  std::string unit;
  int component_count = 1;
  /// the source held 32-bit floats or small integers: F32 keeps every bit
  bool was_single_precision = true;
  Array<double> values;
  formats::LabelNames label_names{};
};

/// Kinds of volume cells. Numbers and node orders are those of VTK 9 (its vtkCellType.h is the
/// reference).
enum class CellKind : std::uint8_t {
  tetrahedron = 10,
  voxel = 11,
  hexahedron = 12,
  wedge = 13,
  pyramid = 14,
  pentagonal_prism = 15,
  hexagonal_prism = 16,
  quadratic_tetrahedron = 24,             ///< 10 nodes
  quadratic_hexahedron = 25,              ///< 20
  quadratic_wedge = 26,                   ///< 15
  quadratic_pyramid = 27,                 ///< 13
  triquadratic_hexahedron = 29,           ///< 27
  quadratic_linear_wedge = 31,            ///< 12
  biquadratic_quadratic_wedge = 32,       ///< 18
  biquadratic_quadratic_hexahedron = 33,  ///< 24
  triquadratic_pyramid = 37,              ///< 19 (in VTK since 9.2)
  polyhedron = 42,
  lagrange_tetrahedron = 71,
  lagrange_hexahedron = 72,
  lagrange_wedge = 73,
  lagrange_pyramid = 74,
  /// Exodus PYRAMID14: 13 nodes and the centre of the base; not in VTK
  quadratic_pyramid_14 = 200,
  quadratic_tetrahedron_14 =
      /// Exodus TETRA14: 10 nodes and the middles of faces 0-1-3, 1-2-3, 0-3-2, 0-2-1; not in VTK
  201
};

/// A mesh of volume cells of any kind, as read from a foreign file. Cell c has the nodes
/// cell_nodes[cell_offsets[c] .. cell_offsets[c+1]-1]. The nodes of a polyhedron are a stream of
/// its faces: the face count, then for each face its corner count and its corners. Lines and faces
/// were left out and are counted in notes.
struct CellMesh {
  Array<std::array<double, 3>> points;
  Array<CellKind> kinds;
  Array<std::uint64_t> cell_offsets{0};
  Array<std::uint64_t> cell_nodes;  ///< not yet checked
  Array<std::uint64_t> cell_ids;    ///< index in the source; empty when nothing was left out
  std::vector<NeutralField> point_fields;
  std::vector<NeutralField> cell_fields;
  std::string length_unit;
  std::vector<std::string> notes;
  std::vector<SourceFile> sources;  ///< as in NeutralVolume
};

/// An unstructured mesh of tetrahedra, read as such or made from cells of other kinds.
struct NeutralMesh {
  Array<std::array<double, 3>> points;
  Array<std::array<std::uint64_t, 4>> cells;  ///< VTK vertex order as given; not yet checked
  /// index in the source of the cell that each was or was part of; empty = its own index
  Array<std::uint64_t> cell_ids;
  std::vector<NeutralField> point_fields;
  std::vector<NeutralField> cell_fields;
  std::string length_unit;
  std::vector<std::string> notes;
  std::vector<SourceFile> sources;  ///< as in NeutralVolume
};

/// Polygons in space, to be filled with tetrahedra.
struct NeutralSurface {
  struct Region {
    std::array<double, 3> seed;  ///< a point inside
    double attribute = 0;        ///< becomes the cell field "region"
    double max_volume = 0;       ///< of its tetrahedra; 0 = no limit
  };
  Array<std::array<double, 3>> points;
  Array<double> point_sizes;  ///< target edge length at each point (TetGen .mtr); empty = not given
  /// Facet f has the corners facet_corners[facet_offsets[f] .. facet_offsets[f+1]-1].
  Array<std::uint64_t> facet_offsets{0};
  Array<std::uint64_t> facet_corners;  ///< indices of points
  /// Facets that make one planar face together (TetGen .poly: an outline and what lies in it) are
  /// consecutive and carry the same number here: 0, 1, 2, ... Empty = every facet is a face of its
  /// own.
  Array<std::uint64_t> facet_faces;
  struct Opening {
    std::uint64_t face = 0;      ///< a number of facet_faces
    std::array<double, 3> seed;  ///< a point inside an outline of that face that is left open
  };
  std::vector<Opening> openings;
  Array<std::array<double, 3>> holes;  ///< a point inside each cavity
  std::vector<Region> regions;
  std::vector<std::string> notes;
  std::vector<SourceFile> sources;  ///< as in NeutralVolume
};

}  // namespace rhoray::preprocess
