#include "preprocess/import/vtk/vti_stream.h"

#include <algorithm>
#include <array>
#include <vector>

#include "preprocess/import/reading/numbers.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/vtk/vtk_xml_stream.h"

namespace rhoray::preprocess {
namespace {

/// N numbers separated by spaces; `otherwise` if the text is empty; nothing for anything else.
template <class T, std::size_t N>
std::optional<std::array<T, N>> numbers_in(std::string_view text, const std::array<T, N>& otherwise) {
  constexpr std::string_view spaces = " \t\r\n";
  if (text.empty()) return otherwise;
  std::array<T, N> numbers{};
  std::size_t at = 0;
  for (T& number : numbers) {
    at = std::min(text.find_first_not_of(spaces, at), text.size());
    const std::size_t end = std::min(text.find_first_of(spaces, at), text.size());
    const std::optional<T> found = parse_number<T>(text.substr(at, end - at));
    if (!found) return std::nullopt;
    number = *found;
    at = end;
  }
  return text.find_first_not_of(spaces, at) == text.npos ? std::optional(numbers) : std::nullopt;
}

/// The lattice of an ImageData element with one piece that covers it.
std::optional<PointGrid> grid_of(const XmlElement& image, const XmlElement& piece) {
  using Extent = std::array<std::int32_t, 6>;
  const std::optional<Extent> whole = numbers_in(image.attribute("WholeExtent"), Extent{0, -1, 0, -1, 0, -1});
  const auto origin = numbers_in(image.attribute("Origin"), std::array<double, 3>{0, 0, 0});
  const auto spacing = numbers_in(image.attribute("Spacing"), std::array<double, 3>{1, 1, 1});
  const auto direction = numbers_in(image.attribute("Direction"), std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1});
  if (!whole || !origin || !spacing || !direction || numbers_in(piece.attribute("Extent"), Extent{}) != whole)
    return std::nullopt;
  PointGrid grid;
  Vec3 first;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t begin = (*whole)[2 * static_cast<std::size_t>(axis)];
    const std::int64_t end = (*whole)[2 * static_cast<std::size_t>(axis) + 1];
    if (end < begin) return std::nullopt;
    grid.point_count[axis] = end - begin + 1;
    first[axis] = static_cast<double>(begin);
  }
  const auto column = [&](std::size_t axis) {
    return (*spacing)[axis] * Vec3((*direction)[axis], (*direction)[3 + axis], (*direction)[6 + axis]);
  };
  grid.world_from_grid = {column(0), column(1), column(2), Vec3((*origin)[0], (*origin)[1], (*origin)[2])};
  // parts of larger images do not begin at 0
  grid.world_from_grid.origin = grid.world_from_grid.point(first);
  return grid;
}

/// Number of points, or of cells: one fewer on each axis with more than one point.
std::uint64_t owner_count(const Index3& points, bool in_cells) {
  std::uint64_t count = 1;
  for (int axis = 0; axis < 3; ++axis)
    count *= static_cast<std::uint64_t>(in_cells ? std::max<std::int64_t>(points[axis] - 1, 1) : points[axis]);
  return count;
}

/// Adds the arrays of PointData or CellData, to be read when they are chosen. False if one of them
/// needs VTK's reader.
bool add_arrays(std::vector<GridArray>& arrays, const VtkXmlStream& file, const XmlElement* data,
                const Index3& point_count, bool in_cells) {
  const std::optional<std::vector<VtkXmlArray>> found = file.arrays_in(data);
  if (!found) return false;
  for (const VtkXmlArray& array : *found) {
    GridArray& added = arrays.emplace_back();
    added.name = array.name;
    added.type = array.type;
    added.component_count = array.component_count;
    added.in_cells = in_cells;
    added.load = [&file, array, owners = owner_count(point_count, in_cells)] {
      const std::uint64_t count = owners * static_cast<std::uint64_t>(array.component_count);
      file.check_count(array, count);
      Array<std::byte> bytes(count * formats::element_bytes(array.type));
      file.read_bytes(array, bytes);
      return bytes;
    };
  }
  return true;
}

}  // namespace

std::optional<NeutralVolume> stream_vti(const std::filesystem::path& path, const std::string& field, TakeField* take) {
  const ForeignFile source(path);
  const std::optional<VtkXmlStream> file = VtkXmlStream::open(source);
  if (!file || file->data_set().name != "ImageData" || file->data_set().children.size() != 1) return std::nullopt;
  const XmlElement& piece = file->data_set().children.front();
  const std::optional<PointGrid> grid = grid_of(file->data_set(), piece);
  if (!grid || piece.name != "Piece") return std::nullopt;
  // Refuse before multiplying with it.
  checked_volume_bytes(path, grid->point_count, formats::ElementType::F64);
  std::vector<GridArray> arrays;
  if (!add_arrays(arrays, *file, piece.child("PointData"), grid->point_count, false) ||
      !add_arrays(arrays, *file, piece.child("CellData"), grid->point_count, true))
    return std::nullopt;
  return take(path, *grid, std::move(arrays), field);
}

}  // namespace rhoray::preprocess
