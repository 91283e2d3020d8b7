#include "tools/view/picture_message.h"

#include <cstdio>  // jpeglib.h needs FILE

#include <jpeglib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "render/png.h"
#include "tools/pictures/pictures.h"

namespace rhoray::tools {

namespace {

template <class Number>
void append(Number number, std::vector<std::byte>& bytes) {
  std::byte raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);  // little-endian machines only, as packed files
  bytes.insert(bytes.end(), raw, raw + sizeof number);
}

std::vector<std::byte> started(const PictureHeader& header) {
  std::vector<std::byte> bytes;
  append(std::uint8_t{1}, bytes);
  append(static_cast<std::uint8_t>(header.codec), bytes);
  append(static_cast<std::uint16_t>(header.is_thinned), bytes);
  append(header.frame, bytes);
  append(header.request, bytes);
  append(static_cast<std::uint16_t>(header.width), bytes);
  append(static_cast<std::uint16_t>(header.height), bytes);
  append(header.trace_ms, bytes);
  append(header.spacing, bytes);
  return bytes;
}

[[noreturn]] void refuse(j_common_ptr info) {
  char text[JMSG_LENGTH_MAX];
  info->err->format_message(info, text);
  throw Error(ErrorCode::internal, concat("libjpeg: ", text));
}

/// 8-bit sRGB for JPEG, which loses more. It is faster than render::srgb_byte; some values within
/// 2^-11 of the next level get one level less.
class QuickSrgb {
 public:
  QuickSrgb() {
    for (std::uint32_t i = 0; i < levels_.size(); ++i)
      levels_[i] = render::srgb_byte(std::bit_cast<float>((first_ + i) << dropped_bits));
  }

  std::uint8_t operator()(float linear) const {
    const auto bits = std::bit_cast<std::int32_t>(linear);  // ordered like floats that are not negative
    return levels_[static_cast<std::size_t>(std::clamp(bits, least_, most_) - least_) >> dropped_bits];
  }

 private:
  static constexpr int dropped_bits = 12;
  static constexpr std::int32_t least_ = std::bit_cast<std::int32_t>(0x1p-14F);  // level 0
  static constexpr std::int32_t most_ = std::bit_cast<std::int32_t>(1.0F);
  static constexpr std::uint32_t first_ = static_cast<std::uint32_t>(least_) >> dropped_bits;

  std::array<std::uint8_t, (static_cast<std::uint32_t>(most_ - least_) >> dropped_bits) + 1> levels_{};
};

/// Every s-th pixel of every s-th row, as 8-bit sRGB.
std::vector<std::uint8_t> thinned(const render::Framebuffer& picture, int spacing, int& width, int& height) {
  static const QuickSrgb quick_srgb;
  width = (picture.width + spacing - 1) / spacing, height = (picture.height + spacing - 1) / spacing;
  std::vector<std::uint8_t> rgb(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  std::uint8_t* out = rgb.data();
  for (int y = 0; y < picture.height; y += spacing) {
    const float* pixel =
        picture.color.data() + 4 * static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width);
    for (int x = 0; x < picture.width; x += spacing, pixel += 4 * static_cast<std::ptrdiff_t>(spacing))
      for (int c = 0; c < 3; ++c) *out++ = quick_srgb(pixel[c]);
  }
  return rgb;
}

}  // namespace

PictureHeader read_picture_header(std::span<const std::byte> message) {
  if (message.size() < picture_header_bytes) throw Error(ErrorCode::internal, "the viewer sent a short picture");
  PictureHeader header;
  const auto read = [&](std::size_t at, auto number) {
    std::memcpy(&number, message.data() + at, sizeof number);
    return number;
  };
  header.codec = static_cast<Codec>(read(1, std::uint8_t{}));
  header.is_thinned = read(2, std::uint16_t{}) != 0;
  header.frame = read(4, std::uint32_t{});
  header.request = read(8, std::uint32_t{});
  header.width = read(12, std::uint16_t{});
  header.height = read(14, std::uint16_t{});
  header.trace_ms = read(16, float{});
  header.spacing = read(20, float{});
  return header;
}

std::vector<std::byte> jpeg_message(const PictureHeader& header, const render::Framebuffer& picture,
                                    const JpegQuality& quality) {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb =
      thinned(picture, header.is_thinned ? static_cast<int>(header.spacing) : 1, width, height);
  jpeg_error_mgr errors;
  jpeg_compress_struct jpeg;
  jpeg.err = jpeg_std_error(&errors);
  errors.error_exit = refuse;
  jpeg_create_compress(&jpeg);
  const std::unique_ptr<jpeg_compress_struct, void (*)(jpeg_compress_struct*)> ending(
      &jpeg, [](jpeg_compress_struct* each) { jpeg_destroy_compress(each); });
  unsigned char* encoded = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &encoded, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width), jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = 3, jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality.quality, TRUE);
  if (!quality.has_full_color) jpeg.dct_method = JDCT_IFAST;  // faster, less exact
  if (quality.has_full_color) jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = rgb.data() + 3 * static_cast<std::size_t>(width) * jpeg.next_scanline;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  const std::unique_ptr<unsigned char, void (*)(void*)> owner(encoded, std::free);
  std::vector<std::byte> message = started(header);
  const auto* begin = reinterpret_cast<const std::byte*>(encoded);
  message.insert(message.end(), begin, begin + size);
  return message;
}

std::vector<std::byte> png_message(const PictureHeader& header, const render::Framebuffer& picture,
                                   const std::vector<PictureText>& texts) {
  std::vector<std::byte> message = started(header);
  const std::vector<std::byte> png = encode_picture(picture, texts, "picture.png");
  message.insert(message.end(), png.begin(), png.end());
  return message;
}

}  // namespace rhoray::tools
