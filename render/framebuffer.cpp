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

Framebuffer::Framebuffer(int picture_width, int picture_height, const ChannelSet& channels)
    : width(picture_width), height(picture_height) {
  color.resize(4 * pixel_count());
  if (channels.depth) depth.resize(pixel_count());
  if (channels.normal) normal.resize(3 * pixel_count());
  if (channels.cell) cell.resize(pixel_count());
  if (channels.value) value.resize(pixel_count());
  if (channels.error) error.resize(pixel_count());
  if (channels.roots) roots.resize(pixel_count());
  if (channels.iterations) iterations.resize(pixel_count());
  if (channels.cost) cost.resize(pixel_count());
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
