#include "tools/analysis/data_forms.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "formats/base/number_text.h"
#include "formats/tet_mesh.h"
#include "preprocess/export_grid.h"
#include "preprocess/open_vdb.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_volume.h"
#include "preprocess/resample.h"
#include "preprocess/unpack_mesh.h"
#include "tools/analysis/measure.h"

namespace rhoray::tools {

namespace {

/// Calls act(values) for every row of samples, x first.
template <class Act>
void for_each_row(const formats::BrickGrid& grid, std::size_t field, const FormOptions& options, Act&& act) {
  const Index3 count = grid.description().layout.sample_count;
  formats::with_element_type(grid.description().fields[field].type, [&]<class T>(T) {
    const std::span<const T> samples = grid.samples<T>(field);
    std::vector<double> row(static_cast<std::size_t>(count.x));
    for (Index3 at(0, 0, 0); at.z < count.z; ++at.z) {
      if (options.progress)
        options.progress("copying", static_cast<std::uint64_t>(at.z), static_cast<std::uint64_t>(count.z));
      for (at.y = 0; at.y < count.y; ++at.y) {
        for (at.x = 0; at.x < count.x; ++at.x)
          row[static_cast<std::size_t>(at.x)] = static_cast<double>(samples[grid.tables().address(at.x, at.y, at.z)]);
        act(row);
      }
    }
  });
}

/// Number of bits of a field's integers; 64 for other numbers.
int whole_bits(formats::ElementType type) {
  const bool is_whole = type != formats::ElementType::F32 && type != formats::ElementType::F64;
  return is_whole ? 8 * static_cast<int>(formats::element_bytes(type)) : 64;
}

template <class T>
preprocess::NeutralVolume quantized(const formats::BrickGrid& grid, std::size_t field, const FormedData& map,
                                    const FormOptions& options) {
  const formats::GridDescription& description = grid.description();
  preprocess::NeutralVolume copy;
  copy.sample_count = description.layout.sample_count;
  copy.type = formats::element_type_of<T>();
  copy.world_from_grid = description.world_from_grid;
  copy.axes = description.axes;
  copy.length_unit = description.length_unit;
  copy.space = description.space;
  copy.field_name = description.fields[field].name;
  copy.owned_samples.resize(static_cast<std::size_t>(volume(copy.sample_count)) * sizeof(T));
  std::byte* out = copy.owned_samples.data();
  for_each_row(grid, field, options, [&](const std::vector<double>& row) {
    for (const double value : row) {
      const T whole = static_cast<T>(std::lround(map.own(value)));
      std::memcpy(out, &whole, sizeof whole);
      out += sizeof whole;
    }
  });
  copy.samples = copy.owned_samples;
  return copy;
}

std::uint64_t memory_limit(const FormOptions& options) {
  return options.memory_limit_bytes != 0 ? options.memory_limit_bytes : this_machine().memory_bytes / 2;
}

void require_grid(const render::Dataset& dataset) {
  if (dataset.file().description().kind != "grid")
    throw Error(ErrorCode::unsupported, "an OpenVDB file; only packed grids are copied with fewer bits");
}

}  // namespace

const FormedData& DataForms::get(const DataForm& form, const FormOptions& options) {
  const std::string name = text_of(form);
  if (const auto refusal = refused_.find(name); refusal != refused_.end()) throw refusal->second;
  auto found = made_.find(name);
  if (found == made_.end()) try {
      found = made_.emplace(name, make(form, options)).first;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::interrupted) refused_.emplace(name, error);
      throw;
    }
  return found->second;
}

FormedData DataForms::make(const DataForm& form, const FormOptions& options) {
  switch (form.kind) {
    case DataForm::Kind::quantized:
      return dataset_.is_mesh() ? quantize_mesh(form.size, options) : quantize_grid(form.size, options);
    case DataForm::Kind::resampled:
    case DataForm::Kind::resampled_vdb:
      return resample(form, options);
    case DataForm::Kind::original:
      break;
  }
  return {.dataset = dataset_, .file_bytes = dataset_.file().file_bytes()};
}

FormedData DataForms::quantize_grid(int bits, const FormOptions& options) const {
  require_grid(dataset_);
  const formats::BrickGrid grid(dataset_.file());
  const formats::FieldSummary& field = dataset_.field();
  const std::size_t position = grid.find_field(field.name).value();
  if (grid.description().layout.is_sparse || field.no_data_count > 0)
    throw Error(ErrorCode::unsupported, "samples without data, which integers cannot store");
  if (whole_bits(field.type) <= bits)
    throw Error(ErrorCode::unsupported, concat("the data are already integers of ", whole_bits(field.type), " bits"));
  const std::uint64_t needed = 4 * static_cast<std::uint64_t>(volume(grid.description().layout.sample_count)) *
                               static_cast<std::uint64_t>(bits / 8);
  if (needed > memory_limit(options))
    throw Error(ErrorCode::resource, concat("a copy takes ", bytes_text(needed), " of memory; the limit is ",
                                            bytes_text(memory_limit(options))));
  const Stopwatch watch;
  const double width = field.range.hi - field.range.lo;
  FormedData made{
      .dataset = dataset_, .scale = width > 0 ? (std::exp2(bits) - 1) / width : 1, .offset = field.range.lo};
  const preprocess::NeutralVolume copy = bits == 8 ? quantized<std::uint8_t>(grid, position, made, options)
                                                   : quantized<std::uint16_t>(grid, position, made, options);
  const std::filesystem::path path = options.folder / concat("bits", bits, ".rho");
  preprocess::pack_volume(copy, path, {.replace_existing = true}, options.progress);
  made.dataset = render::Dataset::load(path, {}, dataset_.space());
  made.preprocess_s = watch.seconds();
  made.file_bytes = made.dataset.file().file_bytes();
  return made;
}

/// Estimate before the time is spent: four times the last one for twice the size.
double DataForms::foreseen_s(const DataForm& form) const {
  if (last_.size == 0) return 0;
  const double growth = static_cast<double>(form.size) / static_cast<double>(last_.size);
  return last_s_ * std::max(1.0, growth * growth);
}

const preprocess::NeutralMesh& DataForms::mesh() {
  if (!mesh_)
    mesh_ = std::make_unique<preprocess::NeutralMesh>(preprocess::unpack_mesh(formats::TetMesh(dataset_.file())));
  return *mesh_;
}

/// Packed meshes contain floating-point numbers. So the steps are those of the copy, but the size
/// is that of the data.
FormedData DataForms::quantize_mesh(int bits, const FormOptions& options) {
  const formats::FieldSummary& field = dataset_.field();
  const preprocess::NeutralMesh& whole = mesh();
  const Stopwatch watch;
  const double steps = std::exp2(bits) - 1, width = field.range.hi - field.range.lo;
  FormedData made{.dataset = dataset_, .scale = width > 0 ? steps / width : 1, .offset = field.range.lo};
  preprocess::NeutralMesh copy;
  copy.points = whole.points;
  copy.cells = whole.cells;
  copy.length_unit = whole.length_unit;
  for (const preprocess::NeutralField& values : whole.point_fields)
    if (values.name == field.name) copy.point_fields.push_back(values);
  RHORAY_CHECK(copy.point_fields.size() == 1);
  // NaN stays
  for (double& value : copy.point_fields[0].values) value = std::round(made.own(value));
  const std::filesystem::path path = options.folder / concat("bits", bits, ".rho");
  preprocess::pack_mesh(copy, path, {.replace_existing = true}, options.progress);
  made.dataset = render::Dataset::load(path, {}, dataset_.space());
  made.preprocess_s = watch.seconds();
  made.file_bytes = made.dataset.file().file_bytes();
  return made;
}

FormedData DataForms::resample(const DataForm& form, const FormOptions& options) {
  const std::filesystem::path grid = options.folder / concat("grid", form.size, ".rho");
  const bool is_vdb = form.kind == DataForm::Kind::resampled_vdb;
  // OpenVDB has the same samples; only the file is written anew.
  const auto sampled = made_.find(text_of(DataForm{DataForm::Kind::resampled, form.size}));
  double sampling_s = sampled == made_.end() ? 0 : sampled->second.preprocess_s;
  if (!is_vdb || sampled == made_.end()) {
    if (options.seconds > 0 && foreseen_s(form) > options.seconds)
      throw Error(ErrorCode::resource, concat("would take about ", rounded(foreseen_s(form), 2), " s to make"));
    const preprocess::NeutralMesh& whole = mesh();
    const Stopwatch watch;
    preprocess::resample(whole, grid,
                         {.fields = {dataset_.field().name},
                          .lattice = {.longest_axis = form.size},
                          .memory_limit_bytes = memory_limit(options),
                          .replace_existing = true},
                         options.progress);
    sampling_s = watch.seconds();
    last_ = form;
    last_s_ = sampling_s;
  }
  const Stopwatch watch;
  std::filesystem::path path = grid;
  if (is_vdb) preprocess::export_vdb(grid, path.replace_extension(".vdb"), {.replace_existing = true});
  FormedData made{.dataset = is_vdb ? render::Dataset::load(preprocess::open_vdb(path, {}))
                                    : render::Dataset::load(path, {}, dataset_.space()),
                  .file_bytes = std::filesystem::file_size(path)};
  made.preprocess_s = sampling_s + watch.seconds();
  // An OpenVDB file contains the same samples as the grid.
  made.border = std::make_shared<const ResampledBorder>(dataset_, render::Dataset::load(grid));
  return made;
}

}  // namespace rhoray::tools
