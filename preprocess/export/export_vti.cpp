#include <cmath>

#include "formats/base/pending_file.h"
#include "formats/base/trouble.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export_grid.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

std::string vtk_type(ElementType type) {
  const std::string_view name = formats::element_name(type);  // "U8", "F32"
  const std::string bits(name.substr(1));
  switch (name[0]) {
    case 'U':
      return "UInt" + bits;
    case 'I':
      return "Int" + bits;
    default:
      return "Float" + bits;
  }
}

std::string in_xml(std::string_view text) {
  std::string out;
  for (const char letter : text) {
    if (letter == '&')
      out += "&amp;";
    else if (letter == '<')
      out += "&lt;";
    else if (letter == '"')
      out += "&quot;";
    else
      out += static_cast<unsigned char>(letter) < 0x20 ? ' ' : letter;
  }
  return out;
}

/// Everything before the samples. Numbers read back to the same bits, which VTK's own writer does not promise.
std::string head_of(const formats::GridDescription& grid) {
  const Index3& n = grid.layout.sample_count;
  const Affine& map = grid.world_from_grid;
  const Vec3 spacing(map.x_axis.length(), map.y_axis.length(), map.z_axis.length());
  const Vec3 x = map.x_axis / spacing.x, y = map.y_axis / spacing.y, z = map.z_axis / spacing.z;
  const std::string extent = concat("0 ", n.x - 1, " 0 ", n.y - 1, " 0 ", n.z - 1);
  const std::string name = in_xml(grid.field.name);
  return concat(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<ImageData WholeExtent=\"",
      extent, "\" Origin=\"", map.origin.x, " ", map.origin.y, " ", map.origin.z, "\" Spacing=\"", spacing.x, " ",
      spacing.y, " ", spacing.z, "\" Direction=\"", x.x, " ", y.x, " ", z.x, " ", x.y, " ", y.y, " ", z.y, " ", x.z,
      " ", y.z, " ", z.z, "\">\n<Piece Extent=\"", extent, "\">\n<PointData Scalars=\"", name,
      "\">\n<DataArray type=\"", vtk_type(grid.field.type), "\" Name=\"", name,
      "\" format=\"appended\" offset=\"0\"/>\n</PointData>\n</Piece>\n</ImageData>\n<AppendedData "
      "encoding=\"raw\">\n_");
}

std::vector<std::string> notes_on(const formats::GridDescription& grid) {
  std::vector<std::string> notes;
  const auto lost = [&](const std::string& unit, const std::string& of) {
    if (!unit.empty()) notes.push_back(concat("the unit ", unit, " of ", of, " has no place in the file"));
  };
  lost(grid.length_unit, "lengths");
  lost(grid.field.unit, concat("field '", grid.field.name, "'"));
  return notes;
}

}  // namespace

ExportReport export_vti(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options, const Progress& progress) {
  const formats::BrickGrid grid = open_grid(packed, options.field);
  PendingFile file(output, {.replace_existing = options.replace_existing});
  ExportReport report;
  with_samples(grid, [&]<class T>(const GridSamples<T>& samples) {
    const std::string head = head_of(grid.description());
    constexpr std::string_view tail = "\n</AppendedData>\n</VTKFile>\n";
    const std::uint64_t bytes = sample_bytes(samples), first = head.size() + sizeof bytes;
    report.file_bytes = first + bytes + tail.size();
    file.reserve(report.file_bytes);
    file.write(0, std::as_bytes(std::span(head)));
    file.write(head.size(), std::as_bytes(std::span(&bytes, 1)));
    write_rows(samples, file, first, progress);
    file.write(first + bytes, std::as_bytes(std::span(tail)));
  });
  file.publish();
  report.notes = notes_on(grid.description());
  return report;
}

}  // namespace rhoray::preprocess
