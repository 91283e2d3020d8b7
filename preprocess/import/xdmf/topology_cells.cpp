// Source of names, numbers and counts: XDMF Model and Format, xdmf.org, "Topology". VTK's readers
// take the nodes of every kind as they stand: the order is VTK's. Numbers of nodes also follow the
// kinds 1 to 3 in Mixed topologies, as VTK and meshio write them.

#include "preprocess/import/xdmf/topology_cells.h"

#include <algorithm>
#include <array>
#include <utility>

#include "formats/base/bytes.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/xdmf/xdmf_grids.h"

namespace rhoray::preprocess {
namespace {

/// A kind of cells: its names in lower case, its number in Mixed topologies, VTK's number.
struct TopologyKind {
  std::array<std::string_view, 2> words;
  std::int64_t number;
  std::uint8_t kind;
  std::uint64_t node_count;  ///< 0: varies
  bool fills_space;
};
constexpr TopologyKind topology_kinds[] = {
    {{"polyvertex", ""}, 1, 2, 0, false},
    {{"polyline", ""}, 2, 4, 0, false},
    {{"polygon", ""}, 3, 7, 0, false},
    {{"triangle", ""}, 4, 5, 3, false},
    {{"quadrilateral", ""}, 5, 9, 4, false},
    {{"tetrahedron", ""}, 6, 10, 4, true},
    {{"pyramid", ""}, 7, 14, 5, true},
    {{"wedge", ""}, 8, 13, 6, true},
    {{"hexahedron", ""}, 9, 12, 8, true},
    {{"edge_3", ""}, 34, 21, 3, false},
    {{"quadrilateral_9", "quad_9"}, 35, 28, 9, false},
    {{"triangle_6", "tri_6"}, 36, 22, 6, false},
    {{"quadrilateral_8", "quad_8"}, 37, 23, 8, false},
    {{"tetrahedron_10", "tet_10"}, 38, 24, 10, true},
    {{"pyramid_13", ""}, 39, 27, 13, true},
    {{"wedge_15", ""}, 40, 26, 15, true},
    {{"wedge_18", ""}, 41, 32, 18, true},
    {{"hexahedron_20", "hex_20"}, 48, 25, 20, true},
    {{"hexahedron_24", "hex_24"}, 49, 33, 24, true},
    {{"hexahedron_27", "hex_27"}, 50, 29, 27, true},
};
constexpr std::int64_t polyhedron_number = 16;

const TopologyKind* kind_named(std::string_view word) {
  const auto* found = std::find_if(std::begin(topology_kinds), std::end(topology_kinds), [&](const TopologyKind& row) {
    return !word.empty() && (row.words[0] == word || row.words[1] == word);
  });
  return found == std::end(topology_kinds) ? nullptr : found;
}

const TopologyKind* kind_numbered(std::int64_t number) {
  const auto* found = std::find_if(std::begin(topology_kinds), std::end(topology_kinds),
                                   [&](const TopologyKind& row) { return row.number == number; });
  return found == std::end(topology_kinds) ? nullptr : found;
}

/// The declared number of cells.
std::optional<std::uint64_t> cell_count_in(const XdmfDocument& document, const XmlElement& topology) {
  for (const std::string_view attribute : {"NumberOfElements", "Dimensions"})
    if (const auto sizes = document.sizes(topology, attribute)) {
      std::uint64_t count = 1;
      for (const std::uint64_t size : *sizes) count *= size;
      return count;
    }
  return std::nullopt;
}

/// Returns the number that is subtracted from each node.
std::uint64_t base_of(const XdmfDocument& document, const XmlElement& topology) {
  const std::string_view text = topology.attribute("BaseOffset");
  const auto base = text.empty() ? std::optional<std::int64_t>(0) : parse_number<std::int64_t>(text);
  if (!base) document.refuse(topology, concat("BaseOffset ", in_quotes(text)), "a number");
  return static_cast<std::uint64_t>(*base);
}

/// Cells of one kind.
ForeignCells uniform_cells(const XdmfDocument& document, const XmlElement& topology, const TopologyKind& kind,
                           const XdmfNumbers& numbers) {
  const auto given = document.sizes(topology, "NodesPerElement");
  const std::uint64_t nodes = kind.node_count != 0 ? kind.node_count : given ? given->front() : 1;
  if (given && (given->size() != 1 || given->front() != nodes || nodes == 0))
    document.refuse(topology, concat("NodesPerElement ", in_quotes(topology.attribute("NodesPerElement"))),
                    concat(std::max<std::uint64_t>(nodes, 1)));
  const std::uint64_t count = cell_count_in(document, topology).value_or(numbers.count() / nodes);
  if (checked_product({count, nodes}) != numbers.count())
    numbers.refuse(concat(numbers.count(), " numbers"), concat(count, " cells of ", nodes, " nodes"));
  ForeignCells cells;
  cells.kinds.assign(count, kind.kind);
  cells.offsets.assign(count + 1, 0);
  if (!kind.fills_space) return cells;
  for (std::uint64_t cell = 0; cell <= count; ++cell) cells.offsets[cell] = cell * nodes;
  const Array<std::int64_t> read = numbers.read<std::int64_t>();
  const std::uint64_t base = base_of(document, topology);
  cells.nodes.reserve(read.size());
  // a negative node wraps to a huge number and is refused
  for (const std::int64_t node : read) cells.nodes.push_back(static_cast<std::uint64_t>(node) - base);
  return cells;
}

/// Cells of several kinds, each with its number before its nodes.
class MixedCells {
 public:
  MixedCells(const XdmfNumbers& numbers, std::uint64_t base)
      : numbers_(numbers), read_(numbers.read<std::int64_t>()), base_(base) {}

  ForeignCells take(std::optional<std::uint64_t> count) {
    cells_.offsets = {0};
    while (count ? cells_.kinds.size() < *count : at_ < read_.size()) take_cell();
    if (at_ < read_.size()) numbers_.refuse(concat(read_.size() - at_, " numbers behind the last cell"), "no more");
    return std::move(cells_);
  }

 private:
  std::int64_t next() {
    if (at_ == read_.size()) numbers_.refuse(concat("the end of the numbers in cell ", cells_.kinds.size()), "more");
    return read_[at_++];
  }

  /// A count of what follows.
  std::uint64_t next_count() {
    const std::int64_t count = next();
    if (count < 0 || static_cast<std::uint64_t>(count) > read_.size() - at_)
      numbers_.refuse(concat(count, " nodes or faces in cell ", cells_.kinds.size()), "as many as follow");
    return static_cast<std::uint64_t>(count);
  }

  void take_nodes(std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) cells_.nodes.push_back(static_cast<std::uint64_t>(next()) - base_);
  }

  void take_cell() {
    const std::int64_t number = next();
    if (number == polyhedron_number) {
      const std::uint64_t faces = next_count();
      cells_.nodes.push_back(faces);
      for (std::uint64_t face = 0; face < faces; ++face) {
        cells_.nodes.push_back(next_count());
        take_nodes(cells_.nodes.back());
      }
      cells_.kinds.push_back(static_cast<std::uint8_t>(CellKind::polyhedron));
    } else {
      const TopologyKind* kind = kind_numbered(number);
      if (kind == nullptr)
        numbers_.refuse(concat("the kind ", number, " in cell ", cells_.kinds.size()),
                        "1 to 9, 16, 34 to 41 or 48 to 50", ErrorCode::unsupported);
      take_nodes(kind->node_count != 0 ? kind->node_count : next_count());
      cells_.kinds.push_back(kind->kind);
    }
    cells_.offsets.push_back(cells_.nodes.size());
  }

  const XdmfNumbers& numbers_;
  Array<std::int64_t> read_;
  std::uint64_t base_;
  std::size_t at_ = 0;
  ForeignCells cells_;
};

/// Points without a list of nodes, which are cells of one node each.
ForeignCells points_alone(const XdmfDocument& document, const XmlElement& topology, std::uint64_t point_count) {
  const std::uint64_t count = cell_count_in(document, topology).value_or(point_count);
  if (count > point_count) document.refuse(topology, concat(count, " points"), concat(point_count));
  ForeignCells cells;
  cells.kinds.assign(count, kind_named("polyvertex")->kind);
  cells.offsets.assign(count + 1, 0);
  return cells;
}

}  // namespace

bool may_fill_space(std::string_view word) {
  const TopologyKind* kind = kind_named(word);
  return kind == nullptr ? word == "mixed" : kind->fills_space;
}

ForeignCells cells_of_topology(const XdmfDocument& document, XdmfData& data, const XmlElement& topology,
                               std::uint64_t point_count) {
  const std::string word = topology_word(topology);
  const TopologyKind* kind = kind_named(word);
  if (kind == nullptr && word != "mixed")
    document.refuse(topology, concat("cells of the type ", in_quotes(word)),
                    "Tetrahedron (also _10), Pyramid (_13), Wedge (_15, _18), Hexahedron (_20, _24, _27) or Mixed",
                    ErrorCode::unsupported);
  if (!topology.attribute("Order").empty())
    document.refuse(topology, "an Order of its own", "nodes in the order of XDMF", ErrorCode::unsupported);
  if (word == "polyvertex" && document.children(topology, "DataItem").empty())
    return points_alone(document, topology, point_count);
  const XdmfNumbers numbers = data.open_only(topology);
  if (kind != nullptr) return uniform_cells(document, topology, *kind, numbers);
  return MixedCells(numbers, base_of(document, topology)).take(cell_count_in(document, topology));
}

Index3 point_counts_of(const XdmfDocument& document, const XmlElement& topology) {
  auto sizes = document.sizes(topology, "Dimensions");
  if (!sizes) sizes = document.sizes(topology, "NumberOfElements");
  if (!sizes || sizes->size() != 3)
    document.refuse(topology, concat(sizes ? sizes->size() : 0, " sizes in Dimensions"), "3: z, y, x");
  Index3 counts;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t size = (*sizes)[static_cast<std::size_t>(2 - axis)];
    if (size < 1) document.refuse(topology, "a size of 0", "at least 1 along each axis");
    counts[axis] = static_cast<std::int64_t>(size);
  }
  return counts;
}

}  // namespace rhoray::preprocess
