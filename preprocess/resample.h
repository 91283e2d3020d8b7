#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/base/progress.h"
#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// The requested lattice of samples over a mesh's box. One of the three is given, the others are
/// zero.
struct LatticeRequest {
  /// samples on the longest axis; the others get nearly the same spacing
  std::int64_t longest_axis = 0;
  Index3 sample_count{0, 0, 0};  ///< samples on every axis
  Vec3 spacing{0, 0, 0};         ///< distance of samples on every axis

  bool is_given() const { return longest_axis != 0 || sample_count != Index3(0, 0, 0) || spacing != Vec3(0, 0, 0); }
};

struct ResampleOptions {
  std::vector<std::string> fields{};  ///< as in PackMeshOptions::fields
  bool cells_to_points = false;       ///< also take cell fields, averaged to points
  LatticeRequest lattice{};           ///< optional with max_error: the first lattice is then chosen

  /// Refines the lattice until the certificate of the first field covers the mesh and has at most
  /// this error. Stops earlier when finer lattices do not fit or no longer help
  /// (ResampleReport::why_not_reached).
  std::optional<double> max_error{};
  /// a fraction of the field's range, instead of in the field's unit
  bool max_error_is_share = false;

  /// for samples and lists; 0 = half of the machine's memory
  std::uint64_t memory_limit_bytes = 0;
  std::string command{};
  std::string source_name{};
  bool replace_existing = false;
};

struct ResampleReport {
  /// The difference between the trilinear field of the samples and the mesh's piecewise linear
  /// field. It is taken over the part of the mesh in leaf cells whose eight samples have values.
  struct FieldError {
    std::string name;
    double coverage = 1;  ///< that part's fraction of the mesh's volume where the field has data
    /// upper bound everywhere (certified; the file keeps one for every brick)
    double max_error = 0;
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
  /// Of the outside samples, those with a value because a leaf cell needs it. With several fields,
  /// the largest count in each brick.
  std::uint64_t extended_count = 0;
  /// samples inside several cells (except at shared faces): the lowest cell counts
  std::uint64_t overlap_count = 0;
  std::vector<FieldError> errors;         ///< by field
  std::vector<Attempt> attempts;          ///< with max_error, in the order of the attempts
  std::optional<double> requested_error;  ///< with max_error, in the first field's unit
  /// with max_error: empty when it holds and the mesh is covered
  std::string why_not_reached;
  std::vector<std::string> notes;
};

/// Samples a tetrahedral mesh on a lattice over its box and writes a packed grid. The grid keeps
/// only bricks of 8 x 8 x 8 samples that have a value. Every field gets a certificate of the error
/// (SPEC.md), in which
///
///  * `coverage` is the fraction of the mesh's volume, where the field has data, that lies in leaf
///    cells whose eight samples have values. It is 1 except for rounding: samples beside the mesh
///    get values where a leaf cell that touches the mesh needs them (resample/extend.h);
///  * `max` of a brick is an upper bound, not an estimate, of |trilinear - piecewise linear|. It
///    holds over the part of the mesh in the brick's leaf cells (those whose first sample is the
///    brick's) where all eight samples have values. The largest `max` exceeds a difference that is
///    attained by at most a twentieth, or by 1e-6 of the field's range. Where a brick cannot hold
///    the largest error, its bound is less tight;
///  * `rms` is estimated from one point in each leaf cell, or in every fourth where there are more
///    than 1024 bricks.
///
/// Every sample is decided exactly (resample/locate.h). Outside the mesh, and in cells with a
/// vertex without data, it is NaN unless such a leaf cell needs it. The trilinear field therefore
/// reaches beyond the mesh: by at most one step on each axis, and by one and a half in a gap or
/// notch. There, the neighbours of a leaf cell outside may have given values to all its samples.
/// The file does not depend on the number of threads.
///
/// With max_error, a file is written even when the error is not reached. The certificate then says
/// so (Certificate::meets_request), and why_not_reached gives the reason.
///
/// Refuses what pack_mesh refuses. ErrorCode::usage: no lattice. ErrorCode::resource: the only
/// lattice, or with max_error the first one, does not fit into the memory limit.
ResampleReport resample(const NeutralMesh& mesh, const std::filesystem::path& path, const ResampleOptions& options,
                        const Progress& progress = {});

/// Refuses an input that holds no mesh, before it is read (ErrorCode::invalid).
void check_resample(const std::filesystem::path& input);

/// As above, for the mesh of a foreign file or of a packed file. The mesh gets fields as in packing
/// (pack.h). The file names the input as its source; the notes include those of reading.
ResampleReport resample(const std::filesystem::path& input, const std::filesystem::path& output,
                        ResampleOptions options, const Progress& progress = {});

}  // namespace rhoray::preprocess
