#include "preprocess/export/grid_samples.h"

#include "formats/base/descriptor.h"
#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "formats/base/regular_file.h"

namespace rhoray::preprocess {

formats::PackedFile open_packed(const std::filesystem::path& path, const std::string& name) {
  const Descriptor file(open_regular_file(path));
  return formats::PackedFile::from_descriptor(file.number(), name.empty() ? path.string() : name);
}

OpenedGrid open_grid(const std::filesystem::path& path, const std::string& field, const std::string& name) {
  OpenedGrid opened{formats::BrickGrid(open_packed(path, name))};
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
  throw Error(ErrorCode::usage, concat(opened.name(), ": no field '", field, "'; it has ", list),
              did_you_mean(field, known));
}

void require_even_steps(const OpenedGrid& opened, std::string_view format) {
  if (!opened.description().is_rectilinear()) return;
  throw Error(ErrorCode::unsupported,
              concat(opened.name(), ": the samples have uneven spacing; ", format, " needs even spacing"),
              ".npy keeps the samples; the positions are arrays axis.0 to axis.2 of the packed file");
}

}  // namespace rhoray::preprocess
