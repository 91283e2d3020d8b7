#include "preprocess/import/vtk/structured_pieces.h"

#include <algorithm>
#include <set>

#include "formats/base/bytes.h"

namespace rhoray::preprocess {

StructuredPieces::StructuredPieces(const VtkXmlStream& file)
    : file_(file), whole_(extent_of(file, file.data_set(), "WholeExtent")) {
  file.check_attribute("WholeExtent", static_cast<std::uint64_t>(volume(point_count())));
  add_pieces(file);
  check_cover();
}

StructuredPieces::StructuredPieces(const VtkXmlStream& whole, const std::vector<const VtkXmlStream*>& files)
    : file_(whole), whole_(extent_of(whole, whole.data_set(), "WholeExtent")) {
  for (const VtkXmlStream* file : files) add_pieces(*file);
  check_cover();
}

void StructuredPieces::add_pieces(const VtkXmlStream& file) {
  for (const XmlElement& element : file.data_set().children) {
    if (element.name != "Piece") continue;
    pieces_.push_back({&file, &element, extent_of(file, element, "Extent")});
    file.check_attribute("Extent", static_cast<std::uint64_t>(volume(owner_count(pieces_.back().extent, false))));
  }
}

GridExtent StructuredPieces::extent_of(const VtkXmlStream& file, const XmlElement& element, std::string_view name) {
  const auto refuse = [&](std::string_view expected) {
    file.refuse_attribute(name, in_quotes(element.attribute(name)), expected);
  };
  const auto numbers = numbers_in<std::int32_t, 6>(element.attribute(name));
  if (!numbers) refuse("six numbers");
  GridExtent extent;
  for (int axis = 0; axis < 3; ++axis) {
    extent.first[axis] = (*numbers)[static_cast<std::size_t>(2 * axis)];
    extent.last[axis] = (*numbers)[static_cast<std::size_t>(2 * axis + 1)];
    if (extent.last[axis] < extent.first[axis]) refuse("first <= last on each axis");
  }
  const Index3 size = owner_count(extent, false);
  const std::optional<std::uint64_t> points = checked_product(
      {static_cast<std::uint64_t>(size.x), static_cast<std::uint64_t>(size.y), static_cast<std::uint64_t>(size.z)});
  if (!points || *points > std::uint64_t{1} << 62) refuse("a size that fits in memory");
  return extent;
}

void StructuredPieces::check_cover() const {
  std::vector<GridExtent> parts;
  for (const Piece& piece : pieces_) parts.push_back(piece.extent);
  if (!cover_once(whole_, parts))
    file_.refuse_attribute("Extent", concat(pieces_.size(), " pieces that do not make up WholeExtent"),
                           "pieces that cover it once");
}

std::vector<StructuredPieces::Parts> StructuredPieces::arrays(std::string_view section,
                                                              std::vector<std::string>* left_out) const {
  std::vector<Parts> result;
  for (const Piece& piece : pieces_) {
    const bool is_first = &piece == &pieces_.front();
    const auto found = piece.file->arrays_in(piece.element->child(section), is_first ? left_out : nullptr);
    if (is_first) result.resize(found.size());
    // VTK names coordinates without a name anew in each file.
    const bool has_names = section.ends_with("Data");
    const auto is_same = [&](const Parts& parts, const VtkXmlArray& array) {
      return parts.empty() || ((!has_names || parts.front().name == array.name) && parts.front().type == array.type &&
                               parts.front().component_count == array.component_count);
    };
    if (!std::equal(result.begin(), result.end(), found.begin(), found.end(), is_same))
      piece.file->refuse(concat("element ", section), "other arrays than in the first piece", "the same in each piece");
    for (std::size_t i = 0; i < found.size(); ++i) result[i].push_back(found[i]);
  }
  return result;
}

std::uint64_t StructuredPieces::checked_count(const Parts& parts, bool in_cells) const {
  for (std::size_t p = 0; p < parts.size(); ++p)
    pieces_[p].file->checked_count(parts[p],
                                   static_cast<std::uint64_t>(volume(owner_count(pieces_[p].extent, in_cells))));
  return static_cast<std::uint64_t>(volume(owner_count(whole_, in_cells))) *
         static_cast<std::uint64_t>(parts.front().component_count);
}

template <class T>
void StructuredPieces::read(const Parts& parts, bool in_cells, std::span<T> to) const {
  if (parts.size() == 1) return pieces_.front().file->read(parts.front(), to);
  const Index3 whole = owner_count(whole_, in_cells);
  const std::int64_t width = std::ssize(to) / volume(whole);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    Array<T> part(static_cast<std::size_t>(volume(owner_count(pieces_[p].extent, in_cells)) * width));
    pieces_[p].file->read(parts[p], std::span<T>(part));
    copy_to_whole<T>(part, pieces_[p].extent, whole_, in_cells, width, to);
  }
}
template void StructuredPieces::read(const Parts&, bool, std::span<double>) const;
template void StructuredPieces::read(const Parts&, bool, std::span<std::byte>) const;

void StructuredPieces::add_notes(std::vector<std::string>& notes) const {
  std::set<const VtkXmlStream*> files;
  for (const Piece& piece : pieces_)
    if (files.insert(piece.file).second)
      notes.insert(notes.end(), piece.file->notes().begin(), piece.file->notes().end());
}

std::vector<double> StructuredPieces::coordinates(const Parts& parts, int axis) const {
  std::vector<double> positions;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const GridExtent& extent = pieces_[p].extent;
    const auto count = static_cast<std::uint64_t>(extent.last[axis] - extent.first[axis] + 1);
    if (pieces_[p].file->checked_count(parts[p], count) != count)
      file_.refuse("element Coordinates", concat(parts[p].component_count, " numbers for each position"), "1");
    const auto first = static_cast<std::size_t>(extent.first[axis] - whole_.first[axis]);
    positions.resize(std::max(positions.size(), first + count));
    pieces_[p].file->read(parts[p], std::span(positions).subspan(first, count));
  }
  return positions;
}

}  // namespace rhoray::preprocess
