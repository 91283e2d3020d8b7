#include <numeric>

#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export/lost_facts.h"
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

/// Indices of the fields that are written.
std::vector<std::size_t> fields_of(const OpenedGrid& opened, const std::string& asked) {
  if (!asked.empty()) return {opened.field};
  std::vector<std::size_t> all(opened.description().fields.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return all;
}

std::uint64_t bytes_of(const formats::GridDescription& grid, std::size_t field) {
  return static_cast<std::uint64_t>(volume(grid.layout.sample_count)) * formats::element_bytes(grid.fields[field].type);
}

/// Everything before the samples. Numbers read back to the same bits, which VTK's own writer does
/// not guarantee.
std::string head_of(const formats::GridDescription& grid, const std::vector<std::size_t>& fields) {
  const Index3& n = grid.layout.sample_count;
  const Affine& map = grid.world_from_grid;
  const Vec3 spacing(map.x_axis.length(), map.y_axis.length(), map.z_axis.length());
  const Vec3 x = map.x_axis / spacing.x, y = map.y_axis / spacing.y, z = map.z_axis / spacing.z;
  const std::string extent = concat("0 ", n.x - 1, " 0 ", n.y - 1, " 0 ", n.z - 1);
  std::string arrays;
  std::uint64_t offset = 0;
  for (const std::size_t f : fields) {
    arrays += concat("<DataArray type=\"", vtk_type(grid.fields[f].type), "\" Name=\"", in_xml(grid.fields[f].name),
                     "\" format=\"appended\" offset=\"", offset, "\"/>\n");
    offset += sizeof(std::uint64_t) + bytes_of(grid, f);
  }
  return concat(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<ImageData WholeExtent=\"",
      extent, "\" Origin=\"", map.origin.x, " ", map.origin.y, " ", map.origin.z, "\" Spacing=\"", spacing.x, " ",
      spacing.y, " ", spacing.z, "\" Direction=\"", x.x, " ", y.x, " ", z.x, " ", x.y, " ", y.y, " ", z.y, " ", x.z,
      " ", y.z, " ", z.z, "\">\n<Piece Extent=\"", extent, "\">\n<PointData Scalars=\"",
      in_xml(grid.fields[fields.front()].name), "\">\n", arrays,
      "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_");
}

}  // namespace

ExportReport export_vti(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options, const Progress& progress) {
  OpenedGrid opened = open_grid(packed, options.field, options.source_name);
  require_even_steps(opened, ".vti");
  const std::vector<std::size_t> fields = fields_of(opened, options.field);
  PendingFile file(output, {.replace_existing = options.replace_existing});
  const std::string head = head_of(opened.description(), fields);
  constexpr std::string_view tail = "\n</AppendedData>\n</VTKFile>\n";
  ExportReport report;
  note_lost_facts(opened, options.field, vti_facts, report.notes);
  report.file_bytes = head.size() + tail.size();
  for (const std::size_t f : fields) report.file_bytes += sizeof(std::uint64_t) + bytes_of(opened.description(), f);
  file.reserve(report.file_bytes);
  file.write(0, std::as_bytes(std::span(head)));
  std::uint64_t at = head.size();
  for (const std::size_t f : fields) {
    opened.field = f;
    const std::uint64_t bytes = bytes_of(opened.description(), f);
    file.write(at, std::as_bytes(std::span(&bytes, 1)));
    at += sizeof bytes;
    with_samples(opened, [&]<class T>(const GridSamples<T>& samples) { write_rows(samples, file, at, progress); });
    at += bytes;
  }
  file.write(at, std::as_bytes(std::span(tail)));
  file.publish();
  return report;
}

}  // namespace rhoray::preprocess
