#include "render/frame/antialiasing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/frame/lighting.h"
#include "render/frame/tracing.h"
#include "render/traverse/ticks.h"

namespace rhoray::render {

namespace {

constexpr float color_threshold = 1.0F / 16;
constexpr float normal_threshold = 0.9F;
constexpr double depth_threshold = 2;  // pixel widths
constexpr int first_samples = 16;      // of an edge pixel: they do not all miss a tenth of it

bool shows_surfaces(const Frame& frame) {
  return std::any_of(frame.layers.begin(), frame.layers.end(),
                     [](const FrameLayer& layer) { return layer.shading.layer.mode != Mode::mip; });
}

/// Light on a scale that is nearly perceptually uniform.
float seen(float linear) {
  return std::sqrt(std::max(linear, 0.0F));
}

/// A pixel whose samples are accumulated.
struct EdgePixel {
  int x, y;
  int sample_count = 0;
  std::array<double, 4> sum{};
  /// By channel; the last one is alpha.
  std::array<float, 4> darkest{1e30F, 1e30F, 1e30F, 1}, brightest{};

  void add(const std::array<float, 4>& color) {
    ++sample_count;
    for (std::size_t c = 0; c < 4; ++c) {
      sum[c] += static_cast<double>(color[c]);
      darkest[c] = std::min(darkest[c], color[c]);
      brightest[c] = std::max(brightest[c], color[c]);
    }
  }

  bool has_one_color() const {
    for (std::size_t c = 0; c < 3; ++c)
      if (seen(brightest[c]) - seen(darkest[c]) > color_threshold) return false;
    return brightest[3] - darkest[3] <= color_threshold;
  }
};

}  // namespace

SamplePlace sample_place(int index) {
  // In 64ths of a pixel. Straight edges of all directions cut off shares of a pixel. Each point was
  // chosen so that, together with the points before it, it estimates these shares with the smallest
  // mean square error.
  constexpr std::array<std::array<std::int8_t, 2>, most_samples> places{
      {{0, 0},    {-11, 15}, {17, -19},  {-21, -15}, {21, 19},  {-3, -19}, {-5, 29},   {21, -3},   {-29, 3},  {7, -29},
       {7, 17},   {-15, -1}, {29, 9},    {-25, -25}, {-21, 25}, {27, -17}, {7, 5},     {-11, -9},  {17, 29},  {-9, -25},
       {-21, 15}, {15, -7},  {-1, 15},   {21, -29},  {-31, 19}, {19, 9},   {-17, -21}, {5, -7},    {7, 27},   {-23, -5},
       {31, -5},  {-9, 7},   {5, -21},   {-13, 29},  {11, -13}, {27, 23},  {-31, -17}, {-7, -1},   {13, 7},   {-7, -31},
       {-9, 21},  {27, -23}, {-25, 9},   {15, 17},   {-9, -15}, {25, 3},   {-29, -3},  {3, 23},    {13, -25}, {-27, 27},
       {1, -11},  {29, 19},  {-21, -29}, {-1, 7},    {21, -11}, {-17, 7},  {9, -1},    {-17, -11}, {23, 31},  {1, -27},
       {-17, 23}, {29, -27}, {-21, 3},   {11, 21}}};
  const auto& place = places[static_cast<std::size_t>(index)];
  return {place[0] / 64.0, place[1] / 64.0};
}

/// Edge pixels of a tile, and the samples to be traced next.
struct EdgeSamples::Work {
  std::vector<EdgePixel> pixels;
  std::vector<std::uint32_t> open;               ///< pixels whose samples differ
  std::vector<std::uint32_t> of_samples;         ///< the pixel of each sample
  std::vector<double> across, down;              ///< position of each sample
  std::vector<SpreadDirections> sample_numbers;  ///< for each sample, if light rays need it
  LatticeRays rays;

  Work() {
    for (auto* places : {&across, &down}) places->reserve(tile_capacity);
    of_samples.reserve(tile_capacity);
    pixels.reserve(tile_capacity);
  }
};

EdgeSamples::EdgeSamples(Frame& frame, const FrameOptions& options)
    : frame_(frame),
      most_(options.antialiasing),
      width_(options.width),
      height_(options.height),
      window_(options.window),
      asked_for_(options.channels),
      shows_surfaces_(shows_surfaces(frame)),
      bend_(depth_threshold * 2 * frame.camera_rays.down().length() / options.height) {
  const std::size_t pixel_count = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  is_edge_.resize(pixel_count);
  if (!shows_surfaces_ || frame.layers.size() == 1) return;
  first_layers_.resize(pixel_count);
  frame.first_layers = first_layers_.data();
}

ChannelSet EdgeSamples::channels() const {
  ChannelSet all = asked_for_;
  if (shows_surfaces_) all |= {.depth = true, .normal = true};
  return all;
}

std::size_t EdgeSamples::pixel_at(int x, int y) const {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
}

/// A measure that is linear over the picture of a plane: the distance from the eye's plane in an
/// orthographic picture, else its inverse.
float EdgeSamples::depth_measure(const Framebuffer& picture, int x, int y) const {
  const CameraRays& camera = frame_.camera_rays;
  const auto distance = static_cast<double>(picture.depth[pixel_at(x, y)]);
  if (camera.is_orthographic()) return static_cast<float>(distance);
  const Vec3 through = camera.forward() + camera.across_of(x) * camera.across() + camera.down_of(y) * camera.down();
  return static_cast<float>(through.length() / distance);
}

bool EdgeSamples::differ(const Framebuffer& picture, std::size_t a, std::size_t b) const {
  for (std::size_t c = 0; c < 3; ++c) {
    const float of_a = picture.color[4 * a + c], of_b = picture.color[4 * b + c];
    if (of_a != of_b && std::abs(seen(of_a) - seen(of_b)) > color_threshold) return true;
  }
  // These may differ once the picture is composited over a background.
  if (frame_.has_transparent_background &&
      std::abs(picture.color[4 * a + 3] - picture.color[4 * b + 3]) > color_threshold)
    return true;
  if (!shows_surfaces_) return false;
  const bool a_is_hit = std::isfinite(picture.depth[a]), b_is_hit = std::isfinite(picture.depth[b]);
  if (a_is_hit != b_is_hit) return true;
  if (!a_is_hit) return false;
  if (!first_layers_.empty() && first_layers_[a] != first_layers_[b]) return true;
  float cosine = 0, length = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cosine += picture.normal[3 * a + axis] * picture.normal[3 * b + axis];
    length += std::abs(picture.normal[3 * a + axis] + picture.normal[3 * b + axis]);
  }
  return length > 0 && cosine < normal_threshold;
}

void EdgeSamples::mark_tile(const Framebuffer& picture, const Tile& tile) {
  // Whether a pixel differs from its right or lower neighbour, starting one pixel before the tile.
  constexpr std::size_t row = tile_edge + 1;
  std::array<bool, row * row> right{}, below{};
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y - tile.y_begin + 1) * row + static_cast<std::size_t>(x - tile.x_begin + 1);
  };
  for (int y = std::max(tile.y_begin - 1, 0); y < tile.y_end; ++y)
    for (int x = std::max(tile.x_begin - 1, 0); x < tile.x_end; ++x) {
      const std::size_t pixel = pixel_at(x, y);
      if (x + 1 < width_) right[at(x, y)] = differ(picture, pixel, pixel + 1);
      if (y + 1 < height_) below[at(x, y)] = differ(picture, pixel, pixel + static_cast<std::size_t>(width_));
    }
  const auto bends = [&](int x, int y, int dx, int dy) {
    if (x - dx < 0 || y - dy < 0 || x + dx >= width_ || y + dy >= height_) return false;
    const float before = depth_measure(picture, x - dx, y - dy), here = depth_measure(picture, x, y),
                after = depth_measure(picture, x + dx, y + dy);
    const double limit = frame_.camera_rays.is_orthographic() ? bend_ : bend_ * static_cast<double>(here);
    return std::abs(static_cast<double>(before + after - 2 * here)) > limit;
  };
  for (int y = tile.y_begin; y < tile.y_end; ++y)
    for (int x = tile.x_begin; x < tile.x_end; ++x) {
      const std::size_t pixel = pixel_at(x, y);
      bool is_edge = right[at(x, y)] || right[at(x - 1, y)] || below[at(x, y)] || below[at(x, y - 1)];
      if (!is_edge && shows_surfaces_ && std::isfinite(picture.depth[pixel]))
        // a neighbour without a hit has already marked the pixel
        is_edge = bends(x, y, 1, 0) || bends(x, y, 0, 1);
      is_edge_[pixel] = is_edge;
    }
}

/// Traces and shades the gathered samples and adds them to their pixels.
void EdgeSamples::trace(Worker& worker, Work& work) const {
  if (work.across.empty()) return;
  WorkerCounts& counts = worker.counts;
  work.rays.of_layers.clear();
  for (const FrameLayer& layer : frame_.layers)
    work.rays.of_layers.emplace_back(frame_.camera_rays, layer.data_from_world, work.across, work.down);
  if (frame_.needs.world_rays) work.rays.in_world.emplace(frame_.camera_rays, Affine(), work.across, work.down);
  trace_layers(frame_, work.rays, Tile{}, worker);
  if (frame_.needs.spread_directions) std::swap(worker.pixels, work.sample_numbers);
  const std::uint64_t shading_start = ticks_now();
  shade_layers(frame_, worker);
  for (std::size_t r = 0; r < work.of_samples.size(); ++r)
    work.pixels[work.of_samples[r]].add(
        {worker.colors.red[r], worker.colors.green[r], worker.colors.blue[r], worker.colors.alpha[r]});
  counts.shading_ticks += ticks_now() - shading_start;
  counts.rays += work.of_samples.size();
  counts.edge_samples += work.of_samples.size();
  for (auto* places : {&work.across, &work.down}) places->clear();
  work.of_samples.clear();
  work.sample_numbers.clear();
}

void EdgeSamples::refine_tile(const Tile& tile, Worker& worker, Work& work, Framebuffer& picture) const {
  const std::uint64_t start = ticks_now();
  work.pixels.clear();
  work.open.clear();
  for (int y = tile.y_begin; y < tile.y_end; ++y)
    for (int x = tile.x_begin; x < tile.x_end; ++x) {
      if (is_edge_[pixel_at(x, y)] == 0) continue;
      const float* middle = picture.color.data() + 4 * pixel_at(x, y);
      work.open.push_back(static_cast<std::uint32_t>(work.pixels.size()));
      work.pixels.push_back({.x = x, .y = y});
      work.pixels.back().add({middle[0], middle[1], middle[2], middle[3]});
    }
  for (int target = std::min(first_samples, most_); !work.open.empty(); target = std::min(2 * target, most_)) {
    for (const std::uint32_t index : work.open) {
      const EdgePixel& pixel = work.pixels[index];
      for (int sample = pixel.sample_count; sample < target; ++sample) {
        const SamplePlace place = sample_place(sample);
        work.across.push_back(frame_.camera_rays.across_at(pixel.x + 0.5 + place.x));
        work.down.push_back(frame_.camera_rays.down_at(pixel.y + 0.5 + place.y));
        work.of_samples.push_back(index);
        if (frame_.needs.spread_directions)
          work.sample_numbers.emplace_back(static_cast<std::uint32_t>(pixel.x),
                                           static_cast<std::uint32_t>(pixel.y + sample * height_));
      }
      if (work.across.size() + static_cast<std::size_t>(target) > tile_capacity) trace(worker, work);
    }
    trace(worker, work);
    if (target == most_) break;
    std::erase_if(work.open, [&](std::uint32_t index) { return work.pixels[index].has_one_color(); });
  }
  for (const EdgePixel& pixel : work.pixels)
    for (std::size_t c = 0; c < 4; ++c)
      picture.color[4 * pixel_at(pixel.x, pixel.y) + c] = static_cast<float>(pixel.sum[c] / pixel.sample_count);
  worker.counts.edge_pixels += work.pixels.size();
  worker.counts.tile_ticks += ticks_now() - start;
}

void EdgeSamples::add_to(RenderContext::Implementation& memory, const Watch& watch, Framebuffer& picture) {
  std::vector<Tile> tiles = tiles_in_order(width_, height_);
  if (window_)
    std::erase_if(tiles, [this](const Tile& tile) {
      return tile.x_end <= window_->x || tile.x_begin >= window_->x + window_->width || tile.y_end <= window_->y ||
             tile.y_begin >= window_->y + window_->height;
    });
  memory.threads().for_each_tile(tiles.size(), [&](std::size_t tile, std::size_t) { mark_tile(picture, tiles[tile]); });
  std::vector<Work> works(memory.threads().worker_count());
  ProgressMeter meter(watch.progress, "antialiasing (tiles)", tiles.size());
  memory.threads().for_each_tile(tiles.size(), [&](std::size_t tile, std::size_t worker) {
    if (watch.stop.stop_requested()) return;
    refine_tile(tiles[tile], memory.worker(worker), works[worker], picture);
    meter.add(1);
  });
}

}  // namespace rhoray::render
