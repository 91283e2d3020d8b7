// The isosurface of an array in memory, with proven errors: array OUTPUT.png
#include <rhoray/rhoray.h>

#include <cmath>
#include <cstdio>
#include <span>
#include <vector>

int main(int count, char** words) try {
  if (count != 2) return std::puts("usage: array OUTPUT.png"), 2;
  // values[k][j][i]: a gyroid in samples of 0.5 x 0.5 x 1 mm.
  constexpr int nx = 96, ny = 80, nz = 48;
  std::vector<float> values;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const double x = 0.15 * i, y = 0.15 * j, z = 0.3 * k;
        values.push_back(
            static_cast<float>(std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x)));
      }
  const rhoray::GridArrays grid{
      .fields = {{.name = "gyroid", .values = rhoray::ArrayView(std::span<const float>(values), {nz, ny, nx})}},
      .spacing = {0.5, 0.5, 1},
      .length_unit = "mm"};
  const rhoray::Dataset data = rhoray::pack(grid, rhoray::AxisOrder::zyx);
  rhoray::Scene scene{
      .layers = {{.data = data, .show = rhoray::Isosurface{0.3}, .method = rhoray::Accuracy::certified}}};
  scene.camera = rhoray::fit_camera(scene, {640, 480}, {.azimuth_deg = 40, .elevation_deg = 30});
  rhoray::Picture picture;
  const rhoray::RenderResult result =
      rhoray::RenderContext().render(scene, {.size = {640, 480}, .channels = {.depth = true, .error = true}}, picture);
  picture.save_png(words[1], true);
  const rhoray::SelfCheck check = rhoray::self_check(scene, picture, {.pixels = 200});
  std::printf("%llu pixels show the surface; every distance is proven to %.2g mm\n",
              static_cast<unsigned long long>(result.statistics.hits), result.statistics.largest_error);
  std::printf("exact arithmetic: %llu missed, %llu false of %llu pixels at edges\n",
              static_cast<unsigned long long>(check.edges.missed),
              static_cast<unsigned long long>(check.edges.false_hits),
              static_cast<unsigned long long>(check.edges.pixels));
  return check.broken.empty() ? 0 : 1;
} catch (const rhoray::Error& error) {
  std::fprintf(stderr, "array: %s\n", error.what());
  return static_cast<int>(error.code());
}
