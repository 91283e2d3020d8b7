#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/base/pending_file.h"
#include "preprocess/export/grid_samples.h"
#include "preprocess/export/lost_facts.h"
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

/// The map from samples to RAS, before and after it is rounded to the header's single precision.
struct HeaderMap {
  Affine exact, rounded;
};

[[noreturn]] void refuse_map(const std::string& name, const std::string& found) {
  throw Error(ErrorCode::unsupported, concat(name, ": ", found), "a .vti file stores the geometry in double precision");
}

/// Not inlined: where two adjacent doubles are rounded so, GCC 12 leaves the rounding out (SLP
/// vectorizer, from -O2 on).
[[gnu::noinline]] double in_single_precision(double x) {
  return static_cast<double>(static_cast<float>(x));
}

/// A vector as the header stores it.
Vec3 rounded_vector(const OpenedGrid& opened, const Vec3& vector) {
  constexpr double largest = std::numeric_limits<float>::max();
  if (!(vector.length() <= largest))  // also of the spacing, which the header stores
    refuse_map(opened.name(), concat("found a vector of length ", rounded(vector.length()),
                                     " in the geometry; NIfTI stores at most ", rounded(largest)));
  return {in_single_precision(vector.x), in_single_precision(vector.y), in_single_precision(vector.z)};
}

/// Refuses a map that no reader could use.
HeaderMap header_map(const OpenedGrid& opened) {
  const formats::GridDescription& grid = opened.description();
  HeaderMap map{.exact = formats::in_space(grid.world_from_grid, grid.space, formats::Space::ras), .rounded = {}};
  const auto kept_vector = [&](const Vec3& vector) { return rounded_vector(opened, vector); };
  map.rounded = {kept_vector(map.exact.x_axis), kept_vector(map.exact.y_axis), kept_vector(map.exact.z_axis),
                 kept_vector(map.exact.origin)};
  const Affine& kept = map.rounded;
  // the limit of all readers of volumes (import/reading/samples.cpp); written so that 0 is refused
  if (!(std::abs(kept.determinant()) > 1e-9 * kept.x_axis.length() * kept.y_axis.length() * kept.z_axis.length()))
    refuse_map(opened.name(), "the axes span no volume in the single precision of NIfTI");
  return map;
}

/// How far rounding moves a corner of the grid at most, in steps along an axis.
double largest_move(const HeaderMap& map, const Index3& sample_count) {
  const Affine &to = map.rounded, &from = map.exact;
  const Affine moves{to.x_axis - from.x_axis, to.y_axis - from.y_axis, to.z_axis - from.z_axis,
                     to.origin - from.origin};
  const Affine steps = from.inverse();
  const Vec3 last = Vec3(sample_count) - Vec3(1, 1, 1);
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 at(corner & 1 ? last.x : 0, corner & 2 ? last.y : 0, corner & 4 ? last.z : 0);
    const Vec3 move = steps.vector(moves.point(at));
    largest = std::max({largest, std::abs(move.x), std::abs(move.y), std::abs(move.z)});
  }
  return largest;
}

/// Header of NIfTI-1, without extensions.
std::array<char, first_sample> header_of(const formats::GridDescription& grid, const Affine& map, ElementType type) {
  std::array<char, first_sample> header{};
  const auto put = [&](std::size_t offset, auto value) { std::memcpy(header.data() + offset, &value, sizeof value); };
  const Index3& count = grid.layout.sample_count;
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
  const OpenedGrid opened = open_grid(packed, options.field, options.source_name);
  require_even_steps(opened, "NIfTI");
  const formats::GridDescription& grid = opened.description();
  constexpr std::int64_t most = std::numeric_limits<std::int16_t>::max();
  for (int axis = 0; axis < 3; ++axis)
    if (grid.layout.sample_count[axis] > most)
      throw Error(ErrorCode::unsupported, concat(opened.name(), ": found ", grid.layout.sample_count[axis],
                                                 " samples along ", "xyz"[axis], "; NIfTI expects at most ", most));
  const HeaderMap map = header_map(opened);
  PendingFile file(output, {.replace_existing = options.replace_existing});
  ExportReport report;
  with_samples(opened, [&]<class T>(const GridSamples<T>& samples) {
    report.file_bytes = first_sample + sample_bytes(samples);
    file.reserve(report.file_bytes);
    const std::array<char, first_sample> header = header_of(grid, map.rounded, samples.field().type);
    file.write(0, std::as_bytes(std::span(header)));
    write_rows(samples, file, first_sample, progress);
  });
  file.publish();
  if (grid.space == formats::Space::unknown)
    report.notes.push_back("the packed file does not say its space; readers of NIfTI take it as RAS");
  constexpr double noted_move = 1e-3;
  if (const double move = largest_move(map, grid.layout.sample_count); move > noted_move)
    report.notes.push_back(concat("single precision moves the grid by up to ", rounded(move),
                                  " of a step; a .vti file stores the geometry in double precision"));
  StoredFacts stored = nii_facts;
  stored.length_unit = code_of(grid.length_unit) != 0;
  note_lost_facts(opened, options.field, stored, report.notes);
  return report;
}

}  // namespace rhoray::preprocess
