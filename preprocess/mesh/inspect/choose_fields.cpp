#include "preprocess/mesh/inspect/choose_fields.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/interval.h"
#include "formats/base/nearest_name.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

/// A field of the source and the name under which users select it.
struct SourceField {
  std::string name;
  const NeutralField* field;
  bool is_of_cells;
};

/// One scalar to be made from a source field.
struct Selection {
  static constexpr int magnitude = -1;

  std::string name;
  const SourceField* source;
  int component;  ///< or `magnitude`
};

bool is_vector(const SourceField& source) {
  return source.field->component_count > 1;
}

std::string component_name(const SourceField& source, int component) {
  if (source.field->component_count <= 3)
    return concat(source.name, '.', std::string_view("xyz").substr(static_cast<std::size_t>(component), 1));
  return concat(source.name, '.', component);
}

void check_field(const SourceField& source, std::size_t place_count, const std::string& source_name) {
  const NeutralField& field = *source.field;
  if (field.component_count < 1 ||
      field.values.size() / static_cast<std::size_t>(field.component_count) != place_count ||
      field.values.size() % static_cast<std::size_t>(field.component_count) != 0)
    throw Error(ErrorCode::invalid, concat(source_name, ", field \"", source.name, "\": found ", field.values.size(),
                                           " values of ", field.component_count, " components; expected those of ",
                                           place_count, source.is_of_cells ? " cells" : " points"));
}

/// Returns all fields of the mesh, point fields first; their names differ.
std::vector<SourceField> source_fields(const NeutralMesh& mesh, const std::string& source_name,
                                       std::vector<std::string>& notes) {
  std::vector<SourceField> fields;
  std::set<std::string> names;
  const auto add = [&](const NeutralField& field, bool is_of_cells, std::size_t place_count) {
    SourceField added{field.name.empty() ? "unnamed" : field.name, &field, is_of_cells};
    check_field(added, place_count, source_name);
    if (names.insert(added.name).second)
      fields.push_back(std::move(added));
    else
      notes.push_back(concat("field \"", added.name, is_of_cells ? "\" of cells" : "\" of points",
                             " has the name of an earlier field; it is left out"));
  };
  for (const NeutralField& field : mesh.point_fields) add(field, false, mesh.points.size());
  for (const NeutralField& field : mesh.cell_fields) add(field, true, mesh.cells.size());
  return fields;
}

/// Returns every name that can be selected.
std::vector<std::string> names_on_offer(const std::vector<SourceField>& fields, bool cells_to_points) {
  std::vector<std::string> names;
  for (const SourceField& source : fields) {
    if (source.is_of_cells && !cells_to_points) continue;
    if (!is_vector(source)) {
      names.push_back(source.name);
      continue;
    }
    for (int c = 0; c < source.field->component_count; ++c) names.push_back(component_name(source, c));
    names.push_back(source.name + ".mag");
  }
  return names;
}

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += concat(list.empty() ? "" : ", ", name);
  return list;
}

std::optional<int> component_of(const SourceField& source, std::string_view suffix) {
  const int count = source.field->component_count;
  if (suffix == "mag") return Selection::magnitude;
  if (suffix.size() == 1 && count <= 3) {
    const std::size_t letter = std::string_view("xyz").find(suffix);
    if (letter < static_cast<std::size_t>(count)) return static_cast<int>(letter);
  }
  int number = 0;
  const auto [end, error_code] = std::from_chars(suffix.data(), suffix.data() + suffix.size(), number);
  if (error_code != std::errc{} || end != suffix.data() + suffix.size() || number < 0 || number >= count)
    return std::nullopt;
  return number;
}

/// Looks for the whole name first, because a name may itself contain a dot.
std::optional<Selection> find_selection(const std::vector<SourceField>& fields, const std::string& asked) {
  for (const SourceField& source : fields)
    if (source.name == asked && !is_vector(source)) return Selection{asked, &source, 0};
  const std::size_t dot = asked.rfind('.');
  if (dot == std::string::npos) return std::nullopt;
  for (const SourceField& source : fields)
    if (is_vector(source) && source.name == asked.substr(0, dot))
      if (const auto component = component_of(source, std::string_view(asked).substr(dot + 1))) {
        const bool is_magnitude = *component == Selection::magnitude;
        return Selection{is_magnitude ? asked : component_name(source, *component), &source, *component};
      }
  return std::nullopt;
}

[[noreturn]] void refuse_name(const std::vector<SourceField>& fields, const std::string& asked, bool cells_to_points,
                              const std::string& source_name) {
  const std::vector<std::string> names = names_on_offer(fields, cells_to_points);
  const std::string offer = names.empty() ? "no fields at points" : listed(names);
  for (const SourceField& source : fields)
    if (source.name == asked && is_vector(source) && (cells_to_points || !source.is_of_cells))
      throw Error(ErrorCode::usage,
                  concat(source_name, ", field \"", asked, "\": found a vector of ", source.field->component_count,
                         " components; expected one scalar of: ", offer),
                  concat("for its length use \"", asked, ".mag\""));
  throw Error(ErrorCode::usage, concat(source_name, ": no field \"", asked, "\"; expected one of: ", offer),
              did_you_mean(asked, names));
}

Selection select(const std::vector<SourceField>& fields, const std::string& asked, bool cells_to_points,
                 const std::string& source_name) {
  const std::optional<Selection> found = find_selection(fields, asked);
  if (!found) refuse_name(fields, asked, cells_to_points, source_name);
  if (found->source->is_of_cells && !cells_to_points)
    throw Error(
        ErrorCode::usage,
        concat(source_name, ", field \"", asked, "\": found a value for each cell; expected one for each point"),
        "--cell-data averages cell fields to the points");
  return *found;
}

std::vector<Selection> select_all(const std::vector<SourceField>& fields, bool cells_to_points) {
  std::vector<Selection> all;
  for (const SourceField& source : fields) {
    if (source.is_of_cells && !cells_to_points) continue;
    if (is_vector(source))
      all.push_back({source.name + ".mag", &source, Selection::magnitude});
    else
      all.push_back({source.name, &source, 0});
  }
  return all;
}

/// Length of a vector. The components are scaled where squares would leave the range of double.
double magnitude_of(std::span<const double> components) {
  double sum = 0, largest = 0;
  for (const double c : components) {
    sum += c * c;
    largest = std::max(largest, std::abs(c));
    if (!has_data(c)) return std::numeric_limits<double>::quiet_NaN();
  }
  if (sum > 1e-280 && sum < 1e300) return std::sqrt(sum);
  if (largest == 0) return 0;
  sum = 0;
  for (const double c : components) sum += (c / largest) * (c / largest);
  return largest * std::sqrt(sum);
}

double scalar_at(const Selection& selection, std::uint64_t place) {
  const NeutralField& field = *selection.source->field;
  const auto count = static_cast<std::size_t>(field.component_count);
  const std::span<const double> components = std::span(field.values).subspan(place * count, count);
  if (selection.component == Selection::magnitude) return magnitude_of(components);
  return components[static_cast<std::size_t>(selection.component)];
}

Array<double> at_points(const Selection& selection, const CleanMesh& clean) {
  Array<double> values(clean.points.size());
  for (std::size_t p = 0; p < values.size(); ++p) values[p] = scalar_at(selection, clean.source_points[p]);
  return values;
}

/// Volumes of the cells relative to the largest one, so that they cause no overflow in sums of
/// weighted values.
Array<double> relative_volumes(const CleanMesh& clean) {
  Array<double> volumes(clean.cells.size());
  for (std::size_t c = 0; c < volumes.size(); ++c) {
    const auto vertex = [&](std::size_t v) {
      const auto& p = clean.points[clean.cells[c][v]];
      return Vec3(p[0], p[1], p[2]);
    };
    const Vec3 p0 = vertex(0);
    volumes[c] = std::abs((vertex(1) - p0).cross(vertex(2) - p0).dot(vertex(3) - p0));
  }
  const double largest = *std::max_element(volumes.begin(), volumes.end());
  if (largest > 0)
    for (double& cell_volume : volumes) cell_volume /= largest;
  return volumes;
}

Array<double> averaged_to_points(const Selection& selection, const CleanMesh& clean, const Array<double>& weights) {
  struct Mean {
    double weighted_sum = 0, weight = 0;
    double plain_sum = 0, count = 0;
    Interval<double> range;
  };
  Array<Mean> means(clean.points.size());
  for (std::size_t c = 0; c < clean.cells.size(); ++c) {
    const double value = scalar_at(selection, clean.source_cells[c]);
    if (!has_data(value)) continue;
    for (const std::uint32_t vertex : clean.cells[c]) {
      Mean& mean = means[vertex];
      mean.weighted_sum += weights[c] * value;
      mean.weight += weights[c];
      mean.plain_sum += value;
      mean.count += 1;
      mean.range.include(value);
    }
  }
  Array<double> values(means.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t p = 0; p < means.size(); ++p) {
    const Mean& mean = means[p];
    if (mean.count == 0) continue;
    const double value = mean.weight > 0 ? mean.weighted_sum / mean.weight : mean.plain_sum / mean.count;
    values[p] = std::clamp(value, mean.range.lo, mean.range.hi);
  }
  return values;
}

/// Converts to single precision when it holds every value: exactly, or, where the values are
/// derived, rounded but still finite.
std::optional<Array<float>> in_single_precision(const Array<double>& values, bool may_round) {
  Array<float> single(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!has_data(values[i])) {
      single[i] = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    if (std::abs(values[i]) > static_cast<double>(std::numeric_limits<float>::max())) return std::nullopt;
    single[i] = static_cast<float>(values[i]);
    if (!may_round && static_cast<double>(single[i]) != values[i]) return std::nullopt;
  }
  return single;
}

}  // namespace

std::vector<PointField> choose_fields(const NeutralMesh& mesh, const CleanMesh& clean,
                                      const std::vector<std::string>& wanted, bool cells_to_points,
                                      const std::string& source_name, std::vector<std::string>& notes) {
  const std::vector<SourceField> sources = source_fields(mesh, source_name, notes);
  std::vector<Selection> selections;
  std::set<std::string> chosen;
  for (const std::string& asked : wanted) {
    selections.push_back(select(sources, asked, cells_to_points, source_name));
    if (!chosen.insert(selections.back().name).second)
      throw Error(ErrorCode::usage, concat("field \"", asked, "\": given twice; expected each field once"));
  }
  if (wanted.empty()) selections = select_all(sources, cells_to_points);
  if (selections.empty())
    throw Error(ErrorCode::invalid, concat(source_name, ": found no field at points; expected at least one"),
                mesh.cell_fields.empty() ? "" : "--cell-data averages its cell fields to the points");

  Array<double> weights;
  if (std::any_of(selections.begin(), selections.end(), [](const Selection& s) { return s.source->is_of_cells; }))
    weights = relative_volumes(clean);
  std::vector<PointField> fields;
  for (const Selection& selection : selections) {
    const SourceField& source = *selection.source;
    Array<double> values =
        source.is_of_cells ? averaged_to_points(selection, clean, weights) : at_points(selection, clean);
    PointField field{.name = selection.name, .unit = source.field->unit, .values = {}};
    const bool is_derived = source.is_of_cells || selection.component == Selection::magnitude;
    std::optional<Array<float>> single;
    if (source.field->was_single_precision) single = in_single_precision(values, is_derived);
    if (single)
      field.values = std::move(*single);
    else
      field.values = std::move(values);
    fields.push_back(std::move(field));
  }
  return fields;
}

}  // namespace rhoray::preprocess
