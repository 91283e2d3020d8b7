#include "tests/library/pictures.h"

#include <gtest/gtest.h>
#include <png.h>

#include <stdexcept>

#include "tests/support/run_program.h"

namespace rhoray::tests {

PngPixels read_png(const std::filesystem::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0)
    throw std::runtime_error(path.string() + ": " + image.message);
  const bool has_alpha = (image.format & PNG_FORMAT_FLAG_ALPHA) != 0;
  image.format = has_alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  PngPixels pixels{static_cast<int>(image.width), static_cast<int>(image.height), has_alpha ? 4 : 3, {}};
  pixels.bytes.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, pixels.bytes.data(), 0, nullptr) == 0)
    throw std::runtime_error(path.string() + ": " + image.message);
  return pixels;
}

PngPixels drawn_by_program(const std::string& document, const std::filesystem::path& folder,
                           const std::string& machine) {
  write_file(folder / "drawn.json", document);
  std::vector<std::string> words{RHORAY_PROGRAM, "render",  "drawn.json", "-o",
                                 "drawn.png",    "--force", "--legend",   "off"};
  if (!machine.empty()) words.insert(words.begin(), {"env", "RHORAY_MACHINE=" + machine});
  const RunResult run = run_program(words, folder);
  EXPECT_EQ(run.exit_code, 0) << run.err << document;
  return read_png(folder / "drawn.png");
}

}  // namespace rhoray::tests
