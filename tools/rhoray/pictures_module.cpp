#include "tools/rhoray/pictures_module.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <utility>

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

/// Channels of one kind: their names, what they hold, and how a pixel's are added.
struct ExrChannels {
  std::vector<std::string> names;
  OIIO::TypeDesc type;
  std::function<void(FloatPixels&, std::size_t pixel)> add;
};

std::vector<ExrChannels> exr_channels(const render::Framebuffer& picture) {
  std::vector<ExrChannels> all;
  const auto add_numbers = [&](const char* name, const auto& channel) {
    if (!channel.empty())
      all.push_back({{name}, OIIO::TypeDesc::FLOAT, [&](FloatPixels& pixels, std::size_t pixel) {
                       pixels.add(static_cast<float>(channel[pixel]));
                     }});
  };
  const auto add_counts = [&](const char* name, const auto& channel) {
    if (!channel.empty())  // no_cell becomes 2^32 - 1
      all.push_back({{name}, OIIO::TypeDesc::UINT32, [&](FloatPixels& pixels, std::size_t pixel) {
                       pixels.add(static_cast<std::uint32_t>(channel[pixel]));
                     }});
  };
  all.push_back({{"R", "G", "B", "A"}, OIIO::TypeDesc::FLOAT, [&](FloatPixels& pixels, std::size_t pixel) {
                   const float alpha = picture.color[4 * pixel + 3];
                   for (std::size_t c = 0; c < 3; ++c) pixels.add(alpha * picture.color[4 * pixel + c]);
                   pixels.add(alpha);
                 }});
  add_numbers("Z", picture.depth);
  if (!picture.normal.empty())
    all.push_back({{"N.x", "N.y", "N.z"}, OIIO::TypeDesc::FLOAT, [&](FloatPixels& pixels, std::size_t pixel) {
                     for (std::size_t c = 0; c < 3; ++c) pixels.add(picture.normal[3 * pixel + c]);
                   }});
  add_numbers("value", picture.value);
  add_numbers("error", picture.error);
  add_counts("cell", picture.cell);
  add_counts("roots", picture.roots);
  add_counts("iterations", picture.iterations);
  add_counts("cost", picture.cost);
  return all;
}

Encoded encode_exr(const render::Framebuffer& picture) {
  const std::vector<ExrChannels> channels = exr_channels(picture);
  std::vector<std::string> names;
  std::vector<OIIO::TypeDesc> types;
  for (const ExrChannels& some : channels) {
    names.insert(names.end(), some.names.begin(), some.names.end());
    types.insert(types.end(), some.names.size(), some.type);
  }
  Encoded out{OIIO::ImageSpec(picture.width, picture.height, static_cast<int>(names.size()), OIIO::TypeDesc::FLOAT),
              {}};
  out.spec.channelnames = names;
  out.spec.alpha_channel = 3;
  if (!picture.depth.empty()) out.spec.z_channel = 4;
  if (types.back() != OIIO::TypeDesc(OIIO::TypeDesc::FLOAT)) out.spec.channelformats = types;  // counts come last
  out.spec.attribute("compression", "zip");
  out.spec.attribute("oiio:ColorSpace", "Linear");

  FloatPixels pixels(names.size(), picture.pixel_count());
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel)
    for (const ExrChannels& some : channels) some.add(pixels, pixel);
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
    bool is_described = false;
    for (const PictureText& text : texts)
      if (keeps_any_name || text.name == "Software")
        encoded.spec.attribute(text.name, text.value);
      else if (!std::exchange(is_described, true))
        encoded.spec.attribute("ImageDescription", text.value);
    return write(encoded, format, open_name);
  } catch (const std::exception& error) {
    return error.what();
  }
}

extern "C" __attribute__((visibility("default"))) std::string rhoray_decode_picture(const std::string& path,
                                                                                    StoredPicture& picture) noexcept {
  try {
    const auto file = OIIO::ImageInput::open(path);
    if (!file) return OIIO::geterror();
    const OIIO::ImageSpec spec = file->spec();
    if (spec.depth != 1) return "it has several layers of pixels";
    picture = {.width = spec.width, .height = spec.height, .channels = spec.channelnames, .numbers = {}};
    picture.numbers.resize(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
    if (!file->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, picture.numbers.data()))
      return file->geterror();
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace rhoray::tools
