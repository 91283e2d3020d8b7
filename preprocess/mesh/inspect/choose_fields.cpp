#include "preprocess/mesh/inspect/choose_fields.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/interval.h"
#include "formats/base/lower_case.h"
#include "formats/base/nearest_name.h"
#include "formats/base/number_text.h"
#include "formats/base/word_list.h"
#include "preprocess/components.h"
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
  std::string name;
  const SourceField* source;
  int component;  ///< or `magnitude_component`
};

bool is_vector(const SourceField& source) {
  return source.field->component_count > 1;
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
  const auto is_point_field = [&](const std::string& name) {
    return std::any_of(fields.begin(), fields.end(),
                       [&](const SourceField& field) { return !field.is_of_cells && field.name == name; });
  };
  const auto add = [&](const NeutralField& field, bool is_of_cells, std::size_t place_count) {
    SourceField added{field.name.empty() ? "unnamed" : field.name, &field, is_of_cells};
    check_field(added, place_count, source_name);
    if (is_of_cells && is_point_field(added.name)) {
      const std::string other = added.name + ".cells";
      notes.push_back(concat("field \"", added.name, "\" of cells is kept as \"", other,
                             "\", because a field of points has its name"));
      added.name = other;
    }
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
std::vector<std::string> names_on_offer(const std::vector<SourceField>& fields) {
  std::vector<std::string> names;
  for (const SourceField& source : fields) {
    const std::vector<std::string> scalars = scalars_of(source.name, source.field->component_count);
    names.insert(names.end(), scalars.begin(), scalars.end());
  }
  return names;
}

/// The same as text.
std::string offer_of(const std::vector<SourceField>& fields) {
  std::vector<std::string> texts;
  for (const SourceField& source : fields) texts.push_back(scalars_text(source.name, source.field->component_count));
  return texts.empty() ? "no fields" : joined(texts);
}

/// Looks for the whole name first, because a name may itself contain a dot.
std::optional<Selection> find_selection(const std::vector<SourceField>& fields, const std::string& asked) {
  for (const bool in_vectors : {false, true})
    for (const SourceField& source : fields)
      if (is_vector(source) == in_vectors)
        if (const auto component = component_in(asked, source.name, source.field->component_count))
          return Selection{asked, &source, *component};
  return std::nullopt;
}

[[noreturn]] void refuse_name(const std::vector<SourceField>& fields, const std::string& asked,
                              const std::string& source_name) {
  const std::string offer = offer_of(fields);
  for (const SourceField& source : fields)
    if (source.name == asked && is_vector(source))
      throw Error(ErrorCode::usage,
                  concat(source_name, ", field \"", asked, "\": found ", source.field->component_count,
                         " components; expected one scalar of: ", offer),
                  concat("for its magnitude use \"", asked, ".mag\""));
  throw Error(ErrorCode::usage, concat(source_name, ": no field \"", asked, "\"; expected one of: ", offer),
              did_you_mean(asked, names_on_offer(fields)));
}

/// The scalars of the wanted names, or all.
std::vector<Selection> select(const std::vector<SourceField>& fields, const std::vector<std::string>& wanted,
                              const std::string& source_name) {
  std::vector<Selection> selections;
  std::set<std::string> chosen;
  for (const std::string& asked : wanted) {
    const std::optional<Selection> found = find_selection(fields, asked);
    if (!found) refuse_name(fields, asked, source_name);
    if (!chosen.insert(found->name).second)
      throw Error(ErrorCode::usage, concat("field \"", asked, "\": given twice; expected each field once"));
    selections.push_back(*found);
  }
  if (!wanted.empty()) return selections;
  for (const SourceField& source : fields)
    selections.push_back({scalars_of(source.name, source.field->component_count).front(), &source,
                          is_vector(source) ? magnitude_component : 0});
  return selections;
}

/// Refuses fields of cells alone: isosurfaces need values at points.
void require_points(const std::vector<Selection>& selections, bool cells_to_points, bool are_wanted,
                    const std::string& source_name) {
  const auto is_of_cells = [](const Selection& selection) { return selection.source->is_of_cells; };
  if (cells_to_points ? !selections.empty() : !std::all_of(selections.begin(), selections.end(), is_of_cells)) return;
  const std::string hint = "--cell-data averages cell fields to the points";
  if (are_wanted)
    throw Error(ErrorCode::usage,
                concat(source_name, ", field \"", selections.front().name,
                       "\": found a value for each cell; expected one for each point"),
                hint);
  throw Error(ErrorCode::invalid, concat(source_name, ": found no field at points; expected at least one"),
              selections.empty() ? "" : hint);
}

double scalar_at(const Selection& selection, std::uint64_t place) {
  const NeutralField& field = *selection.source->field;
  const auto count = static_cast<std::size_t>(field.component_count);
  const std::span<const double> components = std::span(field.values).subspan(place * count, count);
  if (selection.component == magnitude_component) return magnitude_of(components);
  return components[static_cast<std::size_t>(selection.component)];
}

/// @param places  of the points or cells in the source mesh
Array<double> taken(const Selection& selection, const Array<std::uint64_t>& places) {
  Array<double> values(places.size());
  for (std::size_t p = 0; p < values.size(); ++p) values[p] = scalar_at(selection, places[p]);
  return values;
}

/// The cells of a clean mesh in the order of the source mesh, where those cut from one cell are
/// neighbours.
Array<std::uint32_t> in_source_order(const CleanMesh& clean) {
  Array<std::uint32_t> order(clean.cells.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return clean.source_cells[a] < clean.source_cells[b]; });
  return order;
}

Array<double> averaged_to_points(const Selection& selection, const NeutralMesh& mesh, const CleanMesh& clean) {
  struct Mean {
    double sum = 0;
    std::uint64_t count = 0;
    std::uint64_t last = std::numeric_limits<std::uint64_t>::max();  ///< id of the source's cell
    Interval<double> range;
  };
  Array<Mean> means(clean.points.size());
  for (const std::uint32_t c : in_source_order(clean)) {
    const std::uint64_t cell = clean.source_cells[c];
    const double value = scalar_at(selection, cell);
    if (!has_data(value)) continue;
    const std::uint64_t id = mesh.cell_ids.empty() ? cell : mesh.cell_ids[cell];
    for (const std::uint32_t vertex : clean.cells[c]) {
      Mean& mean = means[vertex];
      if (mean.last == id) continue;
      mean.last = id;
      ++mean.count;
      mean.sum += value;
      mean.range.include(value);
    }
  }
  Array<double> values(means.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t p = 0; p < means.size(); ++p) {
    const Mean& mean = means[p];
    if (mean.count != 0)
      values[p] = std::clamp(mean.sum / static_cast<double>(mean.count), mean.range.lo, mean.range.hi);
  }
  return values;
}

Interval<double> range_of(const Array<double>& values) {
  Interval<double> range;
  for (const double value : values)
    if (has_data(value)) range.include(value);
  return range;
}

std::string note_of_mean(const std::string& name, const Array<double>& of_cells, const Array<double>& of_points) {
  const Interval<double> before = range_of(of_cells), after = range_of(of_points);
  if (before.is_empty()) return concat("field \"", name, "\" of cells was averaged to the points; it holds no value");
  return concat("field \"", name, "\" was averaged to the points: ", rounded(before.lo), " to ", rounded(before.hi),
                " in cells became ", rounded(after.lo), " to ", rounded(after.hi));
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

ScalarField field_of(const Selection& selection, Array<double> values, bool is_mean) {
  const NeutralField& source = *selection.source->field;
  ScalarField field{.name = selection.name, .unit = source.unit, .values = {}};
  std::optional<Array<float>> single;
  if (source.was_single_precision)
    single = in_single_precision(values, is_mean || selection.component == magnitude_component);
  if (single)
    field.values = std::move(*single);
  else
    field.values = std::move(values);
  if (source.component_count == 1 && !is_mean) field.label_names = source.label_names;
  return field;
}

/// True for the names under which programs keep ids and masks: "vtkOriginalCellIds",
/// "GlobalNodeId".
bool is_bookkeeping(std::string_view name) {
  static constexpr std::string_view names[] = {"avtghostnodes",          "avtghostzones",    "avtoriginalcellnumbers",
                                               "avtoriginalnodenumbers", "iblank",           "vtkghostlevels",
                                               "vtkghosttype",           "vtkvalidpointmask"};
  std::string plain = lower_case(name);
  std::erase_if(plain, [](char letter) { return letter == ' ' || letter == '_'; });
  if (std::find(std::begin(names), std::end(names), plain) != std::end(names)) return true;
  if (plain.ends_with('s')) plain.pop_back();
  for (const std::string_view of : {"cell", "element", "node", "point"})
    for (const std::string_view origin : {"", "global", "pedigree", "vtkoriginal"})
      if (plain == concat(origin, of, "id")) return true;
  return false;
}

bool varies(const ScalarField& field) {
  return std::visit(
      [](const auto& values) {
        const auto first = std::find_if(values.begin(), values.end(), [](auto value) { return has_data(value); });
        return std::any_of(first, values.end(), [&](auto value) { return has_data(value) && value != *first; });
      },
      field.values);
}

/// Puts the fields first that a picture is worth showing: they vary and are no ids or masks.
void put_telling_fields_first(std::vector<ScalarField>& fields) {
  std::stable_partition(fields.begin(), fields.end(),
                        [](const ScalarField& field) { return varies(field) && !is_bookkeeping(field.name); });
}

/// Says that the first field, which pictures show, is a magnitude, and what else there is.
void note_magnitude(const std::vector<SourceField>& sources, const ChosenFields& fields,
                    std::vector<std::string>& notes) {
  const std::vector<ScalarField>& shown = fields.of_points.empty() ? fields.of_cells : fields.of_points;
  std::vector<VectorArray> arrays;
  for (const SourceField& source : sources) arrays.push_back({source.name, source.field->component_count});
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (is_vector(sources[i]) && shown.front().name == scalars_of(arrays[i].name, arrays[i].component_count).front())
      notes.push_back(note_of_choice(arrays, i, magnitude_component));
}

}  // namespace

std::uint64_t no_data_count(const ScalarField& field) {
  return std::visit(
      [](const auto& values) {
        return static_cast<std::uint64_t>(
            std::count_if(values.begin(), values.end(), [](auto value) { return !has_data(value); }));
      },
      field.values);
}

void note_no_data(const std::string& field, std::uint64_t count, std::string_view consequence,
                  std::vector<std::string>& notes) {
  if (count == 0) return;
  notes.push_back(concat("field \"", field, "\" has no data at ", count_text(count, "point", "points"),
                         "; adjacent cells ", consequence));
}

ChosenFields choose_fields(const NeutralMesh& mesh, const CleanMesh& clean, const std::vector<std::string>& wanted,
                           bool cells_to_points, const std::string& source_name, std::vector<std::string>& notes) {
  const std::vector<SourceField> sources = source_fields(mesh, source_name, notes);
  const std::vector<Selection> selections = select(sources, wanted, source_name);
  require_points(selections, cells_to_points, !wanted.empty(), source_name);
  ChosenFields fields;
  for (const Selection& selection : selections) {
    if (!selection.source->is_of_cells) {
      fields.of_points.push_back(field_of(selection, taken(selection, clean.source_points), false));
      continue;
    }
    Array<double> values = taken(selection, clean.source_cells);
    if (cells_to_points) {
      Array<double> means = averaged_to_points(selection, mesh, clean);
      notes.push_back(note_of_mean(selection.name, values, means));
      fields.of_points.push_back(field_of(selection, std::move(means), true));
    }
    fields.of_cells.push_back(field_of(selection, std::move(values), false));
  }
  if (!wanted.empty()) return fields;
  put_telling_fields_first(fields.of_points);
  put_telling_fields_first(fields.of_cells);
  note_magnitude(sources, fields, notes);
  return fields;
}

}  // namespace rhoray::preprocess
