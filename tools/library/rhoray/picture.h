#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "rhoray/export.h"
#include "rhoray/types.h"

namespace rhoray::RHORAY_ABI {

/// Optional channels of a picture, besides its colour.
struct ChannelSet {
  bool depth = false, normal = false, cell = false, value = false, error = false;
  bool cost = false;

  friend bool operator==(const ChannelSet&, const ChannelSet&) = default;
};

/// The cell of pixels that show nothing.
inline constexpr std::uint64_t no_cell = ~std::uint64_t{0};

/// A picture, or a window of it: rows from the top, pixels from the left. Spans stay valid until
/// the picture is rendered to again or destroyed. One render writes to it at a time; memory is kept
/// while size and channels stay the same. A moved-from picture is empty.
class RHORAY_API Picture {
 public:
  Picture();
  ~Picture();
  Picture(const Picture&);
  Picture(Picture&&) noexcept;
  Picture& operator=(const Picture&);
  Picture& operator=(Picture&&) noexcept;

  Size size() const;    ///< of the whole picture; 0 x 0 before the first render
  Rect window() const;  ///< the pixels of the whole picture that are here

  // The window gives the shapes: [height, width, ...]. A channel that was not asked for is
  // empty.

  /// [height, width, 4]: linear RGB over the background, and alpha: the covered part of the pixel.
  std::span<const float> color() const;
  /// Distance from the eye along the ray, world units; infinity where nothing is hit.
  std::span<const float> depth() const;
  /// [height, width, 3]: unit normals towards the eye, world axes; 0 where nothing is hit.
  std::span<const float> normal() const;
  /// Id of the cell that is hit, else no_cell. Grid: (k * cells_y + j) * cells_x + i. Mesh: index
  /// in the source.
  std::span<const std::uint64_t> cell() const;
  /// The field at the hit; NaN where nothing is hit.
  std::span<const double> value() const;
  /// Proven bound on the error of depth (of a largest value: of value); NaN where nothing is
  /// proven.
  std::span<const float> error() const;
  /// Macrocells and cells that were visited for the pixel.
  std::span<const std::uint32_t> cost() const;

  /// Writes red, green and blue as 8-bit sRGB over the background, [height, width, 3]. A picture
  /// without a background has alpha as the fourth byte, [height, width, 4]; its colours are not
  /// multiplied by alpha. Throws ErrorCode::usage for another number of bytes.
  void to_srgb8(std::span<std::uint8_t> bytes) const;
  int srgb8_channels() const;  ///< 3, or 4 without a background

  /// Writes a PNG file of these bytes. The file is complete or absent.
  /// Throws ErrorCode::usage for an existing file without `replace_existing` and for an empty
  /// picture; ErrorCode::resource for a full disk.
  void save_png(const std::filesystem::path& path, bool replace_existing = false) const;

  class RHORAY_INSIDE Implementation;
  Implementation& implementation();  ///< for the library's own sources
  const Implementation& implementation() const;

 private:
  std::unique_ptr<Implementation> implementation_;  ///< null: empty
};

}  // namespace rhoray::RHORAY_ABI
