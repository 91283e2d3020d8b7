#include "render/framebuffer.h"

namespace rhoray::render {

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
