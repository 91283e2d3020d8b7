#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/vector.h"
#include "preprocess/import/reading/grid_cover.h"
#include "preprocess/import/vtk/vtk_xml_stream.h"

namespace rhoray::preprocess {

/// The pieces of a structured VTK XML file, which cover its whole extent exactly once. An array of
/// the whole is put together from its part in each piece.
class StructuredPieces {
 public:
  /// The parts of one array, one for each piece.
  using Parts = std::vector<VtkXmlArray>;

  /// Refuses extents that are not six numbers, sizes that the file cannot hold, and pieces that
  /// leave a gap or overlap. `file` must outlive this object.
  explicit StructuredPieces(const VtkXmlStream& file);
  /// The same for pieces in files of their own. `whole` has the extent of all.
  StructuredPieces(const VtkXmlStream& whole, const std::vector<const VtkXmlStream*>& files);

  Index3 point_count() const { return owner_count(whole_, false); }
  /// Indices of the first point: parts of larger grids do not begin at 0.
  Index3 first_point() const { return whole_.first; }

  /// The arrays of PointData, CellData, Points or Coordinates. Refuses pieces with different ones.
  /// @param left_out  as for VtkXmlStream::arrays_in
  std::vector<Parts> arrays(std::string_view section, std::vector<std::string>* left_out = nullptr) const;

  /// Number of numbers in an array of the whole. Refuses more than the file can hold.
  std::uint64_t checked_count(const Parts& parts, bool in_cells) const;

  /// Reads an array of points or cells. T is double, or std::byte for numbers in native byte order.
  template <class T>
  void read(const Parts& parts, bool in_cells, std::span<T> to) const;

  /// Adds the notes of all files about the arrays that were read.
  void add_notes(std::vector<std::string>& notes) const;

  /// Reads the positions along an axis, which each piece has for its own extent.
  std::vector<double> coordinates(const Parts& parts, int axis) const;

 private:
  struct Piece {
    const VtkXmlStream* file;
    const XmlElement* element;
    GridExtent extent;
  };

  static GridExtent extent_of(const VtkXmlStream& file, const XmlElement& element, std::string_view name);
  void add_pieces(const VtkXmlStream& file);
  void check_cover() const;

  const VtkXmlStream& file_;
  GridExtent whole_;
  std::vector<Piece> pieces_;
};

}  // namespace rhoray::preprocess
