#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "render/frame/pass.h"
#include "render/frame/render_context.h"

namespace rhoray::render {

constexpr int most_samples = 64;

/// Where a sample of a pixel lies: shares of the pixel, from its middle.
struct SamplePlace {
  double x, y;
};

/// Number 0 is the middle; the first n of any n are well spread. The share of them on one side of a straight edge
/// differs from that of the pixel by 0.07 in the root mean square with 8, by 0.04 with 16, by 0.02 with 64 of them.
SamplePlace sample_place(int index);

/// Antialiasing: further samples for the pixels at edges of a picture that has one sample in every pixel.
///
/// A pixel is at an edge where it differs from a neighbour to the left, right, above or below:
/// - one shows a surface and the other none, or the surface of another layer;
/// - their normals are more than 26 degrees apart (cosine below 0.9);
/// - the distances of three pixels in a row differ by two widths of a pixel from those of a plane;
/// - a colour differs by more than 1/16, on a scale where light is squared (a sixteenth of the way from black to white
///   as one sees it).
/// Wherever one straight edge passes through a pixel, the pixel or its neighbour across the edge shows the other side,
/// so it is found; what is thinner than a pixel and hit by no middle is not.
///
/// Such a pixel gets 16 samples, and twice as many again as long as the samples differ by more than 1/16, in a colour
/// on that scale or in alpha, up to the most that was asked for. Its colour is the mean of all its samples, in linear
/// light.
class EdgeSamples {
 public:
  /// Makes the frame note which layer each pixel shows.
  EdgeSamples(Frame& frame, const FrameOptions& options);

  /// Those asked for and those that are compared.
  ChannelSet channels() const;

  /// Into the colours of a picture with channels(), whose rays have all been traced; the same bits for any number of
  /// threads. Where it is stopped some tiles keep one sample.
  void add_to(RenderContext::Implementation& memory, const std::stop_token& stop, Framebuffer& picture);

 private:
  struct Work;

  std::size_t pixel_at(int x, int y) const;
  float depth_measure(const Framebuffer& picture, int x, int y) const;
  bool differ(const Framebuffer& picture, std::size_t a, std::size_t b) const;
  void mark_tile(const Framebuffer& picture, const Tile& tile);
  void refine_tile(const Tile& tile, Worker& worker, Work& work, Framebuffer& picture) const;
  void trace(Worker& worker, Work& work) const;

  const Frame& frame_;
  int most_;
  int width_, height_;
  ChannelSet asked_for_;
  bool shows_surfaces_;
  double bend_;                             ///< of two pixel widths, in the measure of depths
  std::vector<std::uint8_t> first_layers_;  ///< empty: one layer
  std::vector<std::uint8_t> is_edge_;       ///< by pixel
};

}  // namespace rhoray::render
