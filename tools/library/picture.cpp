#include "tools/library/picture.h"

#include <algorithm>

#include "formats/base/pending_file.h"
#include "render/png.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

Picture::Picture() = default;
Picture::~Picture() = default;
Picture::Picture(const Picture& other) : implementation_(std::make_unique<Implementation>(other.implementation())) {}
Picture::Picture(Picture&&) noexcept = default;
Picture& Picture::operator=(const Picture& other) {
  implementation() = other.implementation();
  return *this;
}
Picture& Picture::operator=(Picture&&) noexcept = default;

Picture::Implementation& Picture::implementation() {
  if (!implementation_) implementation_ = std::make_unique<Implementation>();
  return *implementation_;
}
const Picture::Implementation& Picture::implementation() const {
  static const Implementation empty;
  return implementation_ ? *implementation_ : empty;
}

Size Picture::size() const {
  return implementation().size;
}
Rect Picture::window() const {
  return implementation().window;
}
std::span<const float> Picture::color() const {
  return implementation().pixels.color;
}
std::span<const float> Picture::depth() const {
  return implementation().pixels.depth;
}
std::span<const float> Picture::normal() const {
  return implementation().pixels.normal;
}
std::span<const std::uint64_t> Picture::cell() const {
  return implementation().pixels.cell;
}
std::span<const double> Picture::value() const {
  return implementation().pixels.value;
}
std::span<const float> Picture::error() const {
  return implementation().pixels.error;
}
std::span<const std::uint32_t> Picture::cost() const {
  return implementation().pixels.cost;
}

int Picture::srgb8_channels() const {
  return implementation().pixels.is_transparent ? 4 : 3;
}

void Picture::to_srgb8(std::span<std::uint8_t> bytes) const {
  inside::guarded([&] {
    const render::Framebuffer& pixels = implementation().pixels;
    const std::size_t expected = pixels.pixel_count() * static_cast<std::size_t>(srgb8_channels());
    if (bytes.size() != expected)
      inside::refuse("Picture::to_srgb8: found room for ", bytes.size(), " bytes; expected ", expected);
    const std::vector<std::uint8_t> converted = render::srgb_bytes(pixels);
    std::copy(converted.begin(), converted.end(), bytes.begin());
  });
}

void Picture::save_png(const std::filesystem::path& path, bool replace_existing) const {
  inside::guarded([&] {
    if (implementation().pixels.pixel_count() == 0)
      inside::refuse(path.string(), ": the picture is empty; render to it first");
    write_whole_file(path, render::encode_png(implementation().pixels, {}), replace_existing);
  });
}

}  // namespace rhoray::v0_1
