#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <iterator>
#include <limits>

#include "formats/base/error.h"
#include "formats/base/pending_file.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export/nifti_header.h"
#include "preprocess/export_grid.h"

namespace rhoray::preprocess {
namespace {

using formats::ElementType;

static_assert(std::endian::native == std::endian::little, "headers are written as memory has them");

constexpr std::size_t first_sample = 352;

std::int16_t code_of(ElementType type) {
  const auto* const found = std::find_if(std::begin(nifti::data_types), std::end(nifti::data_types),
                                         [&](const auto& each) { return each.second == type; });
  return static_cast<std::int16_t>(found->first);
}

/// 0 for units that NIfTI does not have.
char code_of(const std::string& unit) {
  const auto* const found = std::find(std::begin(nifti::length_units), std::end(nifti::length_units), unit);
  return found == std::end(nifti::length_units) ? 0 : static_cast<char>(found - std::begin(nifti::length_units));
}

/// Header of NIfTI-1, without extensions.
std::array<char, first_sample> header_of(const formats::GridDescription& grid, ElementType type) {
  std::array<char, first_sample> header{};
  const auto put = [&](std::size_t offset, auto value) { std::memcpy(header.data() + offset, &value, sizeof value); };
  const Index3& count = grid.layout.sample_count;
  const Affine map = formats::in_space(grid.world_from_grid, grid.space, formats::Space::ras);
  put(0, std::int32_t{nifti::header_bytes});
  const std::int64_t dim[] = {3, count.x, count.y, count.z, 1, 1, 1, 1};
  for (std::size_t i = 0; i < std::size(dim); ++i) put(nifti::dim + 2 * i, static_cast<std::int16_t>(dim[i]));
  put(nifti::datatype, code_of(type));
  put(nifti::bitpix, static_cast<std::int16_t>(8 * formats::element_bytes(type)));
  const double pixdim[] = {1, map.x_axis.length(), map.y_axis.length(), map.z_axis.length()};
  for (std::size_t i = 0; i < std::size(pixdim); ++i) put(nifti::pixdim + 4 * i, static_cast<float>(pixdim[i]));
  put(nifti::vox_offset, static_cast<float>(first_sample));
  put(nifti::scl_slope, 1.0F);
  put(nifti::xyzt_units, code_of(grid.length_unit));
  put(nifti::sform_code, std::int16_t{2});  // aligned
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column) {
      const Vec3 axes[] = {map.x_axis, map.y_axis, map.z_axis, map.origin};
      put(nifti::srow + 16 * row + 4 * column, static_cast<float>(axes[column][static_cast<int>(row)]));
    }
  std::memcpy(header.data() + nifti::magic, "n+1", 4);
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
