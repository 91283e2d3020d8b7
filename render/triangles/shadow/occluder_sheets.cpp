#include "render/triangles/shadow/occluder_sheets.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>
#include <utility>

#include "formats/base/stopping.h"
#include "render/query/compiled_for.h"

namespace rhoray::render::wide {

namespace {

constexpr float nowhere = std::numeric_limits<float>::infinity();

RHORAY_INLINE std::size_t row_of(const Squares& squares, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(squares.count[0]);
}

/// Heights of a square, both stored so that larger means higher or deeper; -infinity where there
/// are none.
struct Heights {
  float highest;      ///< of the facets that touch it
  float depth_below;  ///< minus the lowest height of those that are parts of sheets
};

/// What is known of a square, as bits.
enum : std::uint8_t {
  holds_middle = 1,  ///< of a sheet facet that is certainly seen from the right side
  is_doubted = 2,    ///< touches a sheet facet for which that is not certain
  has_rim = 4
};

/// Returns one bit for each facet of a block.
RHORAY_INLINE unsigned facets_in(std::size_t block, std::size_t count) {
  const std::size_t left = count - block * SeenBlock::size;
  return left < SeenBlock::size ? (1U << left) - 1 : 0xffffU;
}

/// The squares that the facets of a block touch, and those that contain their middles. Facets
/// outside all squares are assigned to the nearest one, where rims in between are recorded as well.
struct TouchedSquares {
  std::int32_t from[2][SeenBlock::size], to[2][SeenBlock::size], middle[2][SeenBlock::size];

  RHORAY_INLINE TouchedSquares(const Squares& squares, double margin, const SeenBlock& block) {
    for (std::size_t a = 0; a < 2; ++a) {
      const float begin = static_cast<float>(squares.first[a]), per_length = static_cast<float>(squares.per_length);
      const float last = static_cast<float>(squares.count[a] - 1), wider = static_cast<float>(margin);
      for (std::size_t i = 0; i < SeenBlock::size; ++i) {
        const float low = (block.low[a][i] - wider - begin) * per_length,
                    high = (block.high[a][i] + wider - begin) * per_length,
                    at = (block.middle[a][i] - begin) * per_length;
        // A NaN becomes 0.
        const float low_within = low > 0 ? low : 0, high_within = high > 0 ? high : 0, at_within = at > 0 ? at : 0;
        from[a][i] = static_cast<std::int32_t>(low_within < last ? low_within : last);
        to[a][i] = static_cast<std::int32_t>(high_within < last ? high_within : last);
        middle[a][i] = static_cast<std::int32_t>(at_within < last ? at_within : last);
      }
    }
  }
};

/// Records in which squares facets are.
/// @param sure  as SheetFacets::sure; null: no facet is part of a sheet
RHORAY_INLINE void find_heights(const Squares& squares, double margin, const FrontFacing& facets,
                                const std::uint16_t* sure, Heights* heights) {
  for (std::size_t b = 0; b * SeenBlock::size < facets.count(); ++b) {
    const SeenBlock& block = facets.blocks()[b];
    const TouchedSquares touched(squares, margin, block);
    const unsigned parts = sure != nullptr ? sure[b] & block.is_number : 0;
    for (unsigned bits = facets_in(b, facets.count()); bits != 0; bits &= bits - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(bits));
      const float highest = block.highest[i], depth_below = (parts >> i & 1) != 0 ? -block.lowest[i] : -nowhere;
      for (int y = touched.from[1][i]; y <= touched.to[1][i]; ++y) {
        Heights* row = heights + row_of(squares, y);
        for (int x = touched.from[0][i]; x <= touched.to[0][i]; ++x) {
          row[x].highest = highest > row[x].highest ? highest : row[x].highest;
          row[x].depth_below = depth_below > row[x].depth_below ? depth_below : row[x].depth_below;
        }
      }
    }
  }
}

/// Records which facets form sheets, and where they are certainly seen from the right side.
/// @param known    per square
/// @param is_part  per facet of the surface: whether it is part of a sheet
RHORAY_INLINE void find_parts(const Squares& squares, double margin, const SheetFacets& facets,
                              const FacetNeighbours::Turn* turns, bool is_up_unless_turned, std::uint8_t* known,
                              std::uint8_t* is_part) {
  for (std::size_t b = 0; b * SeenBlock::size < facets.seen.count(); ++b) {
    const SeenBlock& block = facets.seen.blocks()[b];
    const TouchedSquares touched(squares, margin, block);
    for (unsigned bits = facets.sure[b] & block.is_number & facets_in(b, facets.seen.count()); bits != 0;
         bits &= bits - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(bits));
      const std::uint32_t source = facets.sources[b * SeenBlock::size + i];
      is_part[source] = 1;
      const bool is_up = is_up_unless_turned != (turns[source] == FacetNeighbours::Turn::clockwise);
      if (((is_up ? block.is_up : block.is_down) >> i & 1) != 0) {
        std::uint8_t& of =
            known[row_of(squares, touched.middle[1][i]) + static_cast<std::size_t>(touched.middle[0][i])];
        of = static_cast<std::uint8_t>(of | holds_middle);
        continue;
      }
      for (int y = touched.from[1][i]; y <= touched.to[1][i]; ++y) {
        std::uint8_t* row = known + row_of(squares, y);
        for (int x = touched.from[0][i]; x <= touched.to[0][i]; ++x)
          row[x] = static_cast<std::uint8_t>(row[x] | is_doubted);
      }
    }
  }
}

/// Marks the squares that touch an edge at which a sheet ends.
void note_rim(const Squares& squares, double margin, const FrontFacing& facets, std::size_t facet, std::size_t c,
              std::uint8_t* known) {
  const FrontFacing::Place begin = facets.place(facet, c), end = facets.place(facet, (c + 1) % 4);
  int from[2], to[2];
  for (std::size_t a = 0; a < 2; ++a) {
    const auto square = [&](double at) {
      return static_cast<int>(std::clamp((at - squares.first[a]) * squares.per_length, 0.0, squares.count[a] - 1.0));
    };
    from[a] = square(static_cast<double>(std::min(begin[a], end[a])) - margin);
    to[a] = square(static_cast<double>(std::max(begin[a], end[a])) + margin);
  }
  for (int y = from[1]; y <= to[1]; ++y) {
    std::uint8_t* row = known + row_of(squares, y);
    for (int x = from[0]; x <= to[0]; ++x) row[x] = static_cast<std::uint8_t>(row[x] | has_rim);
  }
}

void note_rims(const Squares& squares, double margin, const SheetFacets& facets, const FacetNeighbours& neighbours,
               const std::uint8_t* is_part, std::uint8_t* known) {
  const FrontFacing& seen = facets.seen;
  for (std::size_t b = 0; b * SeenBlock::size < seen.count(); ++b)
    for (unsigned bits = facets.sure[b] & seen.blocks()[b].is_number & facets_in(b, seen.count()); bits != 0;
         bits &= bits - 1) {
      const std::size_t f = b * SeenBlock::size + static_cast<std::size_t>(std::countr_zero(bits));
      const std::array<FacetNeighbours::Beyond, 4>& beyond = neighbours.of(facets.sources[f]);
      unsigned inner = 0;
      for (std::size_t c = 0; c < 4; ++c)
        inner |= (is_part[FacetNeighbours::place_of(beyond[c])] & FacetNeighbours::is_alike(beyond[c])) << c;
      for (unsigned rims = inner ^ 15; rims != 0; rims &= rims - 1)
        note_rim(squares, margin, seen, f, static_cast<std::size_t>(std::countr_zero(rims)), known);
    }
}

/// Separates the heights. Coverage spreads from squares that sheets certainly cover to adjacent
/// squares without rims: up or down a column as far as there are any, and by one from row to row
/// along these.
/// @param known  per square; on return holds_middle below a sheet, and has_rim as before
/// @param row    room for a row, and one square on either side of it
RHORAY_INLINE void finish(const Squares& squares, const Heights* heights, std::uint8_t* known, std::uint8_t* row,
                          float* above, float* below) {
  const std::size_t width = static_cast<std::size_t>(squares.count[0]),
                    rows = static_cast<std::size_t>(squares.count[1]), count = width * rows;
  row[0] = row[width + 1] = 0;
  for (std::size_t s = 0; s < count; ++s)
    known[s] = (known[s] & has_rim) != 0 ? std::uint8_t{has_rim} : known[s] == holds_middle;
  for (const bool down : {false, true})
    for (std::size_t r = 0; r < rows; ++r) {
      std::uint8_t* here = known + (down ? rows - 1 - r : r) * width;
      const std::uint8_t* before = r == 0 ? here : down ? here + width : here - width;
      for (std::size_t x = 0; x < width; ++x)
        row[x + 1] = here[x] == has_rim ? std::uint8_t{0} : static_cast<std::uint8_t>((here[x] | before[x]) & 1);
      for (std::size_t x = 0; x < width; ++x)
        here[x] =
            here[x] == has_rim ? std::uint8_t{has_rim} : static_cast<std::uint8_t>(row[x] | row[x + 1] | row[x + 2]);
    }
  for (std::size_t s = 0; s < count; ++s) {
    above[s] = heights[s].highest;
    // No depth: no sheet.
    const float lowest = -heights[s].depth_below;
    below[s] = ((known[s] == holds_middle) & (lowest < nowhere)) ? lowest : -nowhere;
  }
}

}  // namespace

std::vector<float> heights_of_facets(Machine machine, const Squares& squares, double margin,
                                     const FrontFacing& facets) {
  if (facets.count() == 0) return {};
  std::vector<Heights> heights(squares.size(), {-nowhere, -nowhere});
  compiled_for<find_heights>(machine)(squares, margin, facets, nullptr, heights.data());
  std::vector<float> above(squares.size() + 1, -nowhere);
  for (std::size_t s = 0; s < heights.size(); ++s) above[s] = heights[s].highest;
  return above;
}

FacetHeights heights_of_sheets(Machine machine, const Squares& squares, double margin, const SheetFacets& facets,
                               const FacetNeighbours& neighbours, const std::stop_token& stop) {
  if (facets.seen.count() == 0) return {};
  const std::size_t count = squares.size();
  std::vector<Heights> heights(count, {-nowhere, -nowhere});
  compiled_for<find_heights>(machine)(squares, margin, facets.seen, facets.sure, heights.data());
  end_if_stopped(stop);
  std::vector<std::uint8_t> known(count, 0), row(static_cast<std::size_t>(squares.count[0]) + 2);
  std::vector<std::uint8_t> is_part(neighbours.place_count(), 0);
  is_part[FacetNeighbours::place_of(neighbours.no_edge())] = 1;
  const bool is_up_unless_turned = facets.rises == (facets.seen.from_light().sign() > 0);
  compiled_for<find_parts>(machine)(squares, margin, facets, neighbours.turns(), is_up_unless_turned, known.data(),
                                    is_part.data());
  end_if_stopped(stop);
  note_rims(squares, margin, facets, neighbours, is_part.data(), known.data());
  FacetHeights found{std::vector<float>(count + 1, -nowhere), std::vector<float>(count + 1, -nowhere)};
  compiled_for<finish>(machine)(squares, heights.data(), known.data(), row.data(), found.above.data(),
                                found.below.data());
  return found;
}

}  // namespace rhoray::render::wide
