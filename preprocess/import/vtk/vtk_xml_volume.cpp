// Volumes in VTK XML files: images (.vti) and rectilinear grids (.vtr), and their pieces in several
// files (.pvti, .pvtr).

#include <algorithm>

#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/vtk/piece_files.h"
#include "preprocess/import/vtk/structured_pieces.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// The lattice of an ImageData element.
PointGrid image_grid(const VtkXmlStream& file, const StructuredPieces& pieces) {
  const auto numbers = [&]<std::size_t N>(std::string_view name, const std::array<double, N>& otherwise) {
    const std::string_view text = file.data_set().attribute(name);
    const auto found = text.empty() ? std::optional(otherwise) : numbers_in<double, N>(text);
    if (!found) file.refuse_attribute(name, in_quotes(text), concat(N, " numbers"));
    return *found;
  };
  const auto origin = numbers("Origin", std::array<double, 3>{0, 0, 0});
  const auto spacing = numbers("Spacing", std::array<double, 3>{1, 1, 1});
  const auto direction = numbers("Direction", std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1});
  const auto column = [&](std::size_t axis) {
    return spacing[axis] * Vec3(direction[axis], direction[3 + axis], direction[6 + axis]);
  };
  PointGrid grid{pieces.point_count(), {column(0), column(1), column(2), Vec3(origin[0], origin[1], origin[2])}};
  grid.world_from_grid.origin = grid.world_from_grid.point(Vec3(pieces.first_point()));
  return grid;
}

PointGrid rectilinear(const VtkXmlStream& file, const StructuredPieces& pieces, const std::filesystem::path& path) {
  const auto arrays = pieces.arrays("Coordinates");
  if (arrays.size() != 3) file.refuse("element Coordinates", concat(arrays.size(), " arrays"), "3");
  std::array<std::vector<double>, 3> positions;
  double precision = 0x1p-52;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    positions[axis] = pieces.coordinates(arrays[axis], static_cast<int>(axis));
    if (formats::element_bytes(arrays[axis].front().type) < 8) precision = 0x1p-23;
  }
  return rectilinear_grid(path, positions, precision);
}

/// Arrays at points and in cells, to be read when they are chosen.
std::vector<GridArray> arrays_of(const StructuredPieces& pieces) {
  std::vector<GridArray> arrays;
  for (const bool in_cells : {false, true})
    for (const StructuredPieces::Parts& parts : pieces.arrays(in_cells ? "CellData" : "PointData")) {
      const VtkXmlArray& array = parts.front();
      arrays.push_back({.name = array.name,
                        .type = array.type,
                        .component_count = array.component_count,
                        .in_cells = in_cells,
                        .unit = array.unit,
                        .values = {},
                        .load = [&pieces, parts, in_cells] {
                          const std::uint64_t count = pieces.checked_count(parts, in_cells);
                          Array<std::byte> bytes(count * formats::element_bytes(parts.front().type));
                          pieces.read(parts, in_cells, std::span<std::byte>(bytes));
                          return bytes;
                        }});
    }
  return arrays;
}

NeutralVolume with_notes(NeutralVolume volume, const StructuredPieces& pieces) {
  pieces.add_notes(volume.notes);
  return volume;
}

NeutralVolume read_image(const std::filesystem::path& path, const std::string& field, TakeField* take) {
  const ForeignFile source(path);
  const VtkXmlStream file(source, "ImageData");
  const StructuredPieces pieces(file);
  return with_notes(take(path, image_grid(file, pieces), arrays_of(pieces), field), pieces);
}

NeutralVolume read_image_pieces(const std::filesystem::path& path, const std::string& field, TakeField* take) {
  const ForeignFile source(path);
  const VtkXmlStream file(source, "PImageData");
  const PieceFiles parts(file, path, "ImageData");
  const StructuredPieces pieces(file, parts.streams());
  return with_notes(take(path, image_grid(file, pieces), arrays_of(pieces), field), pieces);
}

}  // namespace

NeutralVolume read_vti(const std::filesystem::path& path, const std::string& field) {
  return read_image(path, field, volume_of_field);
}

NeutralVolume read_vti_colors(const std::filesystem::path& path, const std::string& field) {
  return read_image(path, field, colors_of_field);
}

NeutralVolume read_vtr(const std::filesystem::path& path, const std::string& field) {
  const ForeignFile source(path);
  const VtkXmlStream file(source, "RectilinearGrid");
  const StructuredPieces pieces(file);
  return with_notes(volume_of_field(path, rectilinear(file, pieces, path), arrays_of(pieces), field), pieces);
}

NeutralVolume read_pvti(const std::filesystem::path& path, const std::string& field) {
  return read_image_pieces(path, field, volume_of_field);
}

NeutralVolume read_pvti_colors(const std::filesystem::path& path, const std::string& field) {
  return read_image_pieces(path, field, colors_of_field);
}

NeutralVolume read_pvtr(const std::filesystem::path& path, const std::string& field) {
  const ForeignFile source(path);
  const VtkXmlStream file(source, "PRectilinearGrid");
  const PieceFiles parts(file, path, "RectilinearGrid");
  const StructuredPieces pieces(file, parts.streams());
  return with_notes(volume_of_field(path, rectilinear(file, pieces, path), arrays_of(pieces), field), pieces);
}

}  // namespace rhoray::preprocess
