#include "tools/view/picture_message.h"

#include <gtest/gtest.h>

#include <cstdio>  // jpeglib.h needs FILE

#include <jpeglib.h>

#include <cmath>
#include <cstdlib>

#include "formats/base/error.h"
#include "render/png.h"
#include "tests/support/expect_error.h"

namespace rhoray::tests {
namespace {

using namespace tools;

/// Grey, from black to white and beyond.
render::Framebuffer ramp(int width, int height) {
  render::Framebuffer picture(width, height, {});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 4; ++c)
        picture.color[4 * static_cast<std::size_t>(y * width + x) + static_cast<std::size_t>(c)] =
            std::pow(1.1F * static_cast<float>(y * width + x) / static_cast<float>(width * height), 2.0F);
  return picture;
}

/// The first channel of the JPEG picture in a message.
std::vector<int> decoded(const std::vector<std::byte>& message, int& width) {
  jpeg_error_mgr errors;
  jpeg_decompress_struct jpeg;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(message.data()) + picture_header_bytes,
               message.size() - picture_header_bytes);
  jpeg_read_header(&jpeg, TRUE);
  jpeg_start_decompress(&jpeg);
  width = static_cast<int>(jpeg.output_width);
  std::vector<int> pixels;
  std::vector<unsigned char> row(3 * static_cast<std::size_t>(width));
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW at = row.data();
    jpeg_read_scanlines(&jpeg, &at, 1);
    for (std::size_t x = 0; x < row.size(); x += 3) pixels.push_back(row[x]);
  }
  jpeg_finish_decompress(&jpeg);
  jpeg_destroy_decompress(&jpeg);
  return pixels;
}

TEST(PictureMessage, of_jpeg_shows_every_traced_pixel) {
  const render::Framebuffer picture = ramp(65, 48);
  for (const int spacing : {1, 2, 16}) {
    int width = 0;
    const std::vector<int> pixels = decoded(jpeg_message({.is_thinned = true, .spacing = static_cast<float>(spacing)},
                                                         picture, {.quality = 100, .has_full_color = true}),
                                            width);
    EXPECT_EQ(width, (65 + spacing - 1) / spacing);
    ASSERT_EQ(pixels.size(), static_cast<std::size_t>(width * ((48 + spacing - 1) / spacing)));
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const std::size_t x = i % static_cast<std::size_t>(width) * static_cast<std::size_t>(spacing);
      const std::size_t y = i / static_cast<std::size_t>(width) * static_cast<std::size_t>(spacing);
      const int level = render::srgb_byte(picture.color[4 * (y * 65 + x)]);
      // One level by quick conversion, one by the transform's rounding.
      EXPECT_LE(std::abs(pixels[i] - level), 2) << x << ", " << y << " at spacing " << spacing;
    }
  }
}

TEST(PictureMessage, has_a_header_that_is_read_again) {
  const PictureHeader header{.codec = Codec::png,
                             .is_thinned = true,
                             .frame = 4000000000U,
                             .request = 7,
                             .width = 4096,
                             .height = 3,
                             .trace_ms = 1.5F,
                             .spacing = 2.25F};
  std::vector<std::byte> message = png_message(header, ramp(4, 3), {});
  const PictureHeader read = read_picture_header(message);
  EXPECT_EQ(read.codec, header.codec);
  EXPECT_EQ(read.is_thinned, header.is_thinned);
  EXPECT_EQ(read.frame, header.frame);
  EXPECT_EQ(read.request, header.request);
  EXPECT_EQ(read.width, header.width);
  EXPECT_EQ(read.height, header.height);
  EXPECT_EQ(read.trace_ms, header.trace_ms);
  EXPECT_EQ(read.spacing, header.spacing);
  message.resize(picture_header_bytes - 1);
  expect_error(ErrorCode::internal, "short picture", [&] { read_picture_header(message); });
}

TEST(PictureMessage, of_values_that_are_no_numbers_has_levels) {
  render::Framebuffer picture(16, 16, {});
  const float odd[] = {NAN, -NAN, INFINITY, -INFINITY, -1, -0.0F, 1e-40F, 2};
  for (std::size_t i = 0; i < picture.color.size(); ++i) picture.color[i] = odd[i / 4 % 8];
  int width = 0;
  EXPECT_EQ(decoded(jpeg_message({}, picture, {}), width).size(), 256U);
}

}  // namespace
}  // namespace rhoray::tests
