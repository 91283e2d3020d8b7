#include "tools/library/picture.h"

#include <algorithm>

#include "formats/base/pending_file.h"
#include "render/png.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

Picture::Picture() : implementation_(std::make_unique<Implementation>()) {}
Picture::~Picture() = default;
Picture::Picture(const Picture& other) : implementation_(std::make_unique<Implementation>(*other.implementation_)) {}
// What was moved from is an empty picture, not a null pointer.
Picture::Picture(Picture&& other) noexcept : Picture() {
  implementation_.swap(other.implementation_);
}
Picture& Picture::operator=(const Picture& other) {
  *implementation_ = *other.implementation_;
  return *this;
}
Picture& Picture::operator=(Picture&& other) noexcept {
  implementation_.swap(other.implementation_);
  return *this;
}

Size Picture::size() const {
  return implementation_->size;
}
Rect Picture::window() const {
  return implementation_->window;
}
std::span<const float> Picture::color() const {
  return implementation_->pixels.color;
}
std::span<const float> Picture::depth() const {
  return implementation_->pixels.depth;
}
std::span<const float> Picture::normal() const {
  return implementation_->pixels.normal;
}
std::span<const std::uint64_t> Picture::cell() const {
  return implementation_->pixels.cell;
}
std::span<const double> Picture::value() const {
  return implementation_->pixels.value;
}
std::span<const float> Picture::error() const {
  return implementation_->pixels.error;
}
std::span<const std::uint32_t> Picture::cost() const {
  return implementation_->pixels.cost;
}

int Picture::srgb8_channels() const {
  return implementation_->pixels.is_transparent ? 4 : 3;
}

void Picture::to_srgb8(std::span<std::uint8_t> bytes) const {
  inside::guarded([&] {
    const render::Framebuffer& pixels = implementation_->pixels;
    const std::size_t expected = pixels.pixel_count() * static_cast<std::size_t>(srgb8_channels());
    if (bytes.size() != expected)
      inside::refuse("Picture::to_srgb8: found room for ", bytes.size(), " bytes; expected ", expected);
    const std::vector<std::uint8_t> converted = render::srgb_bytes(pixels);
    std::copy(converted.begin(), converted.end(), bytes.begin());
  });
}

void Picture::save_png(const std::filesystem::path& path, bool replace_existing) const {
  inside::guarded([&] {
    if (implementation_->pixels.pixel_count() == 0)
      inside::refuse(path.string(), ": the picture is empty; render to it first");
    write_whole_file(path, render::encode_png(implementation_->pixels, {}), replace_existing);
  });
}

}  // namespace rhoray::v0_1
