#include "tools/rhoray/info/vdb.h"

#include "formats/base/number_text.h"
#include "preprocess/open_vdb.h"

namespace rhoray::tools {

namespace {

Json json_of_grid(const preprocess::VdbGridFacts& grid) {
  Json json{{"name", grid.name},
            {"value_type", grid.value_type},
            {"class", grid.grid_class},
            {"active_voxels", grid.active_voxel_count}};
  if (grid.active_voxel_count != 0) {
    json["first_active"] = json_of(grid.first_active);
    json["last_active"] = json_of(grid.last_active);
  }
  if (grid.background) json["background"] = *grid.background;
  json["map_type"] = grid.map_type;
  if (grid.world_from_index) json["geometry"] = json_of(*grid.world_from_index);
  json["metadata"] = Json::object();
  for (const auto& [key, value] : grid.metadata) json["metadata"][key] = value;
  return json;
}

}  // namespace

Json vdb_info(const std::filesystem::path& path, std::uint64_t memory_limit_bytes) {
  const std::vector<preprocess::VdbGridFacts> grids = preprocess::inspect_vdb(path, memory_limit_bytes);
  Json json{{"file", path.string()},  {"kind", "vdb"},
            {"packed", false},        {"file_bytes", std::filesystem::file_size(path)},
            {"length_unit", ""},      {"grids", Json::array()},
            {"fields", Json::array()}};
  for (const preprocess::VdbGridFacts& grid : grids) {
    json["grids"].push_back(json_of_grid(grid));
    if (grid.field) json["fields"].push_back(json_of(*grid.field));
    if (grid.field && grid.world_from_index && !json.contains("geometry"))
      json["geometry"] = json_of(*grid.world_from_index);
  }
  return json;
}

std::string grid_text(const Json& grid) {
  std::string text = concat("'", grid["name"].get<std::string>(), "'  ", grid["value_type"].get<std::string>(), ", ",
                            grid["class"].get<std::string>(), ", ", grouped(grid["active_voxels"]), " active voxels");
  const auto corner = [](const Json& index) {
    return concat("(", index[0].get<std::int64_t>(), " ", index[1].get<std::int64_t>(), " ",
                  index[2].get<std::int64_t>(), ")");
  };
  if (grid.contains("first_active"))
    text += concat(" in ", corner(grid["first_active"]), " to ", corner(grid["last_active"]));
  if (grid.contains("background")) text += concat(", background ", rounded(grid["background"], 6));
  return text;
}

}  // namespace rhoray::tools
