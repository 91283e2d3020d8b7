#include "preprocess/import/reading/array_choice.h"

#include "formats/base/error.h"
#include "formats/base/word_list.h"
#include "preprocess/process/foreign_file.h"

namespace rhoray::preprocess {

std::string shape_text(const std::vector<std::int64_t>& shape) {
  return shape.empty() ? "a single number" : joined(shape, " x ");
}

std::size_t choose_array(const std::filesystem::path& path, const std::vector<NamedShape>& arrays,
                         const std::string& field, std::size_t axis_count) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const auto& [name, shape] = arrays[i];
    if (field.empty() ? shape.size() == axis_count : name == field) return i;
    known.push_back(concat(name, " (", shape_text(shape), ")"));
  }
  if (known.empty()) refuse_input(path, "arrays", "none", "at least one");
  if (!field.empty())
    throw Error(ErrorCode::usage,
                concat(path.string(), ": found no field '", field, "'; expected one of: ", joined(known)));
  refuse_input(path, "arrays", joined(known), concat("one of ", axis_count, " axes"), ErrorCode::unsupported);
}

void set_names(NeutralVolume& volume, const std::vector<NamedShape>& arrays, std::size_t chosen,
               const std::string& field, std::size_t axis_count) {
  volume.field_name = arrays[chosen].name;
  for (std::size_t i = 0; i < arrays.size(); ++i)
    if (i != chosen && arrays[i].shape.size() == axis_count) volume.other_fields.push_back(arrays[i].name);
  if (field.empty() && !volume.other_fields.empty())
    volume.notes.push_back(concat("using the first array, '", volume.field_name,
                                  "'; choose another with --field: ", joined(volume.other_fields)));
}

void check_axes(const std::filesystem::path& path, const NamedShape& array, std::size_t axis_count,
                std::string_view expected) {
  const std::size_t count = array.shape.size();
  if (count != axis_count)
    refuse_input(path, concat("array '", array.name, "'"),
                 concat(count_text(count, "axis", "axes"), " (", shape_text(array.shape), ")"), expected,
                 ErrorCode::unsupported);
}

}  // namespace rhoray::preprocess
