#pragma once

#include <cstdint>
#include <span>

#include "render/frame/frame.h"

/// Composites transparent surfaces crossing by crossing: behind each crossing the ray is traced
/// again.
namespace rhoray::render {

/// A ray ends when less than this share of the light behind would be visible.
inline constexpr float least_light = 1.0F / 1024;

/// Returns the ray that continues behind its crossing. If two crossings had the same t, the next
/// one is searched behind that t, so that the search also ends for folded surfaces.
/// @param is_field  true: crossings of a field, which alternate between sides; triangles may face
///                  any way
Ray behind(const Ray& ray, const Hit& hit, bool is_field);

/// Composites the transparent surfaces in front of the nearest opaque one into Worker::front. It
/// follows their order along each ray, starting with the layers' first hits. A ray ends where less
/// than `least_light` of the light behind would be visible.
void peel_clear_layers(const Frame& frame, Worker& worker);

/// A layer's ray behind the last crossing that was shown.
struct LastCrossing {
  std::uint8_t layer;
  std::uint32_t ray;
  Ray behind;
};

/// Does the same for some rays, starting behind their last crossing with each layer, or at their
/// origin.
/// @param goes_on  1 for the rays of the tile to continue
void peel_further(const Frame& frame, const std::uint8_t* goes_on, std::span<const LastCrossing> last, Worker& worker);

}  // namespace rhoray::render
