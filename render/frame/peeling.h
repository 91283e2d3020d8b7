#pragma once

#include <cstdint>
#include <span>

#include "render/frame/frame.h"

/// Clear surfaces crossing by crossing: a ray goes on behind each as a question of its own.
namespace rhoray::render {

/// Less of the light behind than this is not looked for.
inline constexpr float least_light = 1.0F / 1024;

/// The ray behind its crossing. Where two crossings were met at one t the next is looked for behind it, so that
/// surfaces folded into each other come to an end.
/// @param is_field  the crossing is a field's, whose sides take turns; triangles may face any way
Ray behind(const Ray& ray, const Hit& hit, bool is_field);

/// Light of the clear surfaces before the nearest opaque one, in their order along each ray, into Worker::front, from
/// the layers' first hits on. A ray ends where less than `least_light` of what is behind would be seen.
void peel_clear_layers(const Frame& frame, Worker& worker);

/// A layer's ray behind the last of its crossings that has been shown.
struct LastCrossing {
  std::uint8_t layer;
  std::uint32_t ray;
  Ray behind;
};

/// The same from where some rays are: behind their last crossings with each layer, or where they begin.
/// @param goes_on  1 for these rays of the tile
void peel_further(const Frame& frame, const std::uint8_t* goes_on, std::span<const LastCrossing> last, Worker& worker);

}  // namespace rhoray::render
