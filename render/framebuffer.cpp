#include "render/framebuffer.h"

#include <sys/mman.h>

#include <new>

namespace rhoray::render {

namespace {

constexpr std::size_t large_page = std::size_t{2} << 20;

std::align_val_t alignment_of(std::size_t bytes) {
  return std::align_val_t{bytes < large_page ? 64 : large_page};
}

}  // namespace

void* allocate_pixels(std::size_t bytes) {
  void* const pixels = ::operator new(bytes, alignment_of(bytes));
  if (bytes >= large_page) ::madvise(pixels, bytes, MADV_HUGEPAGE);  // without them the pages stay small
  return pixels;
}

void free_pixels(void* pixels, std::size_t bytes) {
  ::operator delete(pixels, alignment_of(bytes));
}

ChannelSet& ChannelSet::operator|=(const ChannelSet& other) {
  depth |= other.depth;
  normal |= other.normal;
  cell |= other.cell;
  value |= other.value;
  error |= other.error;
  roots |= other.roots;
  iterations |= other.iterations;
  cost |= other.cost;
  return *this;
}

Framebuffer::Framebuffer(int picture_width, int picture_height, const ChannelSet& channels) {
  reshape(picture_width, picture_height, channels);
}

void Framebuffer::reshape(int picture_width, int picture_height, const ChannelSet& channels) {
  width = picture_width, height = picture_height;
  color.resize(4 * pixel_count());
  depth.resize(channels.depth ? pixel_count() : 0);
  normal.resize(channels.normal ? 3 * pixel_count() : 0);
  cell.resize(channels.cell ? pixel_count() : 0);
  value.resize(channels.value ? pixel_count() : 0);
  error.resize(channels.error ? pixel_count() : 0);
  roots.resize(channels.roots ? pixel_count() : 0);
  iterations.resize(channels.iterations ? pixel_count() : 0);
  cost.resize(channels.cost ? pixel_count() : 0);
}

void Framebuffer::keep(const ChannelSet& channels) {
  if (!channels.depth) depth.clear();
  if (!channels.normal) normal.clear();
  if (!channels.cell) cell.clear();
  if (!channels.value) value.clear();
  if (!channels.error) error.clear();
  if (!channels.roots) roots.clear();
  if (!channels.iterations) iterations.clear();
  if (!channels.cost) cost.clear();
}

}  // namespace rhoray::render
