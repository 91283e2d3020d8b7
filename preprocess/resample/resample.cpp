#include "preprocess/resample.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/trouble.h"
#include "preprocess/inspect/has_data.h"
#include "preprocess/resample/write_grid.h"

namespace rhoray::preprocess {
namespace {

std::uint64_t memory_limit(const ResampleOptions& options) {
  if (options.memory_limit_bytes != 0) return options.memory_limit_bytes;
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return std::uint64_t{4} << 30;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes) / 2;
}

/// Bytes of samples and of the arrays that go with bricks, when this share of the bricks is touched.
double bytes_of(const SampleLattice& lattice, const std::vector<PointField>& fields, double touched_share) {
  double sample_bytes = 0;
  for (const PointField& field : fields)
    std::visit([&]<class T>(const Array<T>&) { sample_bytes += sizeof(T); }, field.values);
  const auto bricks = static_cast<double>(volume(lattice.brick_count()));
  const double of_all_bricks = 8 + 4 + 4 + static_cast<double>(fields.size()) * 8 * (sizeof(float) * 2 + 1);
  const double of_touched = static_cast<double>(SampleLattice::brick_samples) * sample_bytes + 64;
  return bricks * (of_all_bricks + touched_share * of_touched);
}

std::string size_text(const Index3& count) {
  return concat(count.x, " x ", count.y, " x ", count.z, " samples");
}
std::string mebibytes(double bytes) {
  return concat(static_cast<std::uint64_t>(std::ceil(bytes / (1 << 20))), " MiB");
}

/// Everything about a mesh that does not depend on the lattice, and the lattices that are tried on it.
class Resampling {
 public:
  Resampling(const NeutralMesh& mesh, const ResampleOptions& options, const Progress& progress)
      : options_(options),
        progress_(progress),
        source_name_(options.source_name.empty() ? "mesh" : options.source_name),
        limit_(memory_limit(options)) {
    ProgressMeter inspecting(progress, "inspecting the mesh", 3);
    mesh_ = clean_mesh(mesh, source_name_);
    report_.notes = mesh_.notes;
    inspecting.add(1);
    fields_ = choose_fields(mesh, mesh_, options.fields, options.cells_to_points, source_name_, report_.notes);
    inspecting.add(1);
    neighbors_ = match_faces(mesh_.points, mesh_.cells);
    inspecting.add(1);
  }

  ResampleReport write(const std::string& length_unit, const std::filesystem::path& path) {
    const ResampledMesh grid = options_.max_error ? refined() : tried(choose_samples(mesh_.box, options_.lattice));
    write_grid(grid, mesh_, fields_, length_unit, path, options_, progress_, report_);
    fill_report(grid);
    return std::move(report_);
  }

 private:
  ResampledMesh tried(SampleLattice lattice) {
    ResampledMesh grid;
    grid.lattice = std::move(lattice);
    require_memory(bytes_of(grid.lattice, fields_, 0), grid.lattice);
    grid.touched = find_touched_bricks(mesh_, grid.lattice, progress_);
    touched_share_ = static_cast<double>(grid.touched.bricks.size()) / static_cast<double>(grid.touched.slots.size());
    require_memory(bytes_of(grid.lattice, fields_, touched_share_), grid.lattice);
    grid.samples = sample_fields(mesh_, fields_, grid.lattice, grid.touched, progress_);
    grid.certificates = certify(mesh_, fields_, neighbors_, grid.lattice, grid.touched, grid.samples, progress_);
    return grid;
  }

  void require_memory(double bytes, const SampleLattice& lattice) const {
    if (bytes <= static_cast<double>(limit_)) return;
    const std::string needs = concat(size_text(lattice.count), " need ", mebibytes(bytes), "; allowed are ",
                                     mebibytes(static_cast<double>(limit_)));
    if (report_.attempts.empty())
      throw Error(Trouble::resource, concat(source_name_, ": ", needs), "take fewer samples, or allow more memory");
    const ResampleReport::Attempt& best = report_.attempts.back();
    throw Error(Trouble::resource,
                concat(source_name_, ": the error is ", best.max_error, " with ", size_text(best.sample_count), " and ",
                       wanted_error(), " is wanted; ", needs),
                "take that many samples, a larger error, or allow more memory");
  }

  /// In the first field's unit.
  double wanted_error() const {
    if (!options_.max_error_is_share) return *options_.max_error;
    Interval<double> range;
    std::visit(
        [&](const auto& values) {
          for (const auto value : values)
            if (has_data(value)) range.include(static_cast<double>(value));
        },
        fields_.front().values);
    return range.is_empty() ? 0 : *options_.max_error * (range.hi - range.lo);
  }

  /// About one sample for each tetrahedron to start with, but eight on the longest axis.
  LatticeWish first_wish() const {
    if (options_.lattice.is_given()) return options_.lattice;
    const Vec3 extent = mesh_.box.max - mesh_.box.min;
    const double longest = std::max({extent.x, extent.y, extent.z});
    const double edge = std::cbrt(extent.x) * std::cbrt(extent.y) * std::cbrt(extent.z) /
                        std::cbrt(static_cast<double>(mesh_.cells.size()));
    const double samples = std::clamp(std::round(longest / edge) + 1, 8.0, 512.0);
    return {.longest_axis = static_cast<std::int64_t>(samples)};
  }

  /// Steps become shorter, at most by half and at least by a tenth each time: by as much as the order of the last two
  /// errors says is enough. From a mesh's piecewise linear field that order is at most 2 where the steps are longer
  /// than the mesh's edges, and 1 where they are shorter.
  ResampledMesh refined() {
    const double wanted = wanted_error();
    if (!(std::isfinite(wanted) && *options_.max_error > 0))
      throw Error(Trouble::usage, concat("largest error: found ", *options_.max_error, "; expected a number above 0"));
    SampleLattice lattice = choose_samples(mesh_.box, first_wish());
    double last_error = 0, last_spacing = 0;
    for (;;) {
      ResampledMesh grid = tried(lattice);
      const double error = grid.certificates.fields.front().max_error, spacing = lattice.spacing.x;
      report_.attempts.push_back({lattice.count, error});
      if (error <= wanted) return grid;
      double order = 1;
      if (last_error > error)
        order = std::clamp(std::log(last_error / error) / std::log(last_spacing / spacing), 0.5, 2.0);
      const double shorter = std::clamp(std::pow(0.95 * wanted / error, 1 / order), 0.5, 0.9);
      last_error = error;
      last_spacing = spacing;
      lattice = finer(lattice, shorter);
    }
  }

  SampleLattice finer(const SampleLattice& lattice, double shorter) const {
    if (options_.lattice.spacing != Vec3(0, 0, 0))
      return choose_samples(mesh_.box, {.spacing = lattice.spacing * shorter});
    Index3 count;
    for (int a = 0; a < 3; ++a)
      count[a] = static_cast<std::int64_t>(std::ceil(static_cast<double>(lattice.count[a] - 1) / shorter)) + 1;
    return choose_samples(mesh_.box, {.sample_count = count});
  }

  void fill_report(const ResampledMesh& grid) {
    report_.inside_count = grid.samples.inside_count;
    report_.outside_count = static_cast<std::uint64_t>(volume(grid.lattice.count)) - report_.inside_count;
    report_.overlap_count = grid.samples.overlap_count;
    report_.uncovered_share = grid.certificates.uncovered_share;
    for (std::size_t f = 0; f < fields_.size(); ++f) {
      const FieldErrors& errors = grid.certificates.fields[f];
      const formats::Certificate& kept = report_.description.certificates.at(f);
      report_.errors.push_back({.name = fields_[f].name,
                                .max_error = kept.max_error,
                                .attained = errors.attained,
                                .attained_at = kept.max_at,
                                .rms_error = kept.rms_error,
                                .point_count = kept.point_count});
    }
    if (report_.overlap_count > 0)
      report_.notes.push_back(concat(report_.overlap_count,
                                     report_.overlap_count == 1 ? " sample lies" : " samples lie",
                                     " in several cells that overlap: the first one counts"));
    if (report_.inside_count == 0) report_.notes.push_back("no sample lies in the mesh: it is thinner than the steps");
  }

  const ResampleOptions& options_;
  const Progress& progress_;
  std::string source_name_;
  std::uint64_t limit_;
  double touched_share_ = 1;
  CleanMesh mesh_;
  std::vector<PointField> fields_;
  FaceNeighbors neighbors_;
  ResampleReport report_;
};

}  // namespace

ResampleReport resample(const NeutralMesh& mesh, const std::filesystem::path& path, const ResampleOptions& options,
                        const Progress& progress) {
  if (!options.lattice.is_given() && !options.max_error)
    throw Error(Trouble::usage, "found neither a number of samples, nor a spacing, nor a largest error; expected one");
  return Resampling(mesh, options, progress).write(mesh.length_unit, path);
}

}  // namespace rhoray::preprocess
