// A view that is refined, cancelled by a newer request, and restarted: progressive FILE.rho LOWEST
// HIGHEST OUTPUT.png
#include <rhoray/rhoray.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

int main(int count, char** words) try {
  if (count != 5) return std::puts("usage: progressive FILE.rho LOWEST HIGHEST OUTPUT.png"), 2;
  const double lowest = std::atof(words[2]), highest = std::atof(words[3]);
  rhoray::Scene scene{.layers = {{.data = rhoray::Dataset::open(words[1]), .show = rhoray::Isosurface{lowest}}}};
  scene.camera = rhoray::fit_camera(scene, {800, 600});
  rhoray::RenderContext context;  // keeps threads and memory from request to request
  rhoray::Picture picture;
  // A user drags the isovalue: each request is shown at once, and the next one cancels its
  // refinement.
  constexpr int requests = 8;
  for (int request = 1; request <= requests; ++request) {
    scene.layers[0].show = rhoray::Isosurface{lowest + (highest - lowest) * request / requests};
    std::stop_source newer;
    std::jthread user([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(15));
      if (request < requests) newer.request_stop();
    });
    int finest = 0;
    const rhoray::Passes passes{.first_spacing = 8, .pass_done = [&](int spacing) {
                                  finest = spacing;  // here the picture would be sent
                                  return true;
                                }};
    const rhoray::RenderResult result = context.refine(scene, {.size = {800, 600}}, passes, picture, newer.get_token());
    std::printf("request %d: shown with every %d. pixel%s\n", request, finest, result.complete ? ", complete" : "");
    if (request == requests && !result.complete) return 1;
  }
  picture.save_png(words[4], true);
} catch (const rhoray::Error& error) {
  std::fprintf(stderr, "progressive: %s\n", error.what());
  return static_cast<int>(error.code());
}
