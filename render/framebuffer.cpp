#include "render/framebuffer.h"

namespace rhoray::render {

Framebuffer::Framebuffer(int picture_width, int picture_height, const ChannelSet& channels)
    : width(picture_width), height(picture_height) {
  color.resize(4 * pixel_count());
  if (channels.depth) depth.resize(pixel_count());
  if (channels.normal) normal.resize(3 * pixel_count());
  if (channels.cell) cell.resize(pixel_count());
  if (channels.value) value.resize(pixel_count());
}

}  // namespace rhoray::render
