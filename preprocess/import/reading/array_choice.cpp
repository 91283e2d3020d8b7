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

std::optional<int> component_count_of(const std::vector<std::int64_t>& sizes) {
  constexpr std::int64_t largest_tensor = 9;
  if (sizes.size() == 3) return 1;
  if (sizes.size() != 4 || sizes[3] < 2 || sizes[3] > largest_tensor) return std::nullopt;
  return static_cast<int>(sizes[3]);
}

VolumeChoice choose_volume(const std::filesystem::path& path, const std::vector<NamedShape>& arrays,
                           const std::string& field, std::string_view expected) {
  VolumeChoice choice;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (const std::optional<int> count = component_count_of(arrays[i].shape)) {
      choice.volumes.push_back({arrays[i].name, *count});
      places.push_back(i);
    } else if (!field.empty() && arrays[i].name == field) {
      check_axes(path, arrays[i], 3, expected);
    }
  }
  if (choice.volumes.empty()) choose_array(path, arrays, field, 3);  // refuses
  choice.scalar = choose_scalar(path, choice.volumes, field);
  choice.array = places[choice.scalar.array];
  return choice;
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
