#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export/lost_facts.h"
#include "preprocess/export_grid.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

/// "<f4" and so on; bytes have no byte order.
std::string descr_of(ElementType type) {
  const std::string_view name = formats::element_name(type);  // "F32"
  const std::size_t bytes = formats::element_bytes(type);
  return concat(bytes == 1 ? "|" : "<", std::string(1, static_cast<char>(name[0] - 'A' + 'a')), bytes);
}

/// The magic and the dictionary, padded so that the samples begin at a multiple of 64.
std::string header_of(ElementType type, const Index3& count) {
  std::string dictionary = concat("{'descr': '", descr_of(type), "', 'fortran_order': False, 'shape': (", count.z, ", ",
                                  count.y, ", ", count.x, "), }");
  constexpr std::size_t before = 10, unit = 64;
  const std::size_t filled = before + dictionary.size() + 1;
  dictionary.append((unit - filled % unit) % unit, ' ');
  dictionary += '\n';
  const auto size = static_cast<unsigned>(dictionary.size());
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(size & 0xff);
  header += static_cast<char>(size >> 8);
  return header + dictionary;
}

/// Says where the samples are.
std::string geometry_note(const formats::GridDescription& grid) {
  if (grid.is_rectilinear())
    return "a .npy file stores no geometry; the positions are arrays axis.0 to axis.2 of the packed file";
  const Affine& map = grid.world_from_grid;
  const auto text = [](const Vec3& v) { return concat("(", v.x, ", ", v.y, ", ", v.z, ")"); };
  return concat("a .npy file stores no geometry; sample [k, j, i] is at ", text(map.origin), " + i ", text(map.x_axis),
                " + j ", text(map.y_axis), " + k ", text(map.z_axis));
}

}  // namespace

ExportReport export_npy(const std::filesystem::path& packed, const std::filesystem::path& output,
                        const ExportOptions& options, const Progress& progress) {
  const OpenedGrid opened = open_grid(packed, options.field, options.source_name);
  PendingFile file(output, {.replace_existing = options.replace_existing});
  ExportReport report;
  with_samples(opened, [&]<class T>(const GridSamples<T>& samples) {
    const std::string header = header_of(samples.field().type, samples.sample_count());
    report.file_bytes = header.size() + sample_bytes(samples);
    file.reserve(report.file_bytes);
    file.write(0, std::as_bytes(std::span(header)));
    write_rows(samples, file, header.size(), progress);
  });
  file.publish();
  report.notes.push_back(geometry_note(opened.description()));
  note_lost_facts(opened, options.field, npy_facts, report.notes);
  return report;
}

}  // namespace rhoray::preprocess
