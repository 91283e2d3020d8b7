#include "preprocess/components.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "formats/base/text.h"
#include "formats/base/word_list.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

constexpr std::string_view vector_names[] = {"x", "y", "z"};
constexpr std::string_view symmetric_names[] = {"xx", "yy", "zz", "xy", "yz", "xz"};
constexpr std::string_view tensor_names[] = {"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"};

/// The words for the components of an array; empty where they are counted.
std::span<const std::string_view> words_for(int component_count) {
  switch (component_count) {
    case 2:
    case 3:
      return std::span(vector_names).first(static_cast<std::size_t>(component_count));
    case 6:
      return symmetric_names;
    case 9:
      return tensor_names;
    default:
      return {};
  }
}

/// Sum of the squares of the components divided by `unit`.
double sum_of_squares(std::span<const double> components, double unit) {
  const std::size_t diagonal = components.size() == std::size(symmetric_names) ? 3 : components.size();
  double sum = 0;
  for (std::size_t c = 0; c < components.size(); ++c)
    sum += (c < diagonal ? 1 : 2) * (components[c] / unit) * (components[c] / unit);
  return sum;
}

}  // namespace

std::string scalar_name(std::string_view array, int component_count, int component) {
  if (component_count == 1) return std::string(array);
  if (component == magnitude_component) return concat(array, ".mag");
  const auto words = words_for(component_count);
  if (words.empty()) return concat(array, ".", component);
  return concat(array, ".", words[static_cast<std::size_t>(component)]);
}

std::vector<std::string> scalars_of(std::string_view array, int component_count) {
  std::vector<std::string> names;
  if (component_count > 1) names.push_back(scalar_name(array, component_count, magnitude_component));
  for (int c = 0; c < component_count; ++c) names.push_back(scalar_name(array, component_count, c));
  return names;
}

std::string scalars_text(std::string_view array, int component_count) {
  constexpr int most_listed = 9;
  if (component_count <= most_listed) return joined(scalars_of(array, component_count));
  return concat(array, ".mag, ", array, ".0 to ", array, ".", component_count - 1);
}

std::optional<int> component_in(std::string_view field, std::string_view array, int component_count) {
  if (component_count == 1) return field == array ? std::optional(0) : std::nullopt;
  if (!field.starts_with(array) || !field.substr(array.size()).starts_with('.')) return std::nullopt;
  for (int c = magnitude_component; c < component_count; ++c)
    if (field == scalar_name(array, component_count, c)) return c;
  return std::nullopt;
}

std::string note_of_choice(const std::vector<VectorArray>& arrays, std::size_t array, int component) {
  const auto& [name, count] = arrays[array];
  const std::string chosen = scalar_name(name, count, component);
  std::vector<std::string> others;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    std::string text = scalars_text(arrays[i].name, arrays[i].component_count);
    if (i == array && text == chosen) continue;
    if (i == array && text.starts_with(chosen + ", ")) text.erase(0, chosen.size() + 2);
    others.push_back(std::move(text));
  }
  if (others.empty()) return {};
  return concat("using ", component == magnitude_component ? concat("the magnitude of ", count, " components, ") : "",
                "'", chosen, "'; choose another with --field: ", joined(others));
}

double magnitude_of(std::span<const double> components) {
  if (!std::all_of(components.begin(), components.end(), [](double c) { return has_data(c); }))
    return std::numeric_limits<double>::quiet_NaN();
  const double sum = sum_of_squares(components, 1);
  if (sum > 1e-280 && sum < 1e300) return std::sqrt(sum);
  double largest = 0;
  for (const double c : components) largest = std::max(largest, std::abs(c));
  return largest == 0 ? 0 : largest * std::sqrt(sum_of_squares(components, largest));
}

}  // namespace rhoray::preprocess
