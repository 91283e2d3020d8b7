#include "formats/brick_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "formats/base/checks.h"
#include "formats/details/details.h"
#include "formats/details/grid_details.h"
#include "formats/format_error.h"

namespace rhoray::formats {
namespace {

using details::Json;

constexpr std::string_view grid_kind = "grid";
// Without these features a reader would place samples at wrong positions.
constexpr std::string_view axis_tables_feature = "axis-tables";
constexpr std::string_view sparse_bricks_feature = "sparse-bricks";

bool requires_feature(const PackedFile& file, std::string_view feature) {
  const std::vector<std::string>& required = file.description().required;
  return std::find(required.begin(), required.end(), feature) != required.end();
}

void read_sparse(const details::Reader& reader, BrickLayout& layout) {
  if (!BrickLayout::is_sparse_edge(layout.brick_edge))
    reader.refuse_value("brick_edge", "2, 4, 8, 16, 32 or 64 in a sparse grid");
  if (layout.superbrick_edge != Index3(1, 1, 1)) reader.refuse_value("superbrick_edge", "[1,1,1] in a sparse grid");
  layout.is_sparse = true;
  layout.stored_brick_count = reader.count("stored_brick_count", 0, BrickGrid::no_brick);
}

bool is_floating(ElementType type) {
  return type == ElementType::F32 || type == ElementType::F64;
}

Certificate read_certificate(const details::Reader& reader) {
  Certificate certificate;
  certificate.type = reader.element_type("type");
  if (!is_floating(certificate.type)) reader.refuse_value("type", "F32 or F64");
  certificate.max_error = reader.number("max_error", 0);
  certificate.rms_error = reader.number("rms_error", 0);
  certificate.max_at = reader.vector("max_at");
  certificate.point_count = reader.count("point_count");
  if (reader.has("coverage")) {
    certificate.coverage = reader.number("coverage", 0);
    if (*certificate.coverage > 1) reader.refuse_value("coverage", "0 to 1");
  }
  if (reader.has("requested_error")) certificate.requested_error = reader.number("requested_error", 0);
  return certificate;
}

void read_one_field(const details::Reader& reader, GridDescription& description) {
  const FieldSummary field = details::read_field(reader);
  for (const FieldSummary& other : description.fields)
    if (other.name == field.name) reader.refuse_value("name", "a name that no other field has");
  if (description.layout.is_sparse && !is_floating(field.type))
    reader.refuse_value("type", "F32 or F64 in a sparse grid");
  if (reader.has("certificate"))
    description.certificates.emplace(description.fields.size(), read_certificate(reader.object("certificate")));
  description.fields.push_back(field);
}

GridDescription read_description(const PackedFile& file) {
  if (file.description().kind != grid_kind)
    refuse(file.name(), "header, __metadata__, kind", concat("'", file.description().kind, "'"), "'grid'");
  const Json json = details::parse(file);
  const details::Reader reader(json, file.name(), "details");
  GridDescription description;
  description.layout = details::read_layout(reader, 2);
  if (requires_feature(file, sparse_bricks_feature)) read_sparse(reader, description.layout);
  description.world_from_grid = details::read_affine(reader);
  description.length_unit = reader.text("length_unit");
  description.space = details::read_space(reader);
  read_one_field(reader.object("field"), description);
  if (reader.has("more_fields"))
    for (const details::Reader& field : reader.objects("more_fields")) read_one_field(field, description);
  description.macro = details::read_macro(reader.object("macro"), description.layout.sample_count - Index3(1, 1, 1));
  description.provenance = details::read_provenance(reader.object("provenance"));
  return description;
}

std::vector<double> read_axis(const PackedFile& file, int axis, std::int64_t sample_count) {
  const std::string name = axis_array(axis);
  if (!file.has(name)) return {};
  const std::span<const double> table = file.array<double>(name, {static_cast<std::uint64_t>(sample_count)});
  for (std::size_t i = 0; i < table.size(); ++i)
    if (!std::isfinite(table[i]) || (i > 0 && !(table[i] > table[i - 1])))
      refuse(file.name(), concat("array '", name, "', element ", i), concat(table[i]),
             i == 0 ? "a finite number" : concat("a finite number above ", table[i - 1]));
  if (!std::isfinite(table.back() - table.front()))
    refuse(file.name(), concat("array '", name, "'"), concat(table.front(), " to ", table.back()),
           "an axis of finite length");
  return {table.begin(), table.end()};
}

/// Checks that every stored brick has exactly one slot.
void check_slots(const PackedFile& file, std::span<const std::uint32_t> slots, std::uint64_t stored_count) {
  const auto refuse_slot = [&](std::size_t brick, std::string_view expected) {
    refuse(file.name(), concat("array 'bricks', element ", brick), concat(slots[brick]), expected);
  };
  std::vector<bool> taken(stored_count);
  std::uint64_t used = 0;
  for (std::size_t brick = 0; brick < slots.size(); ++brick) {
    if (slots[brick] == BrickGrid::no_brick) continue;
    if (slots[brick] >= stored_count) refuse_slot(brick, concat("4294967295 or a slot below ", stored_count));
    if (taken[slots[brick]]) refuse_slot(brick, "a slot that no other brick has");
    taken[slots[brick]] = true;
    ++used;
  }
  if (used != stored_count)
    refuse(file.name(), "array 'bricks'", concat(used, " bricks with a slot"), concat(stored_count, " of them"));
}

std::vector<std::uint64_t> shape_of(const Index3& count) {
  return {static_cast<std::uint64_t>(count.z), static_cast<std::uint64_t>(count.y),
          static_cast<std::uint64_t>(count.x)};
}

Json certificate_json(const Certificate& certificate, const std::string& field) {
  const std::string what = concat("certificate of field '", field, "'");
  Json json{{"type", element_name(certificate.type)},
            {"max_error", details::number_json(certificate.max_error, what)},
            {"rms_error", details::number_json(certificate.rms_error, what)},
            {"max_at", details::vector_json(certificate.max_at, what)},
            {"point_count", certificate.point_count}};
  if (certificate.coverage) json["coverage"] = details::number_json(*certificate.coverage, what);
  if (certificate.requested_error) json["requested_error"] = details::number_json(*certificate.requested_error, what);
  return json;
}

Json grid_field_json(const GridDescription& description, std::size_t field) {
  const FieldSummary& summary = description.fields[field];
  Json json = details::field_json(summary);
  const auto certificate = description.certificates.find(field);
  if (certificate != description.certificates.end())
    json["certificate"] = certificate_json(certificate->second, summary.name);
  return json;
}

/// The first minor version with all features that the file uses.
int first_minor_version(const GridDescription& description, const FileDescription& file) {
  for (const FieldSummary& field : description.fields)
    if (!field.mean_gradient.empty() || !field.label_names.empty()) return 8;
  if (description.space != Space::unknown) return 6;
  for (const auto& [field, certificate] : description.certificates)
    if (certificate.coverage || certificate.requested_error) return 5;
  const bool is_of_version_1_0 =
      file.required.empty() && description.fields.size() == 1 && description.certificates.empty();
  return is_of_version_1_0 ? 0 : 1;
}

std::string field_prefix(std::size_t field) {
  return field == 0 ? std::string() : concat("field.", field, ".");
}

}  // namespace

std::string samples_array(std::size_t field) {
  return concat(field_prefix(field), "samples");
}
std::string macro_prefix(std::size_t field) {
  return concat(field_prefix(field), "macro.");
}
std::string axis_array(int axis) {
  return concat("axis.", axis);
}
std::string error_array(std::size_t field, std::string_view quantity) {
  return concat("error.", field, ".", quantity);
}

BrickGrid::BrickGrid(PackedFile file) : file_(std::move(file)), description_(read_description(file_)) {
  for (std::size_t field = 0; field < description_.fields.size(); ++field)
    with_element_type(description_.fields[field].type, [&](auto zero) {
      using T = decltype(zero);
      const std::uint64_t sample_count = samples<T>(field).size();
      macro_levels<T>(field);
      if (description_.layout.stored_brick_count == 0 && description_.layout.is_sparse && sample_count != 0)
        refuse(file_.name(), concat("array '", samples_array(field), "'"), concat(sample_count, " samples"), "none");
    });
  for (const auto& [field, certificate] : description_.certificates)
    with_element_type(certificate.type, [&, f = field](auto zero) {
      errors<decltype(zero)>(f, "max");
      errors<decltype(zero)>(f, "rms");
    });
  if (requires_feature(file_, axis_tables_feature))
    for (int axis = 0; axis < 3; ++axis)
      description_.axes[static_cast<std::size_t>(axis)] =
          read_axis(file_, axis, description_.layout.sample_count[axis]);
  if (description_.layout.is_sparse) {
    brick_slots_ = file_.array<std::uint32_t>("bricks", brick_shape());
    check_slots(file_, brick_slots_, description_.layout.stored_brick_count);
  }
  // Created only here: the tables are small, or no larger than the macro levels and samples whose
  // sizes have just been checked.
  tables_ = std::make_shared<const AxisTables>(description_.layout);
}

std::optional<std::size_t> BrickGrid::find_field(std::string_view name) const {
  for (std::size_t field = 0; field < description_.fields.size(); ++field)
    if (description_.fields[field].name == name) return field;
  return std::nullopt;
}

std::vector<std::uint64_t> BrickGrid::brick_shape() const {
  return shape_of(description_.layout.brick_count());
}

SparseAddress::SparseAddress(const BrickLayout& layout, const AxisTables& tables, std::span<const std::uint32_t> slots)
    : tables_(&tables),
      slots_(slots),
      shift_(3 * std::countr_zero(static_cast<std::uint64_t>(layout.brick_edge))),
      mask_((std::uint64_t{1} << shift_) - 1) {
  RHORAY_CHECK(layout.is_sparse && BrickLayout::is_sparse_edge(layout.brick_edge));
}

std::vector<ArraySpec> grid_arrays(const GridDescription& description) {
  const BrickLayout& layout = description.layout;
  std::vector<ArraySpec> arrays;
  for (int axis = 0; axis < 3; ++axis)
    if (!description.axes[static_cast<std::size_t>(axis)].empty())
      arrays.push_back({.name = axis_array(axis),
                        .type = ElementType::F64,
                        .shape = {static_cast<std::uint64_t>(layout.sample_count[axis])}});
  if (layout.is_sparse)
    arrays.push_back({.name = "bricks", .type = ElementType::U32, .shape = shape_of(layout.brick_count())});
  for (const auto& [field, certificate] : description.certificates)
    for (const char* quantity : {"max", "rms"})
      arrays.push_back(
          {.name = error_array(field, quantity), .type = certificate.type, .shape = shape_of(layout.brick_count())});
  for (std::size_t field = 0; field < description.fields.size(); ++field) {
    const ElementType type = description.fields[field].type;
    const std::vector<ArraySpec> levels = macro_arrays(description.macro, 1, type, macro_prefix(field));
    arrays.insert(arrays.end(), levels.begin(), levels.end());
    arrays.push_back({.name = samples_array(field), .type = type, .shape = layout.shape(), .alignment = 4096});
  }
  return arrays;
}

FileDescription describe(const GridDescription& description) {
  const BrickLayout& layout = description.layout;
  RHORAY_CHECK(!description.fields.empty());
  Json json{{"sample_count", details::index_json(layout.sample_count)},
            {"brick_edge", layout.brick_edge},
            {"superbrick_edge", details::index_json(layout.superbrick_edge)},
            {"world_from_grid", details::affine_json(description.world_from_grid)},
            {"length_unit", description.length_unit},
            {"field", grid_field_json(description, 0)},
            {"macro", details::macro_json(description.macro)},
            {"provenance", details::provenance_json(description.provenance)}};
  for (std::size_t field = 1; field < description.fields.size(); ++field)
    json["more_fields"].push_back(grid_field_json(description, field));
  if (description.space != Space::unknown) json["space"] = space_word(description.space);
  FileDescription file{.kind = std::string(grid_kind)};
  if (description.is_rectilinear()) file.required.emplace_back(axis_tables_feature);
  if (layout.is_sparse) {
    file.required.emplace_back(sparse_bricks_feature);
    json["stored_brick_count"] = layout.stored_brick_count;
  }
  file.minor_version = first_minor_version(description, file);
  file.details = details::dump(json);
  return file;
}

void write_axes(const GridDescription& description, PackedFileWriter& writer) {
  for (int axis = 0; axis < 3; ++axis)
    if (const std::vector<double>& table = description.axes[static_cast<std::size_t>(axis)]; !table.empty())
      writer.write_all(axis_array(axis), std::span<const double>(table));
}

}  // namespace rhoray::formats
