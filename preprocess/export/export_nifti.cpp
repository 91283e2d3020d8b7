#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export_grid.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

static_assert(std::endian::native == std::endian::little, "headers are written as memory has them");

constexpr std::size_t header_bytes = 348, first_sample = 352;

/// DT_... of nifti1.h.
std::int16_t datatype_of(ElementType type) {
  switch (type) {
    case ElementType::U8:
      return 2;
    case ElementType::I16:
      return 4;
    case ElementType::I32:
      return 8;
    case ElementType::F32:
      return 16;
    case ElementType::F64:
      return 64;
    case ElementType::I8:
      return 256;
    case ElementType::U16:
      return 512;
    case ElementType::U32:
      return 768;
    case ElementType::I64:
      return 1024;
    case ElementType::U64:
      return 1280;
  }
  return 0;
}

/// NIFTI_UNITS_... of nifti1.h; 0 for units that it does not have.
char unit_code(const std::string& unit) {
  return unit == "m" ? 1 : unit == "mm" ? 2 : unit == "um" ? 3 : 0;
}

/// Header of NIfTI-1, without extensions: the offsets are those of nifti1.h.
std::array<char, first_sample> header_of(const formats::GridDescription& grid, ElementType type) {
  std::array<char, first_sample> header{};
  const auto put = [&](std::size_t offset, auto value) { std::memcpy(header.data() + offset, &value, sizeof value); };
  const Index3& count = grid.layout.sample_count;
  const Affine map = formats::in_space(grid.world_from_grid, grid.space, formats::Space::ras);
  put(0, std::int32_t{header_bytes});
  const std::int64_t dim[] = {3, count.x, count.y, count.z, 1, 1, 1, 1};
  for (std::size_t i = 0; i < std::size(dim); ++i) put(40 + 2 * i, static_cast<std::int16_t>(dim[i]));
  put(70, datatype_of(type));
  put(72, static_cast<std::int16_t>(8 * formats::element_bytes(type)));
  const double pixdim[] = {1, map.x_axis.length(), map.y_axis.length(), map.z_axis.length()};
  for (std::size_t i = 0; i < std::size(pixdim); ++i) put(76 + 4 * i, static_cast<float>(pixdim[i]));
  put(108, static_cast<float>(first_sample));
  put(112, 1.0F);  // scl_slope
  put(123, unit_code(grid.length_unit));
  put(254, std::int16_t{2});  // sform_code: aligned
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column) {
      const Vec3 axes[] = {map.x_axis, map.y_axis, map.z_axis, map.origin};
      put(280 + 16 * row + 4 * column, static_cast<float>(axes[column][static_cast<int>(row)]));
    }
  std::memcpy(header.data() + 344, "n+1", 4);
  return header;
}

}  // namespace

ExportReport export_nifti(const std::filesystem::path& packed, const std::filesystem::path& output,
                          const ExportOptions& options, const Progress& progress) {
  const OpenedGrid opened = open_grid(packed, options.field);
  require_even_steps(opened, packed, "NIfTI");
  const formats::GridDescription& grid = opened.description();
  constexpr std::int64_t most = std::numeric_limits<std::int16_t>::max();
  for (int axis = 0; axis < 3; ++axis)
    if (grid.layout.sample_count[axis] > most)
      throw Error(ErrorCode::unsupported, concat(packed.string(), ": found ", grid.layout.sample_count[axis],
                                                 " samples along ", "xyz"[axis], "; NIfTI expects at most ", most));
  PendingFile file(output, {.replace_existing = options.replace_existing});
  ExportReport report;
  with_samples(opened, [&]<class T>(const GridSamples<T>& samples) {
    report.file_bytes = first_sample + sample_bytes(samples);
    file.reserve(report.file_bytes);
    const std::array<char, first_sample> header = header_of(grid, samples.field().type);
    file.write(0, std::as_bytes(std::span(header)));
    write_rows(samples, file, first_sample, progress);
  });
  file.publish();
  if (grid.space == formats::Space::unknown)
    report.notes.push_back("the packed file does not say its space; readers of NIfTI take it as RAS");
  return report;
}

}  // namespace rhoray::preprocess
