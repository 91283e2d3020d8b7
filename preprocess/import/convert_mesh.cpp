#include <algorithm>

#include "formats/base/error.h"
#include "formats/base/nearest_name.h"
#include "preprocess/import_mesh.h"
#include "preprocess/source_file.h"

namespace rhoray::preprocess {
namespace {

/// The cell field that tells where a tetrahedron comes from.
constexpr const char* source_cell = "source_cell";

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Keeps the named fields, in the file's order, and reports the others.
void keep_fields(NeutralMesh& mesh, const std::vector<std::string>& kept, const std::filesystem::path& input) {
  if (kept.empty()) return;
  std::vector<std::string> names;
  for (const auto* fields : {&mesh.point_fields, &mesh.cell_fields})
    for (const NeutralField& field : *fields) names.push_back(field.name);
  for (const std::string& name : kept)
    if (!contains(names, name))
      throw Error(ErrorCode::usage, concat(input.string(), ": no field \"", name, "\""), did_you_mean(name, names));
  std::string left_out;
  for (auto* fields : {&mesh.point_fields, &mesh.cell_fields})
    std::erase_if(*fields, [&](const NeutralField& field) {
      if (contains(kept, field.name)) return false;
      left_out += concat(left_out.empty() ? "" : ", ", "\"", field.name, "\"");
      return true;
    });
  if (!left_out.empty()) mesh.notes.push_back(concat("fields that --field does not name are left out: ", left_out));
}

void add_source_cells(NeutralMesh& mesh) {
  const auto is_named_so = [](const NeutralField& field) { return field.name == source_cell; };
  if (mesh.cell_ids.empty() || std::any_of(mesh.cell_fields.begin(), mesh.cell_fields.end(), is_named_so)) return;
  NeutralField field;
  field.name = source_cell;
  field.was_single_precision = false;
  field.values.assign(mesh.cell_ids.begin(), mesh.cell_ids.end());
  mesh.cell_fields.push_back(std::move(field));
}

}  // namespace

NeutralMesh convert_mesh(const std::filesystem::path& input, const std::filesystem::path& output,
                         const ConvertMeshOptions& options) {
  ImportMeshOptions import = options.import;
  import.error_fields = options.fields;
  const auto show = [&](const std::string& phase) {
    if (import.progress) import.progress(phase, 0, 0);
  };
  show(concat("reading ", input.string()));
  NeutralMesh mesh = import_mesh(input, import);
  require_not_read(output, mesh.sources);
  keep_fields(mesh, options.fields, input);
  add_source_cells(mesh);
  show(concat("writing ", output.string()));
  export_mesh(mesh, output, options.replace_existing);
  return mesh;
}

}  // namespace rhoray::preprocess
