#include "preprocess/export/grid_samples.h"

#include "formats/base/nearest_name.h"
#include "formats/base/trouble.h"

namespace rhoray::preprocess {

formats::BrickGrid open_grid(const std::filesystem::path& path, const std::string& field) {
  const formats::BrickGrid grid(formats::PackedFile::open(path));
  const std::string& known = grid.description().field.name;
  if (!field.empty() && field != known)
    throw Error(Trouble::usage, concat(path.string(), ": no field '", field, "'; it has '", known, "'"),
                did_you_mean(field, std::vector{known}));
  return grid;
}

}  // namespace rhoray::preprocess
