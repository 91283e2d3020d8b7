#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "formats/base/affine.h"
#include "formats/packed_file.h"

namespace rhoray::preprocess {

/// What a foreign file holds, in our words, before anything is decided about it. Importers make these; the verbs
/// (pack, tetrahedralize) take them. Between processes they travel as packed files (worker/handover.h).

/// Samples on a regular lattice, x fastest, one value each.
struct NeutralVolume {
  Index3 sample_count;
  formats::ElementType type = formats::ElementType::U8;
  std::vector<std::byte> owned_samples;  ///< either these,
  std::shared_ptr<const void> mapping;   ///< or a mapping that keeps `samples` alive
  std::span<const std::byte> samples;    ///< native byte order, volume(sample_count) elements
  Affine world_from_grid;
  std::string length_unit;
  std::string field_name;
  std::string field_unit;
  std::vector<std::string> notes;  ///< what reading changed or left out, one sentence each
};

/// Values at points or in cells: `component_count` numbers for each, interleaved.
struct NeutralField {
  std::string name;
  std::string unit;
  int component_count = 1;
  bool was_single_precision = true;  ///< the source held 32-bit floats or small integers: F32 keeps every bit
  std::vector<double> values;
};

/// An unstructured mesh of tetrahedra. Cells of other kinds were left out and counted in notes, or refused.
struct NeutralMesh {
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<std::uint64_t, 4>> cells;  ///< VTK vertex order as given; not yet checked
  std::vector<std::uint64_t> cell_ids;              ///< position in the source; empty when nothing was left out
  std::vector<NeutralField> point_fields;
  std::vector<NeutralField> cell_fields;
  std::string length_unit;
  std::vector<std::string> notes;
};

/// Polygons in space, to be filled with tetrahedra.
struct NeutralSurface {
  struct Region {
    std::array<double, 3> seed;  ///< a point inside
    double attribute = 0;        ///< becomes the cell field "region"
    double max_volume = 0;       ///< of its tetrahedra; 0 = no limit
  };
  std::vector<std::array<double, 3>> points;
  std::vector<double> point_sizes;  ///< wanted edge length at each point (TetGen .mtr); empty = not given
  /// Facet f has the corners facet_corners[facet_offsets[f] .. facet_offsets[f+1]-1].
  std::vector<std::uint64_t> facet_offsets{0};
  std::vector<std::uint64_t> facet_corners;  ///< positions of points
  /// Facets that make one planar face together, an outline and what lies in it (TetGen .poly), stand side by side and
  /// carry the same number here: 0, 1, 2, ... Empty = every facet is a face of its own.
  std::vector<std::uint64_t> facet_faces;
  struct Opening {
    std::uint64_t face = 0;      ///< a number of facet_faces
    std::array<double, 3> seed;  ///< a point inside an outline of that face that is left open
  };
  std::vector<Opening> openings;
  std::vector<std::array<double, 3>> holes;  ///< a point inside each cavity
  std::vector<Region> regions;
  std::vector<std::string> notes;
};

}  // namespace rhoray::preprocess
