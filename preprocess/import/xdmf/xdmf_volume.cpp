// Volumes in XDMF files (.xdmf, .xmf): rectilinear grids, and blocks of a spatial collection that
// together make one.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "formats/base/bytes.h"
#include "preprocess/import/reading/families.h"
#include "preprocess/import/reading/grid_arrays.h"
#include "preprocess/import/reading/grid_cover.h"
#include "preprocess/import/reading/samples.h"
#include "preprocess/import/reading/text_reading.h"
#include "preprocess/import/xdmf/topology_cells.h"
#include "preprocess/import/xdmf/xdmf_grids.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;
using Positions = std::vector<double>;

bool is_rectilinear(std::string_view topology) {
  return topology == "3drectmesh" || topology == "3dcorectmesh";
}

/// A grid of points along three axes.
struct Block {
  Index3 point_count;
  Vec3 origin{0, 0, 0}, step{1, 1, 1};   ///< either these
  std::array<Positions, 3> positions{};  ///< or tables
  bool has_tables = false;
  double precision = 0x1p-52;  ///< of one position, relative
};

/// Three numbers of a geometry, in the order z, y, x.
Vec3 three_of(XdmfData& data, const XmlElement& item) {
  const XdmfNumbers numbers = data.open(item);
  if (numbers.count() != 3) numbers.refuse(concat(numbers.count(), " numbers"), "3: z, y, x");
  const Array<double> read = numbers.read<double>();
  return {read[2], read[1], read[0]};
}

Block block_of(const XdmfDocument& document, XdmfData& data, const XdmfGrid& grid) {
  const std::string word = topology_word(*grid.topology);
  if (!is_rectilinear(word))
    document.refuse(*grid.topology, concat("the type ", in_quotes(word)), "3DRectMesh or 3DCoRectMesh",
                    ErrorCode::unsupported);
  Block block{.point_count = point_counts_of(document, *grid.topology)};
  const std::string type = XdmfDocument::word(*grid.geometry, {"GeometryType", "Type"});
  const auto items = document.children(*grid.geometry, "DataItem");
  if (type == "origin_dxdydz" && items.size() == 2) {
    block.origin = three_of(data, *items[0]);
    block.step = three_of(data, *items[1]);
    return block;
  }
  if (type != "vxvyvz" || items.size() != 3)
    document.refuse(*grid.geometry, concat(in_quotes(type), " with ", items.size(), " elements DataItem"),
                    "VXVYVZ with 3, or ORIGIN_DXDYDZ with 2", ErrorCode::unsupported);
  block.has_tables = true;
  Index3 found;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const XdmfNumbers numbers = data.open(*items[axis]);
    const Array<double> read = numbers.read<double>();
    block.positions[axis].assign(read.begin(), read.end());
    found[static_cast<int>(axis)] = static_cast<std::int64_t>(read.size());
    if (formats::element_bytes(numbers.type()) < 8) block.precision = 0x1p-23;
  }
  // XDMF 3's library writes these sizes in the order x, y, z.
  if (found != block.point_count && found != Index3(block.point_count.z, block.point_count.y, block.point_count.x))
    document.refuse(*grid.geometry, concat(found.z, " x ", found.y, " x ", found.x, " positions"),
                    "as many as the Topology has points along z, y, x");
  block.point_count = found;
  return block;
}

/// All blocks together, and the place of each in the whole.
struct JoinedGrid {
  PointGrid points;
  GridExtent whole;
  std::vector<GridExtent> parts;
};

Positions positions_along(const Block& block, std::size_t axis) {
  if (block.has_tables) return block.positions[axis];
  const auto a = static_cast<int>(axis);
  Positions positions;
  for (std::int64_t i = 0; i < block.point_count[a]; ++i)
    positions.push_back(block.origin[a] + static_cast<double>(i) * block.step[a]);
  return positions;
}

/// Places each block along one axis, and returns the positions of the whole. Positions that differ
/// by less than a hundredth of the smallest step are the same: blocks round theirs apart.
Positions join_axis(const XdmfDocument& document, const std::vector<Block>& blocks, std::size_t axis,
                    std::vector<GridExtent>& parts) {
  std::vector<Positions> own;
  Positions all;
  double smallest = std::numeric_limits<double>::infinity();
  for (const Block& block : blocks) {
    own.push_back(positions_along(block, axis));
    const Positions& one = own.back();
    for (std::size_t i = 1; i < one.size(); ++i) smallest = std::min(smallest, one[i] - one[i - 1]);
    all.insert(all.end(), one.begin(), one.end());
  }
  const auto refuse = [&](std::string_view found) {
    refuse_input(document.path(), concat("blocks along ", "xyz"[axis]), found, "blocks that make one grid",
                 ErrorCode::unsupported);
  };
  if (!(smallest > 0) || !std::all_of(all.begin(), all.end(), [](double p) { return std::isfinite(p); }))
    refuse("positions that do not rise");
  std::sort(all.begin(), all.end());
  const double same = std::isfinite(smallest) ? smallest / 100 : 0;
  Positions whole;
  for (const double position : all)
    if (whole.empty() || position - whole.back() > same) whole.push_back(position);
  const auto index = static_cast<int>(axis);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const auto first = std::lower_bound(whole.begin(), whole.end(), own[b].front() - same) - whole.begin();
    const bool fits = std::ssize(whole) - first >= std::ssize(own[b]) &&
                      std::equal(own[b].begin(), own[b].end(), whole.begin() + first,
                                 [&](double a, double p) { return std::abs(a - p) <= same; });
    if (!fits) refuse("blocks of different resolution");
    parts[b].first[index] = first;
    parts[b].last[index] = first + std::ssize(own[b]) - 1;
  }
  return whole;
}

JoinedGrid join(const XdmfDocument& document, const std::vector<Block>& blocks) {
  JoinedGrid joined;
  joined.parts.resize(blocks.size());
  double precision = 0;
  for (const Block& block : blocks) precision = std::max(precision, block.precision);
  if (blocks.size() == 1) {
    const Block& block = blocks.front();
    joined.points = block.has_tables ? rectilinear_grid(document.path(), block.positions, precision)
                                     : PointGrid{block.point_count, axis_parallel(block.step, block.origin)};
    for (int axis = 0; axis < 3; ++axis) joined.parts[0].last[axis] = block.point_count[axis] - 1;
    joined.whole = joined.parts[0];
    return joined;
  }
  std::array<Positions, 3> positions;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    positions[axis] = join_axis(document, blocks, axis, joined.parts);
    joined.whole.last[static_cast<int>(axis)] = std::ssize(positions[axis]) - 1;
  }
  if (!cover_once(joined.whole, joined.parts))
    refuse_input(document.path(), "blocks", concat(blocks.size(), " that leave a gap or overlap"),
                 "blocks that cover one grid once", ErrorCode::unsupported);
  // Blocks with even steps may round their origins to six digits: the whole has even steps, too.
  const bool are_even = std::none_of(blocks.begin(), blocks.end(), [](const Block& block) { return block.has_tables; });
  joined.points = rectilinear_grid(document.path(), positions, are_even ? 0x1p-20 : precision);
  return joined;
}

/// The attributes of one name in all blocks.
using Parts = std::vector<XdmfAttribute>;

std::vector<Parts> attributes_of_blocks(const XdmfDocument& document, XdmfData& data,
                                        const std::vector<XdmfGrid>& grids, std::vector<std::string>& notes) {
  std::vector<Parts> all;
  for (const XdmfGrid& grid : grids) {
    std::vector<std::string> ignored;
    const bool is_first = &grid == &grids.front();
    std::vector<XdmfAttribute> found = attributes_of(document, data, grid, is_first ? notes : ignored);
    if (is_first) all.resize(found.size());
    const bool is_same = std::equal(
        all.begin(), all.end(), found.begin(), found.end(), [&](const Parts& parts, const XdmfAttribute& attribute) {
          return parts.empty() ||
                 (parts.front().name == attribute.name && parts.front().in_cells == attribute.in_cells &&
                  parts.front().numbers.type() == attribute.numbers.type() &&
                  parts.front().is_symmetric_tensor == attribute.is_symmetric_tensor);
        });
    if (!is_same) document.refuse(*grid.element, "other attributes than in the first block", "the same in each block");
    for (std::size_t i = 0; i < found.size(); ++i) all[i].push_back(std::move(found[i]));
  }
  return all;
}

std::uint64_t owners_in(const GridExtent& extent, bool in_cells) {
  return static_cast<std::uint64_t>(volume(owner_count(extent, in_cells)));
}

/// Numbers for each point or cell, the same in all blocks. Refuses blocks larger than their data.
int component_count_in(const std::vector<Block>& blocks, const Parts& parts) {
  int count = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const GridExtent extent{{0, 0, 0}, blocks[p].point_count - Index3(1, 1, 1)};
    const int found = parts[p].component_count(owners_in(extent, parts[p].in_cells));
    if (p > 0 && found != count)
      parts[p].numbers.refuse(concat(found, " numbers for each"), concat(count, ", as in the first block"));
    count = found;
  }
  return count;
}

Array<std::byte> load(const JoinedGrid& grid, const Parts& parts, int component_count) {
  const XdmfAttribute& first = parts.front();
  Samples samples{first.numbers.type(), component_count, {}};
  if (parts.size() == 1) {
    samples.values = first.numbers.read<std::byte>();
  } else {
    const auto width =
        static_cast<std::int64_t>(component_count) * static_cast<std::int64_t>(formats::element_bytes(samples.type));
    samples.values.resize(owners_in(grid.whole, first.in_cells) * static_cast<std::uint64_t>(width));
    for (std::size_t p = 0; p < parts.size(); ++p)
      copy_to_whole<std::byte>(parts[p].numbers.read<std::byte>(), grid.parts[p], grid.whole, first.in_cells, width,
                               samples.values);
  }
  if (first.is_symmetric_tensor) pick(samples, from_upper_rows);
  return std::move(samples.values);
}

}  // namespace

NeutralVolume read_xdmf_volume(const std::filesystem::path& path, const std::string& field, const std::string& time) {
  const XdmfDocument document(path);
  XdmfData data(document);
  XdmfGrids chosen =
      select_grids(document, data, {.time = time, .first_by_default = true, .is_wanted = is_rectilinear});
  std::vector<Block> blocks;
  for (const XdmfGrid& grid : chosen.grids) blocks.push_back(block_of(document, data, grid));
  const std::vector<Parts> attributes = attributes_of_blocks(document, data, chosen.grids, chosen.notes);
  if (attributes.empty())
    document.refuse(*chosen.grids.front().element, "no Attribute", "values at points or in cells");
  JoinedGrid grid;
  std::vector<GridArray> arrays;
  for (const Parts& parts : attributes) {
    const int components = component_count_in(blocks, parts);
    arrays.push_back({.name = parts.front().name,
                      .type = parts.front().numbers.type(),
                      .component_count = components,
                      .in_cells = parts.front().in_cells,
                      .values = {},
                      .load = [&grid, &parts, components] { return load(grid, parts, components); }});
  }
  grid = join(document, blocks);
  NeutralVolume volume = volume_of_field(path, grid.points, std::move(arrays), field);
  volume.notes.insert(volume.notes.begin(), chosen.notes.begin(), chosen.notes.end());
  return volume;
}

}  // namespace rhoray::preprocess
