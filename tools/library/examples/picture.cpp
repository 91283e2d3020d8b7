// A picture of an isosurface: picture FILE.rho ISOVALUE OUTPUT.png
#include <rhoray/rhoray.h>

#include <cstdio>
#include <cstdlib>

int main(int count, char** words) try {
  if (count != 4) return std::puts("usage: picture FILE.rho ISOVALUE OUTPUT.png"), 2;
  const rhoray::Dataset data = rhoray::Dataset::open(words[1]);
  rhoray::Scene scene{.layers = {{.data = data, .show = rhoray::Isosurface{std::atof(words[2])}}}};
  scene.camera = rhoray::fit_camera(scene, {960, 720});
  rhoray::Picture picture;
  rhoray::RenderContext().render(scene, {.size = {960, 720}}, picture);
  picture.save_png(words[3], true);
} catch (const rhoray::Error& error) {
  std::fprintf(stderr, "picture: %s\n", error.what());
  return static_cast<int>(error.code());
}
