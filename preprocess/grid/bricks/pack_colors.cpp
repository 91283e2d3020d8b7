#include "preprocess/pack_colors.h"

#include <algorithm>
#include <array>
#include <span>

#include "formats/base/bytes.h"
#include "formats/base/error.h"
#include "preprocess/grid/bricks/lattice_choice.h"
#include "preprocess/grid/bricks/write_samples.h"

namespace rhoray::preprocess {
namespace {

void check_colors(const NeutralVolume& colors, const std::string& source_name) {
  const int components = colors.component_count;
  if (colors.type != formats::ElementType::U8 || (components != 3 && components != 4))
    throw Error(ErrorCode::invalid, concat(source_name, ": found ", components, " components of ",
                                           formats::element_name(colors.type), "; expected 3 or 4 of U8: colours"));
  const Index3& n = colors.sample_count;
  constexpr std::int64_t largest_axis = std::int64_t{1} << 20;  // what a reader accepts
  for (const std::int64_t texels : {n.x, n.y, n.z})
    if (texels < 1 || texels > largest_axis)
      throw Error(ErrorCode::invalid, concat(source_name, ": found ", n.x, " x ", n.y, " x ", n.z,
                                             " texels; expected 1 to ", largest_axis, " on every axis"));
  const auto bytes = checked_product({static_cast<std::uint64_t>(n.x), static_cast<std::uint64_t>(n.y),
                                      static_cast<std::uint64_t>(n.z), static_cast<std::uint64_t>(components)});
  if (!bytes || *bytes != colors.samples.size())
    throw Error(ErrorCode::invalid,
                concat(source_name, ": found ", colors.samples.size(), " bytes of texels; expected ", n.x, " x ", n.y,
                       " x ", n.z, " x ", components));
  if (std::any_of(colors.axes.begin(), colors.axes.end(), [](const auto& table) { return !table.empty(); }))
    throw Error(ErrorCode::unsupported,
                concat(source_name, ": found colours with uneven spacing; expected even spacing along every axis"));
  check_frame(colors.world_from_grid, source_name);
}

/// Writes texels of N components.
template <std::size_t N>
void write_texels(const NeutralVolume& colors, const formats::BrickLayout& layout, formats::PackedFileWriter& writer,
                  ProgressMeter& meter) {
  using Texel = std::array<std::uint8_t, N>;
  static_assert(sizeof(Texel) == N);
  const std::span<const Texel> texels(reinterpret_cast<const Texel*>(colors.samples.data()), colors.samples.size() / N);
  write_samples(texels, layout, "texels", writer, meter);
}

}  // namespace

PackColorsReport pack_colors(const NeutralVolume& colors, const formats::Destination& destination,
                             const PackColorsOptions& options, const Progress& progress) {
  const std::string source_name = options.source_name.empty() ? "colours" : options.source_name;
  check_colors(colors, source_name);
  PackColorsReport report;
  formats::ColorGridDescription& grid = report.description;
  grid.layout = options.is_linear ? formats::BrickLayout::linear(colors.sample_count)
                                  : bricked_layout(colors.sample_count, options.brick_edge, options.largest_superbrick);
  grid.world_from_grid = colors.world_from_grid;
  grid.length_unit = colors.length_unit;
  grid.space = colors.space;
  grid.component_count = colors.component_count;
  grid.provenance = {.source_name = options.source_name, .source_checksum = {}, .command = options.command};
  formats::PackedFileWriter writer(destination, formats::describe(grid), formats::color_grid_arrays(grid),
                                   {.replace_existing = options.replace_existing});
  ProgressMeter writing(progress, "writing texels (bytes)", colors.samples.size());
  if (grid.has_alpha())
    write_texels<4>(colors, grid.layout, writer, writing);
  else
    write_texels<3>(colors, grid.layout, writer, writing);
  ProgressMeter sealing(progress, "sealing", 1);
  report.file_bytes = writer.commit();
  sealing.add(1);
  return report;
}

}  // namespace rhoray::preprocess
