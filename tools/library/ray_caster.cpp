#include <algorithm>
#include <utility>

#include "render/all_crossings.h"
#include "tools/library/conversions.h"
#include "tools/library/dataset.h"
#include "tools/library/guarded.h"
#include "tools/library/rays.h"

namespace rhoray::v0_1 {

class RayCaster::Implementation {
 public:
  Implementation(const Dataset& handle, const std::variant<Isosurface, Triangles>& surface, const Method& method,
                 std::string_view field, const rhoray::Watch& watch)
      : data(handle),
        dataset(of_field(handle, field, watch)),
        isovalue(isovalue_of(surface)),
        is_isosurface(std::holds_alternative<Isosurface>(surface)),
        proves_errors(method.proves_errors()),
        caster(dataset, isovalue, inside::inside_of(checked(method)), 1, {}, watch) {}

  void first_hits(const inside::CheckedRays& rays, std::int64_t first, std::int64_t count,
                  RayScratch::Implementation& scratch) const {
    scratch.rays.resize(static_cast<std::size_t>(count)), scratch.hits.resize(static_cast<std::size_t>(count));
    for (std::int64_t i = 0; i < count; ++i) scratch.rays[static_cast<std::size_t>(i)] = rays[first + i];
    caster.first_crossings(scratch.rays, scratch.hits, scratch.caster);
  }

  Dataset data;  ///< keeps the data alive
  render::Dataset dataset;
  double isovalue;
  bool is_isosurface, proves_errors;
  render::RayCaster caster;

 private:
  static render::Dataset of_field(const Dataset& handle, std::string_view field, const rhoray::Watch& watch) {
    if (!field.empty()) static_cast<void>(handle.field(field));  // refuses an unknown one
    return handle.implementation().of(field, watch);
  }

  double isovalue_of(const std::variant<Isosurface, Triangles>& surface) const {
    const auto* const isosurface = std::get_if<Isosurface>(&surface);
    if (dataset.is_surface() != (isosurface == nullptr))
      inside::refuse(dataset.file().name(), dataset.is_surface() ? ": holds triangles; expected Triangles"
                                                                 : ": holds no triangles; expected an Isosurface");
    return isosurface != nullptr ? isosurface->isovalue : 0;
  }

  const Method& checked(const Method& method) const {
    if (is_isosurface || method == Method(Accuracy::float32) || method == Method(Accuracy::float64)) return method;
    throw v0_1::Error(v0_1::ErrorCode::unsupported,
                      concat(dataset.file().name(), ": triangles are traced only at float32 and float64"));
  }
};

namespace {

/// The crossings of one batch.
struct Found {
  std::vector<render::AllCrossings> of_rays;
};

void collect(const std::vector<Found>& batches, AllHits& hits) {
  hits = {};
  hits.first.push_back(0);
  for (const Found& batch : batches)
    for (const render::AllCrossings& ray : batch.of_rays) {
      for (const render::Crossing& crossing : ray.crossings) {
        hits.t.push_back(crossing.t), hits.error.push_back(crossing.error), hits.cell.push_back(crossing.cell);
        hits.enters.push_back(crossing.to_inside ? 1 : 0);
      }
      hits.first.push_back(hits.t.size());
      hits.truncated.push_back(ray.truncated ? 1 : 0);
    }
}

/// Calls run(act) with the function that answers a batch, then collects the answers.
template <class Run>
void find_all(const RayCaster::Implementation& caster, const inside::CheckedRays& rays, AllHits& hits,
              std::size_t max_hits, const Run& run) {
  if (!caster.is_isosurface)
    throw v0_1::Error(v0_1::ErrorCode::unsupported,
                      concat(caster.dataset.file().name(), ": triangles have no list of all hits"));
  if (max_hits < 1) inside::refuse("RayCaster::all_hits: max_hits is 0; expected at least 1");
  std::vector<Found> batches(static_cast<std::size_t>((rays.count() + inside::batch_size - 1) / inside::batch_size));
  run([&](std::int64_t first, std::int64_t count, RayScratch::Implementation&) {
    Found& batch = batches[static_cast<std::size_t>(first / inside::batch_size)];
    for (std::int64_t i = 0; i < count; ++i)
      batch.of_rays.push_back(render::all_crossings(caster.dataset, caster.isovalue, rays[first + i], max_hits));
  });
  collect(batches, hits);
}

/// Answers a batch of queries for the first hits.
auto first_hits_of(const RayCaster::Implementation& caster, const inside::CheckedRays& rays, const Hits& hits) {
  return [&](std::int64_t first, std::int64_t count, RayScratch::Implementation& scratch) {
    caster.first_hits(rays, first, count, scratch);
    inside::write(scratch.hits, first, render::world_from_ray_frame(caster.dataset), true, caster.is_isosurface, hits);
  };
}

auto any_hits_of(const RayCaster::Implementation& caster, const inside::CheckedRays& rays,
                 std::span<std::uint8_t> is_hit) {
  return [&caster, &rays, is_hit](std::int64_t first, std::int64_t count, RayScratch::Implementation& scratch) {
    caster.first_hits(rays, first, count, scratch);
    for (std::int64_t i = 0; i < count; ++i)
      is_hit[static_cast<std::size_t>(first + i)] = scratch.hits[static_cast<std::size_t>(i)].is_miss() ? 0 : 1;
  };
}

/// Calls act(first, count, scratch) for batches of rays on the threads of a context, when what they
/// need is prepared.
template <class Act>
void answer_on(RenderContext::Implementation& context, render::RenderContext& threads,
               const RayCaster::Implementation& caster, const inside::CheckedRays& rays, const rhoray::Watch& watch,
               const Act& act) {
  if (rays.count() > 0) caster.caster.prepare_first_crossings(context.machine(), context.threads(), watch);
  inside::for_each_batch(rays.count(), context, threads, watch, act);
}

void check_flags(std::span<std::uint8_t> is_hit, std::int64_t count) {
  if (static_cast<std::int64_t>(is_hit.size()) != count)
    inside::refuse("RayCaster::any_hits: room for ", is_hit.size(), " answers; expected ", count);
}

}  // namespace

RayCaster::RayCaster(const Dataset& data, const std::variant<Isosurface, Triangles>& surface, const Method& method,
                     std::string_view field, const Watch& watch)
    : implementation_(inside::guarded([&] {
        return std::make_shared<const Implementation>(data, surface, method, field, inside::inside_of(watch));
      })) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(const RayCaster&) = default;
RayCaster& RayCaster::operator=(const RayCaster&) = default;

void RayCaster::first_hits(const Rays& rays, const Hits& hits, RayScratch& scratch, const Watch& watch) const {
  inside::guarded([&] {
    const inside::CheckedRays checked(rays, implementation_->dataset);
    inside::check(hits, checked.count(), implementation_->proves_errors);
    inside::for_each_batch(checked.count(), scratch, inside::inside_of(watch),
                           first_hits_of(*implementation_, checked, hits));
  });
}

void RayCaster::first_hits(const Rays& rays, const Hits& hits, RenderContext& context, const Watch& watch) const {
  context.implementation().call([&](render::RenderContext& threads) {
    const inside::CheckedRays checked(rays, implementation_->dataset);
    inside::check(hits, checked.count(), implementation_->proves_errors);
    answer_on(context.implementation(), threads, *implementation_, checked, inside::inside_of(watch),
              first_hits_of(*implementation_, checked, hits));
  });
}

void RayCaster::any_hits(const Rays& rays, std::span<std::uint8_t> is_hit, RayScratch& scratch,
                         const Watch& watch) const {
  inside::guarded([&] {
    const inside::CheckedRays checked(rays, implementation_->dataset);
    check_flags(is_hit, checked.count());
    inside::for_each_batch(checked.count(), scratch, inside::inside_of(watch),
                           any_hits_of(*implementation_, checked, is_hit));
  });
}

void RayCaster::any_hits(const Rays& rays, std::span<std::uint8_t> is_hit, RenderContext& context,
                         const Watch& watch) const {
  context.implementation().call([&](render::RenderContext& threads) {
    const inside::CheckedRays checked(rays, implementation_->dataset);
    check_flags(is_hit, checked.count());
    answer_on(context.implementation(), threads, *implementation_, checked, inside::inside_of(watch),
              any_hits_of(*implementation_, checked, is_hit));
  });
}

void RayCaster::all_hits(const Rays& rays, AllHits& hits, RayScratch& scratch, std::size_t max_hits,
                         const Watch& watch) const {
  inside::guarded([&] {
    const inside::CheckedRays checked(rays, implementation_->dataset);
    find_all(*implementation_, checked, hits, max_hits, [&](const auto& act) {
      const rhoray::Watch watched = inside::inside_of(watch);
      implementation_->dataset.prove_ranges(1, watched);  // on this thread alone
      inside::for_each_batch(checked.count(), scratch, watched, act);
    });
  });
}

void RayCaster::all_hits(const Rays& rays, AllHits& hits, RenderContext& context, std::size_t max_hits,
                         const Watch& watch) const {
  context.implementation().call([&](render::RenderContext& threads) {
    const inside::CheckedRays checked(rays, implementation_->dataset);
    find_all(*implementation_, checked, hits, max_hits, [&](const auto& act) {
      const rhoray::Watch watched = inside::inside_of(watch);
      implementation_->dataset.prove_ranges(context.implementation().threads(), watched);
      inside::for_each_batch(checked.count(), context.implementation(), threads, watched, act);
    });
  });
}

}  // namespace rhoray::v0_1
