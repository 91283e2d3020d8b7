#include "render/png.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "tests/support/expect_error.h"

namespace rhoray::render {
namespace {

/// The formula of IEC 61966-2-1.
int srgb_by_formula(float linear) {
  const double value = linear > 0 ? std::min(1.0, static_cast<double>(linear)) : 0.0;
  const double encoded = value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
  return static_cast<int>(std::lround(255 * encoded));
}

TEST(Srgb, is_the_formula_at_both_sides_of_every_step_and_at_random_numbers) {
  int steps = 0;
  for (int level = 1; level < 256; ++level) {
    std::uint32_t below = 0, from = std::bit_cast<std::uint32_t>(1.0F);
    while (from - below > 1) {
      const std::uint32_t middle = below + (from - below) / 2;
      (srgb_by_formula(std::bit_cast<float>(middle)) >= level ? from : below) = middle;
    }
    for (const std::uint32_t bits : {from - 2, from - 1, from, from + 1}) {
      const auto linear = std::bit_cast<float>(bits);
      ASSERT_EQ(srgb_byte(linear), srgb_by_formula(linear)) << linear;
      ++steps;
    }
  }
  EXPECT_EQ(steps, 4 * 255);
  std::mt19937 random(7);
  for (int i = 0; i < 1'000'000; ++i) {
    const auto linear = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (std::isnan(linear)) continue;
    ASSERT_EQ(srgb_byte(linear), srgb_by_formula(linear)) << linear;
  }
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(srgb_byte(infinity), 255);
  EXPECT_EQ(srgb_byte(-infinity), 0);
  EXPECT_EQ(srgb_byte(std::nanf("")), 0);
  EXPECT_EQ(srgb_byte(-0.0F), 0);
}

/// A picture with every level, and some values outside the range.
Framebuffer slope(int width, int height) {
  Framebuffer picture(width, height, {});
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel)
    for (std::size_t c = 0; c < 4; ++c)
      // Alpha is not written to the file.
      picture.color[4 * pixel + c] = 1.2F * static_cast<float>((pixel * (c + 1)) % 1009) / 1009 - 0.1F;
  return picture;
}

TEST(Srgb, of_a_picture_without_background_keeps_alpha_apart_from_colours) {
  Framebuffer picture(5, 1, {});
  picture.is_transparent = true;
  picture.color = {0,    0,     0,    0,       // nothing
                   0.25, 0.5,   0.75, 1,       // opaque
                   0.1F, 0.2F,  0.4F, 0.4F,    // 255 * 0.4 = 102
                   0.7F, 0,     0,    0.5F,    // brighter than white: alpha grows to 179 of 255
                   0,    1e-4F, 0,    1e-4F};  // not lost
  const std::vector<std::uint8_t> bytes = srgb_bytes(picture);
  ASSERT_EQ(bytes.size(), 20U);
  const auto pixel = [&](std::size_t at) { return std::vector(bytes.begin() + 4 * at, bytes.begin() + 4 * at + 4); };
  const auto code = [](float linear) { return static_cast<std::uint8_t>(srgb_by_formula(linear)); };
  EXPECT_THAT(pixel(0), testing::ElementsAre(0, 0, 0, 0));
  EXPECT_THAT(pixel(1), testing::ElementsAre(code(0.25F), code(0.5F), code(0.75F), 255));
  EXPECT_THAT(pixel(2), testing::ElementsAre(code(0.25F), code(0.5F), 255, 102));
  EXPECT_THAT(pixel(3), testing::ElementsAre(code(0.7F * 255 / 179), 0, 0, 179));
  EXPECT_THAT(pixel(4), testing::ElementsAre(0, code(0.0255F), 0, 1));
}

struct Chunk {
  std::string type, data;
};

std::vector<Chunk> chunks_of(const std::vector<std::byte>& file) {
  const std::string bytes(reinterpret_cast<const char*>(file.data()), file.size());
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
    return value;
  };
  std::vector<Chunk> chunks;
  for (std::size_t at = 8; at < bytes.size();) {
    const std::size_t size = number(at);
    chunks.push_back({bytes.substr(at + 4, 4), bytes.substr(at + 8, size)});
    at += 12 + size;
  }
  return chunks;
}

std::vector<std::string> data_of(const std::vector<Chunk>& chunks, const std::string& type) {
  std::vector<std::string> all;
  for (const Chunk& chunk : chunks)
    if (chunk.type == type) all.push_back(chunk.data);
  return all;
}

TEST(EncodePng, reads_back_to_the_same_pixels) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {257, 63}}) {
    const Framebuffer picture = slope(width, height);
    const std::vector<std::byte> file = encode_png(picture, {});
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    ASSERT_EQ(png_image_begin_read_from_memory(&image, file.data(), file.size()), 1) << image.message;
    EXPECT_EQ(image.width, static_cast<unsigned>(width));
    EXPECT_EQ(image.height, static_cast<unsigned>(height));
    EXPECT_EQ(image.format, static_cast<unsigned>(PNG_FORMAT_RGB)) << "8 bits, no alpha, no palette";
    std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
    ASSERT_EQ(png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr), 1) << image.message;
    EXPECT_EQ(pixels, srgb_bytes(picture));
    EXPECT_EQ(encode_png(picture, {}), file) << "the same input gave other bytes";
  }
}

TEST(EncodePng, keeps_texts_and_says_that_it_is_srgb) {
  const std::string machine_letters = "a\xc3\xa4\xe2\x82\xac";
  const PngText texts[] = {{"Software", "rhoray 0.1.0"},
                           {"rhoray:command", std::string(200'000, 'x')},
                           {"Description", machine_letters},
                           {"Empty", ""}};
  const std::vector<Chunk> chunks = chunks_of(encode_png(slope(4, 4), texts));
  EXPECT_THAT(
      data_of(chunks, "tEXt"),
      testing::ElementsAre(std::string("Software\0rhoray 0.1.0", 21),
                           std::string("rhoray:command\0", 15) + std::string(200'000, 'x'), std::string("Empty\0", 6)));
  EXPECT_THAT(data_of(chunks, "iTXt"),
              testing::ElementsAre(std::string("Description\0\0\0\0\0", 16) + machine_letters));
  EXPECT_EQ(data_of(chunks, "sRGB").size(), 1U);
  EXPECT_EQ(data_of(chunks, "gAMA").size(), 1U);
  EXPECT_EQ(data_of(chunks, "tIME").size(), 0U) << "a time makes other bytes each time";
  EXPECT_EQ(chunks.back().type, "IEND");
}

TEST(EncodePng, refuses_what_the_format_cannot_hold) {
  tests::expect_error(ErrorCode::internal, "PNG", [] { encode_png(Framebuffer(), {}); });
  for (const std::string& keyword : {std::string(), std::string(80, 'k'), std::string(" space")})
    tests::expect_error(ErrorCode::internal, "PNG", [&] {
      const PngText text{keyword, "text"};
      encode_png(slope(2, 2), {&text, 1});
    });
}

}  // namespace
}  // namespace rhoray::render
