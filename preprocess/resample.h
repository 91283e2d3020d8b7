#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "preprocess/neutral.h"
#include "preprocess/progress.h"

namespace rhoray::preprocess {

/// Which lattice of samples is wanted over a mesh's box. One of the three is given, the others are zero.
struct LatticeRequest {
  std::int64_t longest_axis = 0;  ///< samples on the longest axis; the others get nearly the same spacing
  Index3 sample_count{0, 0, 0};   ///< samples on every axis
  Vec3 spacing{0, 0, 0};          ///< distance of samples on every axis

  bool is_given() const { return longest_axis != 0 || sample_count != Index3(0, 0, 0) || spacing != Vec3(0, 0, 0); }
};

struct ResampleOptions {
  std::vector<std::string> fields{};  ///< as PackMeshOptions::fields
  bool cells_to_points = false;       ///< also take cell fields, averaged to points
  LatticeRequest lattice{};           ///< may be left out with max_error: then where to start is chosen

  /// Refines the lattice until the certificate of the first field has at most this error and covers the mesh; or until
  /// finer ones do not fit, or no longer help (ResampleReport::why_not_reached).
  std::optional<double> max_error{};
  bool max_error_is_share = false;  ///< of the field's range, instead of in the field's unit

  std::uint64_t memory_limit_bytes = 0;  ///< for samples and lists; 0 = half of the machine's memory
  std::string command{};
  std::string source_name{};
  bool replace_existing = false;
};

struct ResampleReport {
  /// How far the trilinear field between samples lies from the mesh's piecewise linear one, over the part of the mesh
  /// in leaf cells whose eight samples have values.
  struct FieldError {
    std::string name;
    double coverage = 1;   ///< that part's share of the mesh's volume where the field has data
    double max_error = 0;  ///< not exceeded anywhere (certified; the file keeps such a bound for every brick)
    double attained = 0;   ///< found at a point: the true maximum lies between the two
    Vec3 attained_at;      ///< that point, world
    double rms_error = 0;  ///< estimated from one point in each leaf cell or in every fourth
    std::uint64_t point_count = 0;
  };
  /// A lattice that was tried for max_error.
  struct Attempt {
    Index3 sample_count;
    double max_error = 0;
    double coverage = 1;
  };

  formats::GridDescription description;
  std::uint64_t file_bytes = 0;
  std::uint64_t inside_count = 0;   ///< samples in the mesh
  std::uint64_t outside_count = 0;  ///< the others
  /// Of those: beside the mesh, with a value because a leaf cell needs it. Of several fields the most in each brick.
  std::uint64_t extended_count = 0;
  std::uint64_t overlap_count = 0;  ///< samples that several cells hold (shared faces apart): the lowest one counts
  std::vector<FieldError> errors;   ///< by field
  std::vector<Attempt> attempts;    ///< with max_error, in the order in which they were made
  std::optional<double> requested_error;  ///< with max_error, in the first field's unit
  std::string why_not_reached;            ///< with max_error: empty when it holds and the mesh is covered
  std::vector<std::string> notes;
};

/// Samples a tetrahedral mesh on a lattice over its box and writes a packed grid that keeps only bricks of 8 x 8 x 8
/// samples that have a value, with a certificate of the error for every field (SPEC.md) in which
///
///  * `coverage` is the share of the mesh's volume, where the field has data, in leaf cells whose eight samples have
///    values: 1 but for rounding, because samples beside the mesh get values where a leaf cell that the mesh meets
///    needs them (resample/extend.h);
///  * `max` of a brick is an upper bound, not an estimate, of |trilinear - piecewise linear| over the part of the mesh
///    in its leaf cells (those whose first sample is the brick's) where all eight samples have values. The largest of
///    them exceeds a difference that is attained by at most a twentieth, or by 1e-6 of the field's range; where a brick
///    cannot hold the largest error its bound is less tight;
///  * `rms` is estimated from one point in each leaf cell, or in every fourth where there are more than 1024 bricks.
///
/// Every sample is decided exactly (resample/locate.h). Outside the mesh, and in cells with a vertex without data, it
/// is NaN unless such a leaf cell needs it. The trilinear field therefore reaches beyond the mesh: by at most one step
/// on each axis, and by one and a half in a gap or notch, where a leaf cell outside may find all its samples given
/// values by its neighbours. The file does not depend on the number of threads.
///
/// With max_error a file is written also when the error is not reached: the certificate then says so
/// (Certificate::meets_request), and why_not_reached tells the reason.
///
/// Refuses what pack_mesh refuses; ErrorCode::usage: no lattice; ErrorCode::resource: the only lattice, or with
/// max_error the first one, does not fit into the memory limit.
ResampleReport resample(const NeutralMesh& mesh, const std::filesystem::path& path, const ResampleOptions& options,
                        const Progress& progress = {});

}  // namespace rhoray::preprocess
