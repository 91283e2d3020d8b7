#include <utility>

#include "formats/base/stopping.h"
#include "render/point_values.h"
#include "tools/library/conversions.h"
#include "tools/library/dataset.h"
#include "tools/library/guarded.h"
#include "tools/library/rays.h"

namespace rhoray::v0_1 {

class FieldSampler::Implementation {
 public:
  Implementation(const Dataset& handle, std::string_view field, const Method& method, const rhoray::Watch& watch)
      : data(handle),
        dataset(of_field(handle, field, watch)),
        proves_errors(method.proves_errors()),
        // No crossing is asked for. A field without values has an empty range.
        caster(dataset, dataset.field().range.is_empty() ? 0 : dataset.field().range.lo, inside::inside_of(method), 1,
               {}, watch) {}

  Dataset data;  ///< keeps the data alive
  render::Dataset dataset;
  bool proves_errors;
  render::RayCaster caster;

 private:
  static render::Dataset of_field(const Dataset& handle, std::string_view field, const rhoray::Watch& watch) {
    if (handle.kind() == DataKind::triangles)
      throw v0_1::Error(v0_1::ErrorCode::unsupported,
                        concat(handle.implementation().first().file().name(), ": a surface has no values in space"));
    if (!field.empty()) static_cast<void>(handle.field(field));  // refuses an unknown one
    return handle.implementation().of(field, watch);
  }
};

namespace {

/// Answers a batch of queries for the largest values.
auto largest_of(const FieldSampler::Implementation& sampler, const inside::CheckedRays& rays, const Hits& hits) {
  return [&](std::int64_t first, std::int64_t count, RayScratch::Implementation& scratch) {
    scratch.rays.resize(static_cast<std::size_t>(count)), scratch.hits.resize(static_cast<std::size_t>(count));
    for (std::int64_t i = 0; i < count; ++i) scratch.rays[static_cast<std::size_t>(i)] = rays[first + i];
    sampler.caster.largest_values(scratch.rays, scratch.hits, scratch.caster);
    inside::write(scratch.hits, first, render::world_from_ray_frame(sampler.dataset), false, true, hits);
  };
}

}  // namespace

FieldSampler::FieldSampler(const Dataset& data, std::string_view field, const Method& method, const Watch& watch)
    : implementation_(inside::guarded(
          [&] { return std::make_shared<const Implementation>(data, field, method, inside::inside_of(watch)); })) {}
FieldSampler::~FieldSampler() = default;
FieldSampler::FieldSampler(const FieldSampler&) = default;
FieldSampler& FieldSampler::operator=(const FieldSampler&) = default;

void FieldSampler::largest_values(const Rays& rays, const Hits& hits, RayScratch& scratch, const Watch& watch) const {
  inside::guarded([&] {
    const inside::CheckedRays checked(rays, implementation_->dataset);
    inside::check(hits, checked.count(), implementation_->proves_errors);
    inside::for_each_batch(checked.count(), scratch, inside::inside_of(watch),
                           largest_of(*implementation_, checked, hits));
  });
}

void FieldSampler::largest_values(const Rays& rays, const Hits& hits, RenderContext& context,
                                  const Watch& watch) const {
  context.implementation().call([&](render::RenderContext& threads) {
    const inside::CheckedRays checked(rays, implementation_->dataset);
    inside::check(hits, checked.count(), implementation_->proves_errors);
    inside::for_each_batch(checked.count(), context.implementation(), threads, inside::inside_of(watch),
                           largest_of(*implementation_, checked, hits));
  });
}

void FieldSampler::at(const ArrayView& points, std::span<double> values, std::span<std::uint64_t> cells,
                      const Watch& watch) const {
  inside::guarded([&] {
    inside::require_floats(points, "points", -1, 3);
    const auto count = static_cast<std::size_t>(points.shape()[0]);
    if (values.size() != count) inside::refuse("values: room for ", values.size(), " numbers; expected ", count);
    if (!cells.empty() && cells.size() != values.size())
      inside::refuse("cells: room for ", cells.size(), " numbers; expected ", count, ", or none");
    std::vector<rhoray::Vec3> at(count);
    for_each_until_stopped(0, count, light_piece, watch.stop, [&](std::uint64_t point) {
      const Vec3 v = inside::vector(points, static_cast<std::int64_t>(point));
      if (!inside::is_finite(v))
        inside::refuse("points[", point, "]: (", v.x, ", ", v.y, ", ", v.z, "); expected finite numbers");
      at[point] = inside::inside_of(v);
    });
    std::vector<render::PointValue> found(count);
    render::point_values(implementation_->dataset, at, found, inside::inside_of(watch));
    for (std::size_t point = 0; point < count; ++point) {
      values[point] = found[point].value;
      if (!cells.empty()) cells[point] = found[point].cell;
    }
  });
}

}  // namespace rhoray::v0_1
