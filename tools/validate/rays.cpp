#include "tools/validate/rays.h"

#include <cmath>
#include <numbers>

namespace rhoray::tools::validate {

namespace {

/// Bounding box of a transformed box.
Box3 mapped(const Box3& box, const Affine& map) {
  Box3 out;
  for (int corner = 0; corner < 8; ++corner)
    out.extendBy(map.point(
        {corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z}));
  return out;
}

}  // namespace

std::string_view name_of(Aim aim) {
  constexpr std::string_view names[aim_count] = {"anything", "vertices", "edges", "centres", "near", "camera"};
  return names[static_cast<std::size_t>(aim)];
}

RayMaker::RayMaker(const Affine& world_from_frame, const Box3& data_frame, std::uint64_t seed)
    : world_from_frame_(world_from_frame), frame_from_world_(world_from_frame.inverse()), generator_(seed) {
  const Box3 world = mapped(data_frame, world_from_frame);
  center_world_ = world.center();
  radius_world_ = world.size().length();
}

Vec3 RayMaker::point_in(const Box3& box) {
  const Vec3 share(random(), random(), random());
  return box.min + share * box.size();
}

RayMaker::SurfacePoint RayMaker::point_of(const Triangles& surface, Aim aim) {
  const std::size_t triangle = below(surface.corners.size());
  if (aim == Aim::center) return {surface.center(triangle), triangle};
  const std::size_t corner = below(3);
  const Vec3 a = surface.corner(triangle, corner), b = surface.corner(triangle, (corner + 1) % 3);
  return {aim == Aim::vertex ? a : a + random() * (b - a), triangle};
}

render::Ray RayMaker::toward(const Vec3& target_frame) {
  const double z = 2 * random() - 1, turn = 2 * std::numbers::pi * random();
  const double around = std::sqrt(1 - z * z);
  const Vec3 origin = frame_from_world_.point(
      center_world_ + radius_world_ * Vec3(around * std::cos(turn), around * std::sin(turn), z));
  const Vec3 way = target_frame - origin;
  return {origin, way / world_from_frame_.vector(way).length()};
}

std::vector<AimedRay> make_rays(RayMaker& maker, const Box3& data_frame, const Triangles& surface, std::size_t count) {
  Box3 surface_box;
  for (const Vec3& p : surface.points) surface_box.extendBy(p);
  const bool is_empty = surface.corners.empty();
  constexpr Aim turns[] = {Aim::anything, Aim::vertex, Aim::anything, Aim::edge, Aim::center};
  std::vector<AimedRay> rays;
  for (std::size_t r = 0; r < count; ++r) {
    const Aim aim = is_empty ? Aim::anything : turns[r % std::size(turns)];
    const Vec3 target = aim == Aim::anything ? maker.point_in(is_empty || r % 2 == 0 ? data_frame : surface_box)
                                             : maker.point_of(surface, aim).p;
    rays.push_back({maker.toward(target), aim});
  }
  return rays;
}

}  // namespace rhoray::tools::validate
