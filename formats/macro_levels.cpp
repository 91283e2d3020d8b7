#include "formats/macro_levels.h"

#include "formats/base/checks.h"
#include "formats/base/text.h"

namespace rhoray::formats {
namespace {

std::vector<std::uint64_t> level_shape(const MacroShape& shape, int level) {
  const Index3 count = shape.count(level);
  return {static_cast<std::uint64_t>(count.z), static_cast<std::uint64_t>(count.y), static_cast<std::uint64_t>(count.x),
          2};
}

}  // namespace

Index3 MacroShape::count(int level) const {
  RHORAY_DCHECK(level >= 0 && level <= level_count);
  // Rounding up level by level gives the same result as rounding up once, and cannot overflow.
  Index3 cells = leaf_count;
  for (int l = 0; l < level; ++l)
    cells = {(cells.x - 1) / factor + 1, (cells.y - 1) / factor + 1, (cells.z - 1) / factor + 1};
  return cells;
}

std::int64_t MacroShape::cell_edge(int level) const {
  std::int64_t edge = 1;
  for (int l = 0; l < level; ++l) edge *= factor;
  return edge;
}

std::vector<ArraySpec> macro_arrays(const MacroShape& shape, int first_level, ElementType type,
                                    const std::string& prefix) {
  std::vector<ArraySpec> arrays;
  for (int level = first_level; level <= shape.level_count; ++level)
    arrays.push_back({.name = concat(prefix, level), .type = type, .shape = level_shape(shape, level)});
  return arrays;
}

template <class T>
MacroLevelsView<T> view_macro_levels(const PackedFile& file, const MacroShape& shape, int first_level,
                                     const std::string& prefix) {
  MacroLevelsView<T> view{.shape = shape, .first_level = first_level, .ranges = {}};
  for (int level = first_level; level <= shape.level_count; ++level)
    view.ranges.push_back(file.array<T>(concat(prefix, level), level_shape(shape, level)));
  return view;
}

template MacroLevelsView<std::uint8_t> view_macro_levels(const PackedFile&, const MacroShape&, int, const std::string&);
template MacroLevelsView<std::int8_t> view_macro_levels(const PackedFile&, const MacroShape&, int, const std::string&);
template MacroLevelsView<std::uint16_t> view_macro_levels(const PackedFile&, const MacroShape&, int,
                                                          const std::string&);
template MacroLevelsView<std::int16_t> view_macro_levels(const PackedFile&, const MacroShape&, int, const std::string&);
template MacroLevelsView<std::uint32_t> view_macro_levels(const PackedFile&, const MacroShape&, int,
                                                          const std::string&);
template MacroLevelsView<std::int32_t> view_macro_levels(const PackedFile&, const MacroShape&, int, const std::string&);
template MacroLevelsView<std::uint64_t> view_macro_levels(const PackedFile&, const MacroShape&, int,
                                                          const std::string&);
template MacroLevelsView<std::int64_t> view_macro_levels(const PackedFile&, const MacroShape&, int, const std::string&);
template MacroLevelsView<float> view_macro_levels(const PackedFile&, const MacroShape&, int, const std::string&);
template MacroLevelsView<double> view_macro_levels(const PackedFile&, const MacroShape&, int, const std::string&);

}  // namespace rhoray::formats
