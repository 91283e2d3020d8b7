#include "formats/base/error.h"
#include "formats/packed_file.h"
#include "preprocess/import_mesh.h"
#include "preprocess/input_file.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/resample.h"
#include "preprocess/unpack_mesh.h"

namespace rhoray::preprocess {
namespace {

NeutralMesh read_mesh(const std::filesystem::path& input, const ResampleOptions& options) {
  if (!formats::PackedFile::looks_packed(input))
    return import_mesh(input, {.error_fields = options.fields, .memory_limit_bytes = options.memory_limit_bytes});
  const formats::PackedFile file = formats::PackedFile::open(input);
  const std::string& kind = file.description().kind;
  if (kind == "grid")
    throw Error(ErrorCode::unsupported, concat(input.string(), ": is already a packed grid; expected a mesh"));
  if (kind != "tets")
    throw Error(ErrorCode::unsupported, concat(input.string(), ": holds ", kind == "colors" ? "colours" : "a surface",
                                               "; expected a mesh of volume cells"));
  return unpack_mesh(formats::TetMesh(file));
}

}  // namespace

void check_resample(const std::filesystem::path& input) {
  require_input(input);
  if (formats::PackedFile::looks_packed(input)) return;
  const std::string name = input.string();
  switch (foreign_kind(input)) {
    case ForeignKind::mesh:
      return;
    case ForeignKind::surface:
      throw Error(ErrorCode::unsupported, concat(name, ": holds a surface; expected a mesh of volume cells"),
                  concat("fill it first: rhoray tetrahedralize ", name, " -o ", input.stem().string(), ".vtu"));
    case ForeignKind::volume:
      throw Error(ErrorCode::unsupported, concat(name, ": holds a volume, which is a grid already; expected a mesh"),
                  concat("pack it instead: rhoray pack ", name));
    case ForeignKind::unknown:
      throw Error(ErrorCode::unsupported,
                  concat(unsupported_type(input), "; expected a mesh (.vtu, .vtk, ...) or packed tetrahedra (.rho)"));
  }
}

ResampleReport resample(const std::filesystem::path& input, const std::filesystem::path& output,
                        ResampleOptions options, const Progress& progress) {
  check_resample(input);
  if (progress) progress(concat("reading ", input.string()), 0, 0);
  NeutralMesh mesh = read_mesh(input, options);
  require_not_read(output, mesh.sources);
  give_fields(mesh, options.cells_to_points);
  options.source_name = input.filename().string();
  ResampleReport report = resample(mesh, output, options, progress);
  report.notes.insert(report.notes.begin(), mesh.notes.begin(), mesh.notes.end());
  return report;
}

}  // namespace rhoray::preprocess
