#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "preprocess/labels.h"
#include "preprocess/open_data.h"
#include "render/document.h"
#include "render/load.h"
#include "tools/rhoray/cli/progress_display.h"

namespace rhoray::tools {

/// Refuses a file that is not packed and whose name does not end in .rho, and names the command
/// that packs it (ErrorCode::unsupported).
void require_packed(const std::filesystem::path& path);

/// How files that are not packed are opened, and who is told of it.
struct DataAccess {
  bool use_cache = true;
  render::ReadSpec read{};
  Progress progress{};
  std::function<void(const std::string&)> say{};   ///< one line about packing
  std::function<void(const std::string&)> tell{};  ///< more of it, for --verbose
  /// An opened file, and the names of fields for which it was opened.
  struct OpenedFor {
    preprocess::OpenedData data;
    std::vector<std::string> fields;
  };
  /// Opened files by path and options of packing; of OpenVDB files, which are opened for one grid,
  /// also by its name. Null: files are not kept open.
  using Opened = std::map<std::pair<std::filesystem::path, std::vector<std::string>>, OpenedFor>;
  std::shared_ptr<Opened> opened{};
  /// Loaded data of a scene by name and field. They keep what was prepared for pictures. Null: each
  /// scene loads its own.
  using Loaded = std::map<std::pair<std::string, std::string>, render::Dataset>;
  std::shared_ptr<Loaded> loaded{};
};
/// @param display  must outlive the result
/// @param read     of files that are not packed; a scene's data say it themselves
DataAccess access_for(const CommonOptions& common, ProgressDisplay& display, const render::ReadSpec& read = {});

/// Opens any file that can be rendered (preprocess/open_data.h); packs files that are not packed,
/// or takes their copy in the cache. Refuses an unknown field and names the nearest one. Without a
/// name it takes the first field that is not constant, or the first field if all are.
/// @param others  fields that are needed besides
/// @param world   as for render::Dataset::load
render::Dataset load_shown(const std::filesystem::path& path, const std::string& field, const DataAccess& access = {},
                           const std::vector<std::string>& others = {}, formats::Space world = formats::Space::unknown);

/// Says of a field of cells how commands that need values at points can use it.
inline constexpr const char* cell_field_hint =
    "it is a field of cells; `rhoray pack --cell-data` also stores it averaged to the points";

/// As above, for commands without colours; refuses a surface, which has no fields
/// (ErrorCode::unsupported).
render::Dataset load_dataset(const std::filesystem::path& path, const std::string& field,
                             const DataAccess& access = {});

/// Refuses an output that packing read when data were opened (ErrorCode::usage).
void require_not_read(const std::filesystem::path& output, const DataAccess& access);

/// The options of packing that say how a file is read.
preprocess::PackOptions pack_options(const render::ReadSpec& read);

/// --raw, --spacing, --origin and --time
std::vector<Option> read_options(render::ReadSpec& read);

/// A packed file with the content of any file that load_shown opens. Refuses an OpenVDB file, and a
/// file whose copy the cache has no room for (ErrorCode::resource).
std::filesystem::path packed_path(const std::filesystem::path& path, const std::string& field,
                                  const DataAccess& access = {});

/// As above; refuses a surface, which has no fields (ErrorCode::unsupported).
std::filesystem::path packed_data_path(const std::filesystem::path& path, const std::string& field,
                                       const DataAccess& access = {});

/// A field of labels of a grid.
struct Segmentation {
  formats::BrickGrid grid;
  std::size_t field;
  std::vector<preprocess::Label> labels;
};
/// The labels of data (preprocess/labels.h); nothing where they hold none.
std::optional<Segmentation> segmentation_in(const render::DataSpec& data, const DataAccess& access);

/// A field of labels of a mesh's cells.
struct Regions {
  std::string field;
  std::vector<preprocess::CellLabel> labels;
  formats::LabelNames names;
};
/// The labels of data that are a mesh: of the field that they name or would show, or of the first
/// field of labels if nothing else varies. Nothing where they hold none.
std::optional<Regions> regions_in(const render::DataSpec& data, const DataAccess& access);

/// Opens the data of a scene by load_shown (render/document.h), and labels of grids as their
/// indicators. Opens a mesh with labels once for all labels. Packs textures of any file that
/// `pack --color` takes.
render::ResolvedScene resolve_layers(const render::SceneSpec& scene_spec, const DataAccess& access = {});

/// The cache of packed copies: in the folder of the user, with the limit that RHORAY_CACHE_SIZE
/// sets.
preprocess::PackCache open_cache();

}  // namespace rhoray::tools
