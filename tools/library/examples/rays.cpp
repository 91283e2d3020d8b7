// Certified rays for another renderer, which has threads and rays of its own: rays FILE.rho
// ISOVALUE
#include <rhoray/rhoray.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <thread>
#include <vector>

namespace {

// The rays of one tile of that renderer, parallel to the z axis, as floats.
struct Tile {
  std::vector<float> origins, directions;
  std::vector<double> t, error;
};

Tile make_tile(const rhoray::Box3& box, int row, int rows) {
  Tile tile;
  constexpr int columns = 256;
  for (int column = 0; column < columns; ++column) {
    const double x = box.min.x + (column + 0.5) / columns * (box.max.x - box.min.x);
    const double y = box.min.y + (row + 0.5) / rows * (box.max.y - box.min.y);
    for (const double component : {x, y, box.max.z + 1}) tile.origins.push_back(static_cast<float>(component));
    for (const float component : {0.0F, 0.0F, -1.0F}) tile.directions.push_back(component);
  }
  tile.t.resize(columns), tile.error.resize(columns);
  return tile;
}

}  // namespace

int main(int count, char** words) try {
  if (count != 3) return std::puts("usage: rays FILE.rho ISOVALUE"), 2;
  const rhoray::Dataset data = rhoray::Dataset::open(words[1]);
  // One caster for all threads; one scratch for each thread.
  const rhoray::RayCaster surface(data, rhoray::Isosurface{std::atof(words[2])}, rhoray::Accuracy::certified);
  constexpr int rows = 64, threads = 2;
  std::vector<Tile> tiles;
  for (int row = 0; row < rows; ++row) tiles.push_back(make_tile(data.bounds(), row, rows));
  {
    std::vector<std::jthread> workers;
    for (int thread = 0; thread < threads; ++thread)
      workers.emplace_back([&, thread] {
        rhoray::RayScratch mine;
        for (std::size_t i = static_cast<std::size_t>(thread); i < tiles.size(); i += threads) {
          Tile& tile = tiles[i];
          const auto rays = static_cast<std::int64_t>(tile.t.size());
          surface.first_hits({.origins = {std::span<const float>(tile.origins), {rays, 3}},
                              .directions = {std::span<const float>(tile.directions), {rays, 3}}},
                             {.t = tile.t, .error = tile.error}, mine);
        }
      });
  }
  long hits = 0;
  double largest_error = 0;
  for (const Tile& tile : tiles)
    for (std::size_t ray = 0; ray < tile.t.size(); ++ray)
      if (std::isfinite(tile.t[ray])) ++hits, largest_error = std::fmax(largest_error, tile.error[ray]);
  std::printf("%ld hits; every t is proven to %.2g\n", hits, largest_error);
} catch (const rhoray::Error& error) {
  std::fprintf(stderr, "rays: %s\n", error.what());
  return static_cast<int>(error.code());
}
