#include "tools/validate/shots.h"

#include <atomic>

#include "formats/base/parallel.h"

namespace rhoray::tools::validate {

namespace {

Shots answered(const Tracer& tracer, std::vector<AimedRay> rays) {
  Shots shots{.rays = std::move(rays), .hits = {}, .findings = {}};
  std::vector<render::Ray> bare;
  for (const AimedRay& aimed : shots.rays) bare.push_back(aimed.ray);
  shots.hits.resize(bare.size());
  shots.findings.resize(bare.size());
  tracer(bare, shots.hits);
  return shots;
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  constexpr std::string_view names[] = {"right", "missed", "false", "elsewhere", "grazes", "undecided"};
  return names[static_cast<std::size_t>(verdict)];
}

Rounds shoot(const Tracer& tracer, RoundsToShoot rounds, const Thousandths& progress) {
  std::vector<AimedRay> camera;
  for (const render::Ray& ray : rounds.camera) camera.push_back({ray, Aim::camera});
  Rounds shot{.far = answered(tracer, std::move(rounds.far)),
              .near = answered(tracer, std::move(rounds.near)),
              .camera = answered(tracer, std::move(camera))};
  const std::size_t total = shot.far.rays.size() + shot.near.rays.size() + shot.camera.rays.size();
  std::atomic<std::size_t> done = 0;
  for (Shots* shots : {&shot.far, &shot.near, &shot.camera})
    parallel_for(shots->rays.size(), 64, [&](const IndexRange& range) {
      for (std::size_t r = range.begin(); r != range.end(); ++r)
        shots->findings[r] = rounds.find(shots->rays[r].ray, shots->hits[r]);
      progress(300 + 700 * (done += range.size()) / total);
    });
  return shot;
}

}  // namespace rhoray::tools::validate
