#include "tools/library/context.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "formats/base/parallel.h"
#include "render/probe.h"
#include "tools/library/conversions.h"
#include "tools/library/picture.h"

namespace rhoray::v0_1 {

namespace {

/// Copies the pixels of a window, with all channels.
void copy_window(const render::Framebuffer& whole, const Rect& window, render::Framebuffer& out) {
  const auto copy = [&](const auto& from, auto& to, std::size_t components) {
    if (from.empty()) return;
    const std::size_t length = static_cast<std::size_t>(window.width) * components;
    for (int row = 0; row < window.height; ++row) {
      const std::size_t first = static_cast<std::size_t>(window.y + row) * static_cast<std::size_t>(whole.width) +
                                static_cast<std::size_t>(window.x);
      std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(first * components), length,
                  to.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(row) * length));
    }
  };
  copy(whole.color, out.color, 4);
  copy(whole.depth, out.depth, 1);
  copy(whole.normal, out.normal, 3);
  copy(whole.cell, out.cell, 1);
  copy(whole.value, out.value, 1);
  copy(whole.error, out.error, 1);
  copy(whole.cost, out.cost, 1);
  out.background = whole.background;
  out.is_transparent = whole.is_transparent;
}

/// Says what the caller's picture shows, and copies a window of the context's whole picture to it.
void hand_over(const RenderOptions& options, const render::Framebuffer& whole, Picture::Implementation& picture) {
  picture.size = options.size;
  picture.window = options.window.value_or(Rect{0, 0, options.size.width, options.size.height});
  if (!options.window) return;
  picture.pixels.reshape(picture.window.width, picture.window.height, inside::inside_of(options.channels));
  copy_window(whole, picture.window, picture.pixels);
}

RenderResult trace(RenderContext::Implementation& context, const Scene& scene, const RenderOptions& options,
                   const Passes& passes, Picture& picture, const rhoray::Watch& watch) {
  return context.call([&](render::RenderContext& threads) {
    const int spacings[] = {1, 2, 4, 8, 16};
    if (std::find(std::begin(spacings), std::end(spacings), passes.first_spacing) == std::end(spacings))
      inside::refuse("Passes::first_spacing: found ", passes.first_spacing, "; expected 1, 2, 4, 8 or 16");
    render::ResolvedScene resolved;
    try {
      resolved = inside::resolved_with_camera(scene, options, watch);
    } catch (const rhoray::Error& error) {
      if (error.code() != rhoray::ErrorCode::interrupted) throw;
      return RenderResult();
    }
    render::Framebuffer& pixels = options.window ? context.whole : picture.implementation().pixels;
    resolved.frame.threads = context.threads(), resolved.frame.machine = context.machine();
    bool all_traced = false, was_ended = false;
    const auto pass_done = [&](int spacing) {
      all_traced = spacing == 1 && !watch.stop.stop_requested();
      hand_over(options, pixels, picture.implementation());
      was_ended = passes.pass_done && !inside::call_back(passes.pass_done, spacing);
      return !was_ended;
    };
    const render::FrameStatistics statistics = render::refine(
        resolved.datasets, resolved.scene, resolved.frame,
        {.first_spacing = passes.first_spacing, .pass_done = pass_done, .watch = watch}, pixels, threads);
    hand_over(options, pixels, picture.implementation());
    // Samples at edges follow the last pass.
    const bool has_all_samples = options.max_samples == 1 || !(was_ended || watch.stop.stop_requested());
    return RenderResult{.statistics = inside::outside_of(statistics), .complete = all_traced && has_all_samples};
  });
}

}  // namespace

Statistics& Statistics::operator+=(const Statistics& other) {
  rays += other.rays;
  rays_ruled_out += other.rays_ruled_out;
  shadow_rays += other.shadow_rays;
  occlusion_rays += other.occlusion_rays;
  edge_pixels += other.edge_pixels;
  hits += other.hits;
  macrocells_visited += other.macrocells_visited;
  cells_visited += other.cells_visited;
  rays_exact += other.rays_exact;
  largest_error = std::isnan(largest_error) || std::isnan(other.largest_error)
                      ? std::nan("")
                      : std::max(largest_error, other.largest_error);
  preparation_s += other.preparation_s;
  range_proof_s += other.range_proof_s;
  wall_s += other.wall_s;
  return *this;
}

RenderContext::Implementation::Implementation(const ContextOptions& options)
    : threads_(std::min(options.threads, available_cores())),
      machine_(inside::machine_of(options.machine, "ContextOptions::machine")),
      process_(::getpid()),
      arena_(options.uses_callers_arena ? render::Arena::callers : render::Arena::own),
      context_(std::make_unique<render::RenderContext>(arena_)) {}

void RenderContext::Implementation::trim() {
  call([&](render::RenderContext&) {
    context_ = std::make_unique<render::RenderContext>(arena_);
    whole = {};
  });
}

void RenderContext::Implementation::begin() {
  if (::getpid() != process_)
    throw v0_1::Error(v0_1::ErrorCode::usage,
                      "a RenderContext was made before this process was forked: its threads are gone",
                      "make another one in this process");
  if (is_busy_.test_and_set())
    throw v0_1::Error(v0_1::ErrorCode::usage, "a RenderContext was called during another call of it",
                      "give every thread a context of its own");
  if (!is_broken_) return;
  is_busy_.clear();
  throw v0_1::Error(v0_1::ErrorCode::internal, "an earlier call of this RenderContext found a defect of the library",
                    "make another one, and report that error");
}

RenderContext::RenderContext(const ContextOptions& options)
    : implementation_(std::make_unique<Implementation>(options)) {}
RenderContext::~RenderContext() = default;

RenderResult RenderContext::render(const Scene& scene, const RenderOptions& options, Picture& picture,
                                   const Watch& watch) {
  return trace(*implementation_, scene, options, {.first_spacing = 1}, picture, inside::inside_of(watch));
}

RenderResult RenderContext::refine(const Scene& scene, const RenderOptions& options, const Passes& passes,
                                   Picture& picture, const Watch& watch) {
  // What ends the tiles: the caller's token, from the end of the first pass on.
  std::stop_source after_first_pass;
  std::optional<std::stop_callback<std::function<void()>>> link;
  Passes linked{.first_spacing = passes.first_spacing};
  linked.pass_done = [&](int spacing) {
    if (!link) link.emplace(watch.stop, [&] { after_first_pass.request_stop(); });
    return !passes.pass_done || passes.pass_done(spacing);
  };
  return trace(*implementation_, scene, options, linked, picture,
               rhoray::Watch(after_first_pass.get_token(), inside::inside_of(watch).progress));
}

std::vector<ProbeHit> RenderContext::probe(const Scene& scene, const Size& size, double x, double y, int max_hits,
                                           const Watch& watch) {
  return implementation_->call([&](render::RenderContext&) {
    const rhoray::Watch watched = inside::inside_of(watch);
    if (max_hits < 1) inside::refuse("RenderContext::probe: max_hits is ", max_hits, "; expected at least 1");
    render::ResolvedScene resolved = inside::resolved_with_camera(scene, {.size = size}, watched);
    resolved.frame.threads = implementation_->threads(), resolved.frame.machine = implementation_->machine();
    std::vector<ProbeHit> hits;
    for (const render::ProbeHit& hit : render::probe(resolved.datasets, resolved.scene, resolved.frame, {x, y},
                                                     static_cast<std::size_t>(max_hits), watched))
      hits.push_back(inside::outside_of(hit));
    return hits;
  });
}

void RenderContext::trim() {
  implementation_->trim();
}

Machine RenderContext::machine() const {
  return static_cast<Machine>(implementation_->machine());
}

bool has_machine(Machine machine) {
  return render::has_machine(inside::inside_of(machine, "has_machine"));
}

Machine best_machine() {
  return static_cast<Machine>(render::best_machine());
}

std::vector<Rect> windows(const Size& size, int edge) {
  constexpr int tile = 32, longest_side = inside::longest_side;
  if (size.width < 1 || size.height < 1 || edge < 1 || size.width > longest_side || size.height > longest_side)
    inside::refuse("windows: a picture of ", size.width, " x ", size.height, " pixels in windows of ", edge,
                   "; expected numbers above 0, and sides of the picture up to ", longest_side);
  edge = (std::min(edge, longest_side) + tile - 1) / tile * tile;
  std::vector<Rect> all;
  bool forward = true;
  for (int y = 0; y < size.height; y += edge, forward = !forward) {
    std::vector<Rect> row;
    for (int x = 0; x < size.width; x += edge)
      row.push_back({x, y, std::min(edge, size.width - x), std::min(edge, size.height - y)});
    if (!forward) std::reverse(row.begin(), row.end());
    all.insert(all.end(), row.begin(), row.end());
  }
  return all;
}

}  // namespace rhoray::v0_1
