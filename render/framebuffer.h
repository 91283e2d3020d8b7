#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <vector>

namespace rhoray::render {

/// What may be kept of every pixel beside its colour.
struct ChannelSet {
  bool depth = false;   ///< distance from the eye along the ray, world units; infinity where nothing is hit
  bool normal = false;  ///< unit normal in world axes, towards the eye; 0 where nothing is hit or the field is flat
  bool cell =
      false;  ///< id of the hit cell: (k * cells.y + j) * cells.x + i in a grid, position in the source of a mesh
  bool value = false;       ///< value at the hit: isovalue, or the largest value; NaN where nothing is hit
  bool error = false;       ///< how far depth (of a largest value: the value) may be off; NaN where nothing is proven
  bool roots = false;       ///< crossings on the ray's way through the hit cell; 0 where nothing is hit
  bool iterations = false;  ///< steps that refined the root
  bool cost = false;        ///< macrocells and cells visited for the pixel

  ChannelSet& operator|=(const ChannelSet& other);
  friend bool operator==(const ChannelSet&, const ChannelSet&) = default;
  bool any() const { return *this != ChannelSet{}; }
};

/// Places numbers at the beginning of a cache line.
template <class T>
struct OnCacheLines {
  using value_type = T;

  OnCacheLines() = default;
  template <class U>
  explicit OnCacheLines(const OnCacheLines<U>&) {}

  T* allocate(std::size_t count) { return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{64})); }
  void deallocate(T* place, std::size_t) { ::operator delete (place, std::align_val_t{64}); }

  friend bool operator==(const OnCacheLines&, const OnCacheLines&) { return true; }
};

/// A picture, rows from the top, pixels from the left. Channels that were not asked for stay empty.
struct Framebuffer {
  static constexpr std::uint64_t no_cell = std::numeric_limits<std::uint64_t>::max();

  Framebuffer() = default;
  Framebuffer(int picture_width, int picture_height, const ChannelSet& channels);

  /// Makes room for another picture. Where size and channels stay, the memory stays, with the numbers in it.
  void reshape(int picture_width, int picture_height, const ChannelSet& channels);

  /// Gives up the channels that are not in the set.
  void keep(const ChannelSet& channels);

  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }

  int width = 0;
  int height = 0;
  std::array<float, 3> background{1, 1, 1};  ///< linear RGB, behind what is hit
  /// Linear RGBA, 4 per pixel, over the background; alpha is how much of the pixel something hides: 1 where something
  /// opaque is hit, else 0.
  std::vector<float, OnCacheLines<float>> color;
  std::vector<float> depth;                            ///< 1 per pixel
  std::vector<float> normal;                           ///< 3 per pixel
  std::vector<std::uint64_t> cell;                     ///< 1 per pixel
  std::vector<double> value;                           ///< 1 per pixel
  std::vector<float> error;                            ///< 1 per pixel
  std::vector<std::uint32_t> roots, iterations, cost;  ///< 1 per pixel each
};

}  // namespace rhoray::render
