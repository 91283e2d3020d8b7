#include "preprocess/import/mesh/structured_cells.h"

#include "formats/base/bytes.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

ForeignCells hexahedra_of_grid(const Index3& point_counts, std::uint64_t available_points,
                               const std::filesystem::path& path) {
  const auto [x, y, z] = std::array{point_counts[0], point_counts[1], point_counts[2]};
  const std::string size = concat(x, " x ", y, " x ", z, " points");
  if (x < 2 || y < 2 || z < 2)
    refuse_input(path, "grid", size, "at least 2 along each axis: one layer has no cells that fill space",
                 ErrorCode::unsupported);
  const auto nx = static_cast<std::uint64_t>(x), ny = static_cast<std::uint64_t>(y), nz = static_cast<std::uint64_t>(z);
  if (checked_product({nx, ny, nz}) != available_points)
    refuse_input(path, "grid", concat(available_points, " points"), size);

  const std::uint64_t count = (nx - 1) * (ny - 1) * (nz - 1);
  ForeignCells cells;
  cells.kinds.assign(count, static_cast<std::uint8_t>(CellKind::hexahedron));
  cells.offsets.resize(count + 1);
  for (std::uint64_t cell = 0; cell <= count; ++cell) cells.offsets[cell] = 8 * cell;
  cells.nodes.reserve(8 * count);
  for (std::uint64_t k = 0; k + 1 < nz; ++k)
    for (std::uint64_t j = 0; j + 1 < ny; ++j)
      for (std::uint64_t i = 0; i + 1 < nx; ++i)
        for (const std::uint64_t layer : {k, k + 1}) {
          const std::uint64_t corner = i + nx * (j + ny * layer);
          for (const std::uint64_t node : {corner, corner + 1, corner + nx + 1, corner + nx})
            cells.nodes.push_back(node);
        }
  return cells;
}

}  // namespace rhoray::preprocess
