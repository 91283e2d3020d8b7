#include "preprocess/resample.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/floating_point.h"
#include "preprocess/grid/resample/extend.h"
#include "preprocess/grid/resample/write_grid.h"
#include "preprocess/values/has_data.h"

namespace rhoray::preprocess {
namespace {

std::uint64_t memory_limit(const ResampleOptions& options) {
  if (options.memory_limit_bytes != 0) return options.memory_limit_bytes;
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return std::uint64_t{4} << 30;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes) / 2;
}

/// Bytes of samples and of the arrays that go with bricks, when this fraction of the bricks is
/// touched.
double bytes_of(const SampleLattice& lattice, const std::vector<ScalarField>& fields, double touched_share) {
  double sample_bytes = 0;
  for (const ScalarField& field : fields)
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

/// All data of a mesh that do not depend on the lattice, and the lattices that are tried on it.
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
    fields_ =
        choose_fields(mesh, mesh_, options.fields, options.cells_to_points, source_name_, report_.notes).of_points;
    for (const ScalarField& field : fields_)
      note_no_data(field.name, no_data_count(field), "give the grid no values", report_.notes);
    inspecting.add(1);
    neighbors_ = match_faces(mesh_.points, mesh_.cells);
    inspecting.add(1);
  }

  ResampleReport write(const std::string& length_unit, const std::filesystem::path& path) {
    if (options_.max_error) report_.requested_error = requested_error();
    const ResampledMesh grid = options_.max_error ? refined() : sampled(placed(first_lattice()));
    write_grid(grid, mesh_, fields_, length_unit, report_.requested_error, path, options_, progress_, report_);
    fill_report(grid);
    return std::move(report_);
  }

 private:
  /// Returns a grid without samples, with the bricks that will hold them. Throws
  /// ErrorCode::resource where they do not fit.
  ResampledMesh placed(SampleLattice lattice) const {
    ResampledMesh grid;
    grid.lattice = std::move(lattice);
    require_memory(bytes_of(grid.lattice, fields_, 0), grid.lattice);
    grid.touched = find_touched_bricks(mesh_, grid.lattice, progress_);
    const double touched_share =
        static_cast<double>(grid.touched.bricks.size()) / static_cast<double>(grid.touched.slots.size());
    require_memory(bytes_of(grid.lattice, fields_, touched_share), grid.lattice);
    return grid;
  }

  ResampledMesh sampled(ResampledMesh grid) const {
    grid.samples = sample_fields(mesh_, fields_, grid.lattice, grid.touched, progress_);
    const std::vector<Point> steps = points_in_steps(mesh_, grid.lattice);
    std::vector<FieldView> views;
    for (std::size_t f = 0; f < fields_.size(); ++f)
      views.push_back(view_of(mesh_, fields_[f], steps, grid.lattice, grid.samples.conflicts[f]));
    extend_samples(mesh_, views, steps, grid.lattice, grid.touched, grid.samples, progress_);
    grid.certificates = certify(mesh_, views, steps, neighbors_, grid.lattice, grid.touched, grid.samples, progress_);
    return grid;
  }

  void require_memory(double bytes, const SampleLattice& lattice) const {
    if (bytes > static_cast<double>(limit_))
      throw Error(ErrorCode::resource,
                  concat(source_name_, ": ", size_text(lattice.count), " need ", mebibytes(bytes), "; allowed are ",
                         mebibytes(static_cast<double>(limit_))),
                  "use fewer samples, or allow more memory");
  }

  /// In the first field's unit. A fraction of the range of a field that hardly varies is raised to
  /// the largest rounding error in single precision (2^-20 of the largest value: sixteen units in
  /// its last place), which no grid reduces.
  double requested_error() const {
    if (!(std::isfinite(*options_.max_error) && *options_.max_error > 0))
      throw Error(ErrorCode::usage,
                  concat("largest error: found ", *options_.max_error, "; expected a number above 0"));
    if (!options_.max_error_is_share) return *options_.max_error;
    Interval<double> range;
    std::visit(
        [&](const auto& values) {
          for (const auto value : values)
            if (has_data(value)) range.include(static_cast<double>(value));
        },
        fields_.front().values);
    if (range.is_empty()) return 0;
    return std::max(*options_.max_error * (range.hi - range.lo), 0x1p-20 * std::max(-range.lo, range.hi));
  }

  /// Starts with about one sample for each tetrahedron, but with at least eight on the longest
  /// axis.
  LatticeRequest first_spec() const {
    if (options_.lattice.is_given()) return options_.lattice;
    const Vec3 extent = mesh_.box.max - mesh_.box.min;
    const double longest = std::max({extent.x, extent.y, extent.z});
    const double edge = std::cbrt(extent.x) * std::cbrt(extent.y) * std::cbrt(extent.z) /
                        std::cbrt(static_cast<double>(mesh_.cells.size()));
    const double samples = std::clamp(std::round(longest / edge) + 1, 8.0, 512.0);
    return {.longest_axis = static_cast<std::int64_t>(samples)};
  }

  SampleLattice first_lattice() const {
    return choose_samples(mesh_.box, options_.max_error ? first_spec() : options_.lattice);
  }

  static bool is_covered(const ResampledMesh& grid) {
    return grid.certificates.fields.front().coverage >= formats::Certificate::whole_coverage;
  }

  /// Refines the lattice until the requested error holds. Steps become shorter by a tenth at least
  /// and by half at most each time. The factor follows from the order of the last two errors. From
  /// a mesh's piecewise linear field that order is at most 2 where the steps are longer than the
  /// mesh's edges, and 1 where they are shorter.
  ///
  /// Where the field jumps (two sheets at one position, a gap narrower than the steps), no lattice
  /// helps. Once shortening the steps to less than a third has not reduced the smallest error by a
  /// twentieth, the grid with that error is taken. The same holds when memory is exhausted. A grid
  /// that covers the whole mesh is better than one that does not.
  ResampledMesh refined() {
    constexpr double shorter_in_vain = 1.0 / 3, least_gain = 0.05;
    const double requested = *report_.requested_error;
    ResampledMesh grid = sampled(placed(first_lattice()));
    SampleLattice best = grid.lattice;
    double best_error = std::numeric_limits<double>::infinity(), last_error = 0, last_spacing = 0;
    bool best_is_covered = false;
    while (report_.why_not_reached.empty()) {
      const FieldErrors& errors = grid.certificates.fields.front();
      const double error = errors.max_error, spacing = grid.lattice.spacing.x;
      report_.attempts.push_back({grid.lattice.count, error, errors.coverage});
      if (error <= requested && is_covered(grid)) return grid;
      const bool is_best =
          is_covered(grid) == best_is_covered ? error < (1 - least_gain) * best_error : is_covered(grid);
      if (is_best) {
        best_error = error;
        best_is_covered = is_covered(grid);
        best = grid.lattice;
      } else if (spacing < shorter_in_vain * best.spacing.x) {
        report_.why_not_reached = "finer grids hardly reduce it, because the field jumps or changes within one step";
        break;
      }
      double order = 1;
      if (last_error > error)
        order = std::clamp(std::log(last_error / error) / std::log(last_spacing / spacing), 0.5, 2.0);
      const double shorter =
          error > requested ? std::clamp(std::pow(0.95 * requested / error, 1 / order), 0.5, 0.9) : 0.9;
      last_error = error;
      last_spacing = spacing;
      try {
        ResampledMesh next = placed(finer(grid.lattice, shorter));
        grid = {};
        grid = sampled(std::move(next));
      } catch (const Error& error_of_next) {
        if (error_of_next.code() != ErrorCode::resource) throw;
        report_.why_not_reached = error_of_next.what();
      } catch (const std::bad_alloc&) {
        report_.why_not_reached =
            concat("memory is too small for a grid finer than ", size_text(report_.attempts.back().sample_count));
      }
    }
    if (grid.lattice.count == best.count) return grid;
    grid = {};
    return sampled(placed(best));
  }

  SampleLattice finer(const SampleLattice& lattice, double shorter) const {
    Index3 count;
    for (int a = 0; a < 3; ++a) {
      count[a] = static_cast<std::int64_t>(std::ceil(static_cast<double>(lattice.count[a] - 1) / shorter)) + 1;
      if (count[a] > SampleLattice::largest_axis)
        throw Error(ErrorCode::resource,
                    concat(source_name_, ": ", size_text(count), " are needed; a grid has at most ",
                           SampleLattice::largest_axis, " on an axis"));
    }
    if (options_.lattice.spacing != Vec3(0, 0, 0))
      return choose_samples(mesh_.box, {.spacing = lattice.spacing * shorter});
    return choose_samples(mesh_.box, {.sample_count = count});
  }

  void fill_report(const ResampledMesh& grid) {
    report_.inside_count = grid.samples.inside_count;
    report_.outside_count = static_cast<std::uint64_t>(volume(grid.lattice.count)) - report_.inside_count;
    report_.overlap_count = grid.samples.overlap_count;
    report_.extended_count = grid.samples.extended_count;
    for (std::size_t f = 0; f < fields_.size(); ++f) {
      const FieldErrors& errors = grid.certificates.fields[f];
      const formats::Certificate& kept = report_.description.certificates.at(f);
      report_.errors.push_back({.name = fields_[f].name,
                                .coverage = errors.coverage,
                                .max_error = kept.max_error,
                                .attained = errors.attained,
                                .attained_at = kept.max_at,
                                .rms_error = kept.rms_error,
                                .point_count = kept.point_count});
    }
    if (report_.overlap_count > 0)
      report_.notes.push_back(concat(report_.overlap_count,
                                     report_.overlap_count == 1 ? " sample lies" : " samples lie",
                                     " in several overlapping cells; the first cell counts"));
    if (report_.inside_count == 0)
      report_.notes.push_back(
          "no sample lies inside the mesh, which is thinner than the sample spacing; all values are extrapolated");
  }

  const ResampleOptions& options_;
  const Progress& progress_;
  std::string source_name_;
  std::uint64_t limit_;
  CleanMesh mesh_;
  std::vector<ScalarField> fields_;
  FaceNeighbors neighbors_;
  ResampleReport report_;
};

}  // namespace

ResampleReport resample(const NeutralMesh& mesh, const std::filesystem::path& path, const ResampleOptions& options,
                        const Progress& progress) {
  if (!options.lattice.is_given() && !options.max_error)
    throw Error(ErrorCode::usage,
                "found neither a number of samples, nor a spacing, nor a largest error; expected one");
  const DefaultFloatingPoint default_floating_point;
  return Resampling(mesh, options, progress).write(mesh.length_unit, path);
}

}  // namespace rhoray::preprocess
