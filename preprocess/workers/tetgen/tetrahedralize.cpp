#include "preprocess/tetrahedralize.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/error.h"
#include "preprocess/process/child_process.h"
#include "preprocess/process/messages.h"
#include "preprocess/workers/tetgen/job.h"
#include "preprocess/workers/tetgen/quality.h"

namespace rhoray::preprocess {

namespace {

void check_volume(double v) {
  if (!(v >= 0 && std::isfinite(v)))
    throw Error(ErrorCode::usage, concat("maximum volume ", v, "; expected 0 (no limit) or a positive volume"));
}

void check(const SizeField& sizes) {
  if (const auto* mesh = std::get_if<NeutralMesh>(&sizes); mesh != nullptr && mesh->point_fields.empty())
    throw Error(ErrorCode::usage, "size field: the mesh has no point field; expected one with wanted edge lengths");
  if (const auto* d = std::get_if<SizeByDistance>(&sizes))
    if (!(d->near > 0 && d->far >= d->near && d->growth >= 0 && std::isfinite(d->far + d->growth)))
      throw Error(ErrorCode::usage, concat("size field: near ", d->near, ", far ", d->far, ", growth ", d->growth,
                                           "; expected 0 < near <= far and a growth of at least 0"));
}

void check(const TetrahedralizeOptions& options) {
  const double q = options.quality.value_or(usual_quality);
  if (!(q == 0 || (q >= 1 && std::isfinite(q))))
    throw Error(ErrorCode::usage, concat("quality ", q, "; expected 0 or a ratio of at least 1"),
                "1.4 is a good ratio; below about 1.2 TetGen may not terminate");
  check_volume(options.max_volume);
  for (const auto& limit : options.region_volumes) check_volume(limit.max_volume);
  if (!options.regions && (!options.region_volumes.empty() || options.empty_cavities))
    throw Error(ErrorCode::usage, "volumes of single regions and empty cavities need the numbers of regions");
  check_tetgen_switches(options.tetgen);
  if (options.size_field) check(*options.size_field);
}

/// The size field in an anonymous file that the worker inherits.
class SizeFile {
 public:
  explicit SizeFile(const SizeField* sizes) {
    if (sizes == nullptr) return;
    parcel_.descriptor = memfd_create("rhoray-sizes", 0);
    if (parcel_.descriptor < 0) throw Error(ErrorCode::resource, "filling a surface: no descriptor for the size field");
    if (const auto* volume = std::get_if<NeutralVolume>(sizes)) {
      parcel_.kind = "volume";
      send(*volume, parcel_.descriptor);
    } else if (const auto* mesh = std::get_if<NeutralMesh>(sizes)) {
      parcel_.kind = "mesh";
      send(*mesh, parcel_.descriptor);
    } else {
      parcel_.kind = "distance";
      send(std::get<SizeByDistance>(*sizes).surface, parcel_.descriptor);
    }
  }
  SizeFile(const SizeFile&) = delete;
  SizeFile& operator=(const SizeFile&) = delete;
  ~SizeFile() {
    if (parcel_.descriptor >= 0) close(parcel_.descriptor);
  }
  const SizeMessage& parcel() const { return parcel_; }

 private:
  SizeMessage parcel_;
};

bool has_switch(const TetrahedralizeOptions& options, char letter) {
  return options.tetgen.find(letter) != std::string::npos;
}

TetrahedralizeOptions with_switch(TetrahedralizeOptions options, const std::string& text) {
  if (!has_switch(options, text.front())) options.tetgen += text;
  return options;
}

/// One run of the worker.
NeutralMesh fill_once(const NeutralSurface& surface, const TetrahedralizeOptions& options) {
  const SizeFile sizes(options.size_field.get());
  WorkerRequest request;
  request.program = "rhoray-tetgen-worker";
  request.doing = "filling a surface with tetrahedra";
  request.arguments = arguments_of(options, sizes.parcel());
  request.write_input = [&](int descriptor) { send(surface, descriptor); };
  request.memory_limit_bytes = options.memory_limit_bytes;
  request.time_limit_s = options.time_limit_s;
  try {
    return receive_mesh(run_worker(request));
  } catch (const Error& error) {
    if (error.code() != ErrorCode::resource || has_switch(options, 'Y')) throw;
    throw Error(error.code(), error.what(),
                "use larger cells, raise the limit, or keep the surface's triangles (--tetgen Y); thin triangles need "
                "very many points");
  }
}

/// How a mesh was made and how good it is.
struct Filling {
  NeutralMesh mesh;
  BadShare bad;
  bool is_short = false;  ///< more points would have made better cells, and too many of them
};

std::string percent(double share) {
  return concat(std::round(share * 1e4) / 1e2, " %");
}

NeutralMesh noted(Filling filling, const std::string& how) {
  const BadShare& bad = filling.bad;
  filling.mesh.notes.push_back(concat(
      how, "; ", percent(bad.of_cells), " of the cells, ", percent(bad.of_volume),
      " of the volume, do not reach a quality of ", usual_quality,
      filling.is_short ? concat(", for which there would be more than ", most_cells_per_triangle, " cells per triangle")
                       : ""));
  return std::move(filling.mesh);
}

Filling judged(NeutralMesh mesh, bool is_short) {
  const BadShare bad = share_above(mesh, usual_quality);
  return {std::move(mesh), bad, is_short};
}

/// How many triangles the facets make; one of n corners makes n - 2.
std::uint64_t triangle_count(const NeutralSurface& surface) {
  std::uint64_t count = 0;
  for (std::size_t f = 1; f < surface.facet_offsets.size(); ++f) {
    const std::uint64_t corners = surface.facet_offsets[f] - surface.facet_offsets[f - 1];
    count += corners > 2 ? corners - 2 : 0;
  }
  return count;
}

/// Adds points for quality only as long as there are at most `most_cells`.
Filling fill_within(const NeutralSurface& surface, const TetrahedralizeOptions& options, std::uint64_t most_cells) {
  constexpr std::uint64_t cells_per_point = 2;  // where all points lie on the surface; 5 to 7 inside
  constexpr int most_attempts = 4;
  std::uint64_t most_points = most_cells / cells_per_point;
  for (int attempt = 0; attempt < (has_switch(options, 'S') ? 1 : most_attempts) && most_points > 0; ++attempt) {
    NeutralMesh mesh = fill_once(surface, with_switch(options, concat("S", most_points)));
    const std::uint64_t new_points = mesh.points.size() - std::min(mesh.points.size(), surface.points.size());
    if (mesh.cells.size() <= most_cells) return judged(std::move(mesh), new_points >= most_points);
    const double fewer = 0.9 * static_cast<double>(most_cells) / static_cast<double>(mesh.cells.size());
    most_points = static_cast<std::uint64_t>(fewer * static_cast<double>(std::min(new_points, most_points)));
  }
  TetrahedralizeOptions without_points = options;
  without_points.quality = 0;
  return judged(fill_once(surface, without_points), true);
}

/// As the header says of a surface for which neither quality nor size is wanted.
NeutralMesh fill_to_an_end(const NeutralSurface& surface, const TetrahedralizeOptions& options) {
  const std::uint64_t most_cells = most_cells_per_triangle * triangle_count(surface);
  std::optional<Filling> kept;
  try {
    kept = fill_within(surface, with_switch(options, "Y"), most_cells);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::invalid) throw;
    return noted(fill_within(surface, options, most_cells), "the surface's triangles were split");
  }
  if (kept->bad.of_volume <= 0.1 && kept->bad.of_cells <= 0.5)
    return noted(std::move(*kept), "the surface's triangles were kept as they are");
  std::string why = "splitting them is not better";
  try {
    Filling split = fill_within(surface, options, most_cells);
    if (split.bad.of_volume < kept->bad.of_volume) return noted(std::move(split), "the surface's triangles were split");
    if (split.is_short)
      why = concat("splitting them would make more than ", most_cells_per_triangle, " cells per triangle");
  } catch (const Error& error) {
    if (error.code() != ErrorCode::invalid && error.code() != ErrorCode::resource) throw;
    why = concat("splitting them failed: ", error.what());
  }
  return noted(std::move(*kept), concat("the surface's triangles were kept as they are (", why, ")"));
}

}  // namespace

NeutralMesh tetrahedralize(const NeutralSurface& surface, const TetrahedralizeOptions& options) {
  check(options);
  if (options.quality || wants_sizes(options, surface)) return fill_once(surface, options);
  return fill_to_an_end(surface, options);
}

}  // namespace rhoray::preprocess
