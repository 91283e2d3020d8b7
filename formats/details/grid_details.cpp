#include "formats/details/grid_details.h"

#include "formats/base/bytes.h"
#include "formats/base/invertible.h"

namespace rhoray::formats::details {
namespace {

constexpr std::int64_t largest_brick_edge = 64;
constexpr std::int64_t largest_superbrick_edge = 64;

}  // namespace

BrickLayout read_layout(const Reader& reader, std::int64_t least_count) {
  BrickLayout layout;
  layout.sample_count = reader.index("sample_count", least_count, largest_axis);
  layout.brick_edge = static_cast<std::int64_t>(reader.count("brick_edge", 1, largest_brick_edge));
  layout.superbrick_edge = reader.index("superbrick_edge", 1, largest_superbrick_edge);
  // Each padded axis is below 2^21, so the product of three fits in 64 bits. Times the bytes of a
  // sample, it may not.
  const Index3 padded = layout.padded_count();
  if (!checked_product({static_cast<std::uint64_t>(volume(padded)), sizeof(double)}))
    reader.refuse_value("sample_count", "a grid whose size fits 64 bits");
  return layout;
}

Affine read_affine(const Reader& reader) {
  const Reader axes = reader.object("world_from_grid");
  const Affine affine{axes.vector("x_axis"), axes.vector("y_axis"), axes.vector("z_axis"), axes.vector("origin")};
  if (!is_invertible(affine)) reader.refuse_value("world_from_grid", "axes that span a volume");
  return affine;
}

Json affine_json(const Affine& affine) {
  const std::string_view what = "world_from_grid";
  return {{"x_axis", vector_json(affine.x_axis, what)},
          {"y_axis", vector_json(affine.y_axis, what)},
          {"z_axis", vector_json(affine.z_axis, what)},
          {"origin", vector_json(affine.origin, what)}};
}

Space read_space(const Reader& reader) {
  if (!reader.has("space")) return Space::unknown;
  const std::optional<Space> space = space_named(reader.text("space"));
  if (!space) reader.refuse_value("space", "RAS or LPS");
  return *space;
}

}  // namespace rhoray::formats::details
