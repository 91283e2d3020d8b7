#include <cmath>
#include <span>

#include "formats/base/parallel.h"
#include "formats/brick_grid.h"
#include "formats/packed_file.h"
#include "formats/tet_mesh.h"
#include "preprocess/run_worker.h"
#include "render/camera.h"
#include "render/ray_caster.h"
#include "tools/validate/compare.h"
#include "tools/validate/request.h"

namespace rhoray::tools::validate {

namespace {

constexpr std::uint64_t all_done = 1000;

RayQuery query_of(const Request& request, const render::Dataset& dataset) {
  RayQuery query{.isovalue = request.isovalue,
                 .samples = request.samples,
                 .seed = request.seed,
                 .max_depth_error = request.max_depth_error};
  if (request.picture_width == 0) return query;
  Box3 box = dataset.isosurface_bounds(request.isovalue);
  if (box.isEmpty()) box = dataset.bounds();
  const double aspect = static_cast<double>(request.picture_width) / request.picture_height;
  query.camera_rays = render::camera_rays(dataset, render::fit_camera(box, render::named_view("iso"), aspect),
                                          request.picture_width, request.picture_height);
  return query;
}

Comparison compare(const Request& request) {
  const render::Dataset dataset = render::Dataset::load(request.file, request.field);
  const RayQuery query = query_of(request, dataset);
  const render::Method method{.algorithm = static_cast<render::Method::Algorithm>(request.algorithm),
                              .precision = static_cast<render::Method::Precision>(request.precision),
                              .step = request.step,
                              .bisect = request.bisect,
                              .slack = request.slack};
  render::RayCaster queries(dataset, request.isovalue, method, request.threads);
  const Tracer tracer = [&](std::span<const render::Ray> rays, std::span<render::Hit> hits) {
    queries.first_crossings(rays, hits);
  };
  const Thousandths progress = [](std::uint64_t done) { preprocess::report_worker_progress(done, all_done); };
  const Affine world_from_frame = render::world_from_ray_frame(dataset);
  if (!dataset.is_mesh())
    return compare_grid(GridField(formats::BrickGrid(dataset.file()), request.field), world_from_frame, query, tracer,
                        progress);
  const TetField field(formats::TetMesh(dataset.file()), request.field);
  return compare_tets(field, world_from_frame, query, tracer, progress);
}

struct PictureArrays {
  std::vector<float> distance, depth;
  std::vector<std::uint8_t> verdict;
};

PictureArrays arrays_of(const Shots& picture) {
  PictureArrays arrays;
  for (std::size_t pixel = 0; pixel < picture.findings.size(); ++pixel) {
    const Finding& finding = picture.findings[pixel];
    const bool is_hit = !picture.hits[pixel].is_miss();
    arrays.distance.push_back(static_cast<float>(finding.is_above ? finding.distance_cells : -finding.distance_cells));
    arrays.depth.push_back(static_cast<float>(finding.depth_cells));
    arrays.verdict.push_back(!is_hit && finding.verdict == Verdict::right ? no_verdict
                                                                          : static_cast<std::uint8_t>(finding.verdict));
  }
  return arrays;
}

void send(const Comparison& comparison, const Request& request, int output) {
  const std::string text = dump(json_of(comparison.report));
  const PictureArrays picture = arrays_of(comparison.picture);
  using formats::ElementType;
  std::vector<formats::ArraySpec> specs{{report_array, ElementType::U8, {text.size()}}};
  const bool has_picture = !picture.verdict.empty();
  const std::vector<std::uint64_t> shape{static_cast<std::uint64_t>(request.picture_height),
                                         static_cast<std::uint64_t>(request.picture_width)};
  if (has_picture) {
    specs.push_back({distance_array, ElementType::F32, shape});
    specs.push_back({depth_array, ElementType::F32, shape});
    specs.push_back({verdict_array, ElementType::U8, shape});
  }
  formats::PackedFileWriter writer(output, {.kind = report_kind}, specs);
  writer.write_all(report_array, std::span<const char>(text));
  if (has_picture) {
    writer.write_all(distance_array, std::span<const float>(picture.distance));
    writer.write_all(depth_array, std::span<const float>(picture.depth));
    writer.write_all(verdict_array, std::span<const std::uint8_t>(picture.verdict));
  }
  writer.commit(request.threads);
}

}  // namespace

}  // namespace rhoray::tools::validate

/// Compares the renderer's hits with CGAL's for one packed file and sends the report.
int main(int argc, char** argv) {
  using namespace rhoray;
  return preprocess::worker_main([&](int, int output) {
    const auto request = tools::validate::request_from(argc == 2 ? argv[1] : "");
    const ThreadLimit threads(request.threads);
    tools::validate::send(tools::validate::compare(request), request, output);
  });
}
