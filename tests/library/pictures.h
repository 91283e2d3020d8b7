#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "rhoray/rhoray.h"

namespace rhoray::tests {

inline constexpr ChannelSet all_channels{.depth = true, .normal = true, .cell = true, .value = true, .cost = true};

/// The bytes of all channels of a picture, so that pictures with NaN compare by their bits.
inline std::string bits_of(const Picture& picture) {
  std::string bits;
  const auto add = [&](const auto& channel) {
    const auto bytes = std::as_bytes(channel);
    bits.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  add(picture.color()), add(picture.depth()), add(picture.normal()), add(picture.cell());
  add(picture.value()), add(picture.error()), add(picture.cost());
  return bits;
}

inline std::vector<std::uint8_t> srgb_of(const Picture& picture) {
  const Rect window = picture.window();
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height) *
                                  static_cast<std::size_t>(picture.srgb8_channels()));
  picture.to_srgb8(bytes);
  return bytes;
}

/// An opaque isosurface in the certified method, seen by a camera that fits.
inline Scene certified_scene(const Dataset& data, double isovalue, const Size& size) {
  Scene scene{.layers = {{.data = data, .show = Isosurface{isovalue}, .method = Accuracy::certified}}};
  scene.camera = fit_camera(scene, size);
  return scene;
}

inline Picture rendered(const Scene& scene, const RenderOptions& options, unsigned threads = 0) {
  Picture picture;
  RenderContext({.threads = threads}).render(scene, options, picture);
  return picture;
}

/// The pixels of a PNG file: [height, width, channels].
struct PngPixels {
  int width = 0, height = 0, channels = 0;
  std::vector<std::uint8_t> bytes;
};
PngPixels read_png(const std::filesystem::path& path);

/// The pixels that the program `rhoray` draws of a document, without annotations.
/// @param machine  for RHORAY_MACHINE; empty: as the tests were started
PngPixels drawn_by_program(const std::string& document, const std::filesystem::path& folder,
                           const std::string& machine = {});

}  // namespace rhoray::tests
