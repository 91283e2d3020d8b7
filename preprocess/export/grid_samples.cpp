#include "preprocess/export/grid_samples.h"

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"

namespace rhoray::preprocess {

OpenedGrid open_grid(const std::filesystem::path& path, const std::string& field) {
  OpenedGrid opened{formats::BrickGrid(formats::PackedFile::open(path))};
  if (field.empty()) return opened;
  if (const std::optional<std::size_t> found = opened.grid.find_field(field)) {
    opened.field = *found;
    return opened;
  }
  std::vector<std::string> known;
  std::string list;
  for (const formats::FieldSummary& summary : opened.description().fields) {
    known.push_back(summary.name);
    list += concat(list.empty() ? "'" : ", '", summary.name, "'");
  }
  throw Error(ErrorCode::usage, concat(path.string(), ": no field '", field, "'; it has ", list),
              did_you_mean(field, known));
}

void require_even_steps(const OpenedGrid& opened, const std::filesystem::path& path, std::string_view format) {
  if (!opened.description().is_rectilinear()) return;
  throw Error(ErrorCode::unsupported,
              concat(path.string(), ": the samples have uneven spacing; ", format, " needs even spacing"),
              ".npy keeps the samples; the positions are arrays axis.0 to axis.2 of the packed file");
}

}  // namespace rhoray::preprocess
