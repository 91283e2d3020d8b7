#include "formats/vdb_grid.h"

#include <cmath>

#include "formats/base/invertible.h"
#include "formats/details/details.h"
#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

using details::Json;

constexpr double farthest_sample = 1 << 30;

Json index_as_numbers(const Index3& index) {
  return details::vector_json(
      {static_cast<double>(index.x), static_cast<double>(index.y), static_cast<double>(index.z)}, "first_sample");
}

/// Reads an index that may be negative, which details::Reader::index refuses.
Index3 read_signed_index(const details::Reader& reader, const std::string& key) {
  const Vec3 numbers = reader.vector(key);
  Index3 index;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(numbers[axis]) <= farthest_sample) || numbers[axis] != std::floor(numbers[axis]))
      reader.refuse_value(key, "three integers from -2^30 to 2^30");
    index[axis] = static_cast<std::int64_t>(numbers[axis]);
  }
  return index;
}

Json texts_json(const std::vector<std::string>& texts) {
  Json list = Json::array();
  for (const std::string& text : texts) list.push_back({{"text", text}});
  return list;
}

std::vector<std::string> read_texts(const details::Reader& reader, const std::string& key) {
  std::vector<std::string> texts;
  for (const details::Reader& item : reader.objects(key)) texts.push_back(item.text("text"));
  return texts;
}

}  // namespace

VdbGrid::VdbGrid(PackedFile file) : file_(std::move(file)) {
  if (file_.description().kind != kind)
    refuse(file_.name(), "header, __metadata__, kind", concat("'", file_.description().kind, "'"), "'vdb'");
  const Json json = details::parse(file_);
  const details::Reader reader(json, file_.name(), "details");
  VdbGridDescription& grid = description_;
  grid.field = details::read_field(reader.object("field"));
  grid.field_names = read_texts(reader, "field_names");
  const details::Reader axes = reader.object("world_from_index");
  grid.world_from_index = {axes.vector("x_axis"), axes.vector("y_axis"), axes.vector("z_axis"), axes.vector("origin")};
  if (!is_invertible(grid.world_from_index)) reader.refuse_value("world_from_index", "axes that span a volume");
  grid.first_sample = read_signed_index(reader, "first_sample");
  grid.sample_count = reader.index("sample_count", 2, static_cast<std::int64_t>(farthest_sample));
  grid.is_level_set = reader.count("is_level_set", 0, 1) == 1;
  grid.length_unit = reader.text("length_unit");
  grid.active_voxel_count = reader.count("active_voxel_count");
  grid.notes = read_texts(reader, "notes");
  file_.array<std::uint8_t>(buffer_array, {0});
}

FileDescription describe(const VdbGridDescription& grid) {
  const std::string_view what = "world_from_index";
  const Affine& map = grid.world_from_index;
  const Json json{{"field", details::field_json(grid.field)},
                  {"field_names", texts_json(grid.field_names)},
                  {"world_from_index",
                   {{"x_axis", details::vector_json(map.x_axis, what)},
                    {"y_axis", details::vector_json(map.y_axis, what)},
                    {"z_axis", details::vector_json(map.z_axis, what)},
                    {"origin", details::vector_json(map.origin, what)}}},
                  {"first_sample", index_as_numbers(grid.first_sample)},
                  {"sample_count", details::index_json(grid.sample_count)},
                  {"is_level_set", grid.is_level_set ? 1U : 0U},
                  {"length_unit", grid.length_unit},
                  {"active_voxel_count", grid.active_voxel_count},
                  {"notes", texts_json(grid.notes)}};
  return {.kind = VdbGrid::kind, .required = {}, .details = details::dump(json)};
}

}  // namespace rhoray::formats
