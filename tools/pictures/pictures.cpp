#include "tools/pictures/pictures.h"

#include <dlfcn.h>

#include <algorithm>
#include <utility>

#include "formats/base/component_file.h"
#include "formats/base/error.h"
#include "formats/base/library_text.h"
#include "formats/base/lower_case.h"
#include "formats/base/pending_file.h"
#include "formats/base/word_list.h"
#include "preprocess/input_file.h"
#include "render/png.h"
#include "tools/pictures/pictures_module.h"

namespace rhoray::tools {

namespace {

/// An extension, and OpenImageIO's name of its format.
struct PictureFormat {
  std::string_view extension, name;
};
constexpr PictureFormat picture_formats[] = {{".png", "png"},   {".exr", "openexr"}, {".tif", "tiff"},
                                             {".tiff", "tiff"}, {".jpg", "jpeg"},    {".jpeg", "jpeg"}};

/// OpenImageIO's name of the format, or nothing.
std::string format_of(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  for (const auto& [known, name] : picture_formats)
    if (extension == known) return std::string(name);
  return {};
}

/// Loads a function of the module.
template <class Act>
Act* load(const char* name) {
  require_pictures_module();
  void* const handle = ::dlopen(ComponentFile(pictures_module).path().c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const symbol = handle == nullptr ? nullptr : ::dlsym(handle, name);
  if (symbol == nullptr)
    throw Error(ErrorCode::unsupported, concat("the module for pictures cannot be loaded: ", ::dlerror()));
  return reinterpret_cast<Act*>(symbol);
}

void require_ids_that_fit(const render::Framebuffer& picture, const std::filesystem::path& path) {
  constexpr std::uint64_t limit = 0xffff'ffff;  // this value itself means: no cell
  for (const std::uint64_t id : picture.cell)
    if (id >= limit && id != render::Framebuffer::no_cell)
      throw Error(ErrorCode::unsupported,
                  concat(path.string(), ": channel 'cell': found id ", id, "; EXR holds ids below ", limit),
                  "leave 'cell' out of --channels");
}

}  // namespace

void require_pictures_module() {
  if (const ComponentFile file(pictures_module); !file.exists())
    throw Error(ErrorCode::unsupported, concat("this needs ", file.missing_text()),
                concat(file.hint(), "; PNG pictures without annotations are written without it"));
}

bool can_annotate() {
  std::error_code ignored;
  return ComponentFile(pictures_module).exists() &&
         std::any_of(known_fonts().begin(), known_fonts().end(),
                     [&](const auto& font) { return std::filesystem::is_regular_file(font, ignored); });
}

std::vector<std::string> picture_extensions() {
  return names_in(picture_formats, &PictureFormat::extension);
}

void require_picture_format(const std::filesystem::path& path, const render::ChannelSet& channels, bool has_alpha) {
  const std::string format = format_of(path);
  if (format.empty())
    throw Error(ErrorCode::usage, concat(path.string(), ": found extension '", path.extension().string(),
                                         "'; expected .png, .exr, .tif, .tiff, .jpg or .jpeg"));
  if (channels.any() && format != "openexr")
    throw Error(ErrorCode::usage, concat(path.string(), ": only EXR stores --channels"),
                "use a file name ending in .exr");
  if (has_alpha && format == "jpeg")
    throw Error(ErrorCode::usage, concat(path.string(), ": JPEG stores no alpha, which background none needs"),
                "use a file name ending in .png, .tif or .exr");
  if (format != "png") require_pictures_module();
}

std::vector<std::byte> encode_picture(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                                      const std::filesystem::path& path) {
  const std::string format = format_of(path);
  if (format == "png") {
    std::vector<render::PngText> png_texts;
    for (const auto& [name, value] : texts) png_texts.push_back({name, value});
    return render::encode_png(picture, png_texts);
  }
  require_ids_that_fit(picture, path);
  const std::vector<std::uint8_t> srgb =
      format == "openexr" ? std::vector<std::uint8_t>() : render::srgb_bytes(picture);
  std::vector<std::byte> bytes;
  const std::string reason = load<EncodePicture>(encode_picture_symbol)(picture, srgb, texts, format, bytes);
  if (!reason.empty()) {
    note_library_text(reason);
    throw Error(ErrorCode::resource, concat(path.string(), ": OpenImageIO cannot write the picture"),
                "-v prints the reason that it gives");
  }
  return bytes;
}

void write_picture(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                   const std::filesystem::path& path, bool replace_existing) {
  write_whole_file(path, encode_picture(picture, texts, path), replace_existing);
}

const std::vector<std::filesystem::path>& known_fonts() {
  static const std::vector<std::filesystem::path> fonts{
      "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",    // Debian, Ubuntu
      "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",  // Fedora
      "/usr/share/fonts/TTF/DejaVuSans.ttf",                // Arch
      "/usr/share/fonts/dejavu/DejaVuSans.ttf"};
  return fonts;
}

std::filesystem::path find_font(const std::vector<std::filesystem::path>& known_fonts) {
  std::error_code ignored;
  for (const std::filesystem::path& font : known_fonts)
    if (std::filesystem::is_regular_file(font, ignored)) return font;
  throw Error(ErrorCode::unsupported,
              concat("annotations need the font DejaVu Sans; there is no ", known_fonts.front().string()),
              "on Debian, install the package fonts-dejavu-core");
}

TextImage make_text_image(const std::string& text, int pixels, const std::filesystem::path& font) {
  static const auto make = load<MakeTextImage>(make_text_image_symbol);
  TextImage image;
  const std::string reason = make(text, pixels, font.string(), image);
  if (!reason.empty()) throw Error(ErrorCode::unsupported, concat(font.string(), ": ", reason));
  return image;
}

StoredPicture read_picture(const std::filesystem::path& path) {
  preprocess::require_input(path);
  StoredPicture picture;
  const std::string reason = load<DecodePicture>(decode_picture_symbol)(path.string(), picture);
  if (!reason.empty()) {
    note_library_text(reason);
    if (format_of(path).empty())  // it may be a sound file of another kind
      throw Error(ErrorCode::unsupported,
                  concat(path.string(), ": is not a picture; expected ", joined(picture_extensions())));
    throw Error(ErrorCode::invalid,
                concat(path.string(), ": found no picture, or a damaged one; expected ", joined(picture_extensions())));
  }
  return picture;
}

}  // namespace rhoray::tools
