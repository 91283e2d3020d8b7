#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace rhoray::render {

/// The optional channels of a pixel, in addition to its colour.
struct ChannelSet {
  /// Distance from the eye along the ray, world units; infinity where nothing is hit.
  bool depth = false;
  /// Unit normal in world axes, towards the eye; 0 where nothing is hit or the field is flat.
  bool normal = false;
  /// Id of the hit cell: (k * cells.y + j) * cells.x + i in a grid, index in the source file for a
  /// mesh.
  bool cell = false;
  /// Value at the hit: isovalue, or the largest value; NaN where nothing is hit.
  bool value = false;
  /// Error bound of depth (for a largest value: of the value); NaN where nothing is proven.
  bool error = false;
  bool roots = false;       ///< crossings along the ray inside the hit cell; 0 where nothing is hit
  bool iterations = false;  ///< refinement steps of the root
  bool cost = false;        ///< macrocells and cells visited for the pixel

  ChannelSet& operator|=(const ChannelSet& other);
  friend bool operator==(const ChannelSet&, const ChannelSet&) = default;
  bool any() const { return *this != ChannelSet{}; }
};

/// Memory for pixels, aligned to cache lines. From some size on it stands in large pages, where the
/// system has them: writing to a new page for the first time takes longer than tracing what it
/// shows.
void* allocate_pixels(std::size_t bytes);
void free_pixels(void* pixels, std::size_t bytes);  ///< takes the size that was allocated

template <class T>
struct PixelAllocator {
  using value_type = T;

  PixelAllocator() = default;
  template <class U>
  explicit PixelAllocator(const PixelAllocator<U>&) {}

  T* allocate(std::size_t count) { return static_cast<T*>(allocate_pixels(count * sizeof(T))); }
  void deallocate(T* pixels, std::size_t count) { free_pixels(pixels, count * sizeof(T)); }

  friend bool operator==(const PixelAllocator&, const PixelAllocator&) { return true; }
};

/// A picture, rows from the top, pixels from the left. Channels that were not requested stay empty.
struct Framebuffer {
  static constexpr std::uint64_t no_cell = std::numeric_limits<std::uint64_t>::max();

  Framebuffer() = default;
  Framebuffer(int picture_width, int picture_height, const ChannelSet& channels);

  /// Changes size and channels. When both stay the same, the memory and its contents stay too.
  void reshape(int picture_width, int picture_height, const ChannelSet& channels);

  /// Frees the channels that are not in the set.
  void keep(const ChannelSet& channels);

  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }

  int width = 0;
  int height = 0;
  std::array<float, 3> background{1, 1, 1};  ///< linear RGB, behind all hits
  bool is_transparent = false;               ///< nothing is behind; `background` is black, and files keep alpha
  /// Linear RGBA, 4 per pixel, over the background. Alpha is the part of the pixel that is covered:
  /// 1 where something opaque is hit, else 0.
  std::vector<float, PixelAllocator<float>> color;
  std::vector<float> depth;                            ///< 1 per pixel
  std::vector<float> normal;                           ///< 3 per pixel
  std::vector<std::uint64_t> cell;                     ///< 1 per pixel
  std::vector<double> value;                           ///< 1 per pixel
  std::vector<float> error;                            ///< 1 per pixel
  std::vector<std::uint32_t> roots, iterations, cost;  ///< 1 per pixel each
};

}  // namespace rhoray::render
