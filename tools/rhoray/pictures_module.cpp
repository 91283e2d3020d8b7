#include "tools/rhoray/pictures_module.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace rhoray::tools {

namespace {

/// Linear to 8-bit sRGB (IEC 61966-2-1); outside [0, 1], and NaN, to the nearest end.
std::uint8_t srgb_byte(float linear) {
  const double value = linear > 0 ? std::min(1.0, static_cast<double>(linear)) : 0.0;
  const double encoded = value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

/// Something that can be written: how it looks, and its bytes, pixel by pixel.
struct Encoded {
  OIIO::ImageSpec spec;
  std::vector<std::uint8_t> bytes;
};

Encoded encode_8_bit(const render::Framebuffer& picture) {
  Encoded out{OIIO::ImageSpec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8), {}};
  out.spec.attribute("oiio:ColorSpace", "sRGB");
  out.bytes.reserve(3 * picture.pixel_count());
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel)
    for (std::size_t c = 0; c < 3; ++c) out.bytes.push_back(srgb_byte(picture.color[4 * pixel + c]));
  return out;
}

/// Adds pixels whose channels are 32 bits each, of two types, side by side.
class FloatPixels {
 public:
  explicit FloatPixels(std::size_t channel_count, std::size_t pixel_count) : bytes_(4 * channel_count * pixel_count) {}

  template <class T>
  void add(T value) {
    static_assert(sizeof(T) == 4);
    std::memcpy(bytes_.data() + position_, &value, 4);
    position_ += 4;
  }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t position_ = 0;
};

std::vector<std::string> exr_channels(const render::Framebuffer& picture) {
  std::vector<std::string> names{"R", "G", "B", "A"};
  if (!picture.depth.empty()) names.push_back("Z");
  if (!picture.normal.empty()) names.insert(names.end(), {"N.x", "N.y", "N.z"});
  if (!picture.value.empty()) names.push_back("value");
  if (!picture.cell.empty()) names.push_back("cell");
  return names;
}

Encoded encode_exr(const render::Framebuffer& picture) {
  const std::vector<std::string> names = exr_channels(picture);
  Encoded out{OIIO::ImageSpec(picture.width, picture.height, static_cast<int>(names.size()), OIIO::TypeDesc::FLOAT),
              {}};
  out.spec.channelnames = names;
  out.spec.alpha_channel = 3;
  if (!picture.depth.empty()) out.spec.z_channel = 4;
  if (!picture.cell.empty()) {
    out.spec.channelformats.assign(names.size(), OIIO::TypeDesc::FLOAT);
    out.spec.channelformats.back() = OIIO::TypeDesc::UINT32;
  }
  out.spec.attribute("compression", "zip");
  out.spec.attribute("oiio:ColorSpace", "Linear");

  FloatPixels pixels(names.size(), picture.pixel_count());
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel) {
    const float alpha = picture.color[4 * pixel + 3];
    for (std::size_t c = 0; c < 3; ++c) pixels.add(alpha * picture.color[4 * pixel + c]);
    pixels.add(alpha);
    if (!picture.depth.empty()) pixels.add(picture.depth[pixel]);
    if (!picture.normal.empty())
      for (std::size_t c = 0; c < 3; ++c) pixels.add(picture.normal[3 * pixel + c]);
    if (!picture.value.empty()) pixels.add(static_cast<float>(picture.value[pixel]));
    if (!picture.cell.empty()) pixels.add(static_cast<std::uint32_t>(picture.cell[pixel]));  // no_cell becomes 2^32 - 1
  }
  out.bytes = pixels.take();
  return out;
}

std::string write(const Encoded& encoded, const std::string& format, const std::string& open_name) {
  const auto file = OIIO::ImageOutput::create(format);
  if (!file) return OIIO::geterror();
  if (!file->open(open_name, encoded.spec)) return file->geterror();
  const bool mixed = !encoded.spec.channelformats.empty();
  const OIIO::TypeDesc given = mixed ? OIIO::TypeDesc(OIIO::TypeDesc::UNKNOWN) : encoded.spec.format;  // as they lie
  if (!file->write_image(given, encoded.bytes.data())) return file->geterror();
  if (!file->close()) return file->geterror();
  return {};
}

}  // namespace

extern "C" __attribute__((visibility("default"))) std::string rhoray_encode_picture(
    const render::Framebuffer& picture, const std::vector<PictureText>& texts, const std::string& format,
    const std::string& open_name) noexcept {
  try {
    Encoded encoded = format == "openexr" ? encode_exr(picture) : encode_8_bit(picture);
    if (format == "jpeg") encoded.spec.attribute("compression", "jpeg:95");
    encoded.spec.attribute("DateTime",
                           "1970:01:01 00:00:00");  // else EXR and TIFF get the time, and other bytes each time
    const bool keeps_any_name = format == "png" || format == "openexr";
    for (const PictureText& text : texts)
      encoded.spec.attribute(keeps_any_name || text.name == "Software" ? text.name : "ImageDescription", text.value);
    return write(encoded, format, open_name);
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace rhoray::tools
