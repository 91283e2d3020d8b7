#include "tools/pictures/pictures_module.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>

#include "formats/base/text.h"
#include "tools/pictures/memory_file.h"

namespace rhoray::tools {

namespace {

/// A picture ready to be written: its specification, and its bytes pixel by pixel.
struct Encoded {
  OIIO::ImageSpec spec;
  std::vector<std::uint8_t> bytes;
};

Encoded encode_8_bit(const render::Framebuffer& picture, const std::vector<std::uint8_t>& srgb) {
  const int channel_count = picture.is_transparent ? 4 : 3;
  Encoded out{OIIO::ImageSpec(picture.width, picture.height, channel_count, OIIO::TypeDesc::UINT8), srgb};
  if (picture.is_transparent) out.spec.attribute("oiio:UnassociatedAlpha", 1);
  out.spec.attribute("oiio:ColorSpace", "sRGB");
  return out;
}

/// Collects pixels whose channels are 32 bits each, of two types, side by side.
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

/// Channels of one type: their names, the type, and the function that adds those of a pixel.
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
                   for (std::size_t c = 0; c < 3; ++c)
                     pixels.add(picture.color[4 * pixel + c] - (1 - alpha) * picture.background[c]);
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
  // Counts come last.
  if (types.back() != OIIO::TypeDesc(OIIO::TypeDesc::FLOAT)) out.spec.channelformats = types;
  out.spec.attribute("compression", "zip");
  out.spec.attribute("oiio:ColorSpace", "Linear");

  FloatPixels pixels(names.size(), picture.pixel_count());
  for (std::size_t pixel = 0; pixel < picture.pixel_count(); ++pixel)
    for (const ExrChannels& some : channels) some.add(pixels, pixel);
  out.bytes = pixels.take();
  return out;
}

/// Writes with an ImageOutput that `open` prepares; returns the error message, or nothing.
template <class Open>
std::string write_with(const Encoded& encoded, const std::string& format, const Open& open) {
  const auto file = OIIO::ImageOutput::create(format);
  if (!file) return OIIO::geterror();
  if (!open(*file)) return file->geterror();
  const bool mixed = !encoded.spec.channelformats.empty();
  // As stored.
  const OIIO::TypeDesc given = mixed ? OIIO::TypeDesc(OIIO::TypeDesc::UNKNOWN) : encoded.spec.format;
  if (!file->write_image(given, encoded.bytes.data())) return file->geterror();
  if (!file->close()) return file->geterror();
  return {};
}

/// Encodes in memory, because OpenImageIO and the libraries below it do not report every disk
/// error, and libjpeg ends the program.
std::string encode(const Encoded& encoded, const std::string& format, std::vector<std::byte>& bytes) {
  // OpenImageIO 2.4 loses all but the Exif part of a TIFF that it writes through a proxy: libtiff
  // reads the directory back, and its proxies give it nothing.
  if (format == "tiff") {
    const MemoryFile memory;
    std::string error_code =
        write_with(encoded, format, [&](OIIO::ImageOutput& file) { return file.open(memory.path(), encoded.spec); });
    bytes = memory.bytes();
    return error_code;
  }
  OIIO::Filesystem::IOVecOutput memory;
  std::string error_code = write_with(encoded, format, [&](OIIO::ImageOutput& file) {
    return file.set_ioproxy(&memory) && file.open("memory." + format, encoded.spec);
  });
  const auto* const first = reinterpret_cast<const std::byte*>(memory.buffer().data());
  bytes.assign(first, first + memory.buffer().size());
  return error_code;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) std::string rhoray_encode_picture(
    const render::Framebuffer& picture, const std::vector<std::uint8_t>& srgb, const std::vector<PictureText>& texts,
    const std::string& format, std::vector<std::byte>& bytes) noexcept {
  try {
    Encoded encoded = format == "openexr" ? encode_exr(picture) : encode_8_bit(picture, srgb);
    if (format == "jpeg") encoded.spec.attribute("compression", "jpeg:95");
    // Otherwise EXR and TIFF contain the current time, and the bytes differ each time.
    encoded.spec.attribute("DateTime", "1970:01:01 00:00:00");
    const bool keeps_any_name = format == "openexr";
    bool is_described = false;
    for (const PictureText& text : texts)
      if (keeps_any_name || text.name == "Software")
        encoded.spec.attribute(text.name, text.value);
      else if (!std::exchange(is_described, true))
        encoded.spec.attribute("ImageDescription", text.value);
    return encode(encoded, format, bytes);
  } catch (const std::exception& error) {
    return error.what();
  }
}

namespace {

constexpr char32_t no_letter = 0xfffd;  // stands for bytes that are not UTF-8

/// Code points of a UTF-8 text.
std::u32string letters_of(const std::string& text) {
  std::u32string letters;
  for (std::size_t at = 0; at < text.size();) {
    const auto first = static_cast<unsigned char>(text[at]);
    const std::size_t count = first < 0x80 ? 1 : first >> 5 == 6 ? 2 : first >> 4 == 14 ? 3 : first >> 3 == 30 ? 4 : 0;
    bool is_whole = count > 0 && at + count <= text.size();
    char32_t letter = count == 1 ? first : first & (0x7fU >> count);
    for (std::size_t i = 1; is_whole && i < count; ++i) {
      const auto next = static_cast<unsigned char>(text[at + i]);
      is_whole = next >> 6 == 2;
      letter = letter << 6 | (next & 0x3fU);
    }
    letters += is_whole ? letter : no_letter;
    at += is_whole ? count : 1;
  }
  return letters;
}

/// A font file, through FreeType.
class Font {
 public:
  explicit Font(const std::string& file) : file_(file) {
    if (FT_Init_FreeType(&library_) == 0 && FT_New_Face(library_, file.c_str(), 0, &face_) != 0) face_ = nullptr;
  }
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;
  ~Font() {
    if (face_ != nullptr) FT_Done_Face(face_);
    if (library_ != nullptr) FT_Done_FreeType(library_);
  }

  const std::string& file() const { return file_; }
  /// False if the file cannot be used.
  bool set_size(int pixels) const {
    return face_ != nullptr && FT_Set_Pixel_Sizes(face_, 0, static_cast<FT_UInt>(pixels)) == 0;
  }

  /// Calls act(bitmap, x, y) for every letter, with its upper left corner relative to the start of
  /// the baseline.
  template <class Act>
  void for_each_letter(const std::u32string& letters, const Act& act) const {
    FT_UInt before = 0;
    FT_Pos pen = 0;  // in 64ths of a pixel
    for (const char32_t letter : letters) {
      const FT_UInt glyph = FT_Get_Char_Index(face_, letter);
      FT_Vector kerning{};
      if (before != 0 && glyph != 0) FT_Get_Kerning(face_, before, glyph, FT_KERNING_DEFAULT, &kerning);
      pen += kerning.x;
      before = glyph;
      if (FT_Load_Glyph(face_, glyph, FT_LOAD_RENDER | FT_LOAD_TARGET_LIGHT) != 0) continue;
      const FT_GlyphSlot slot = face_->glyph;
      act(slot->bitmap, static_cast<int>((pen + 32) >> 6) + slot->bitmap_left, -slot->bitmap_top);
      pen += slot->advance.x;
    }
  }

 private:
  std::string file_;
  FT_Library library_ = nullptr;
  FT_Face face_ = nullptr;
};

/// The font of a file. It stays open, as a picture has many texts; one for each thread, because
/// FreeType's fonts are not for several threads at once.
const Font& opened_font(const std::string& file) {
  static thread_local std::unique_ptr<const Font> font;
  if (font == nullptr || font->file() != file) font = std::make_unique<const Font>(file);
  return *font;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) std::string rhoray_make_text_image(const std::string& text,
                                                                                     int pixels,
                                                                                     const std::string& font_file,
                                                                                     TextImage& out) noexcept {
  try {
    const Font& font = opened_font(font_file);
    if (!font.set_size(pixels)) return "is no font that can be read";
    const std::u32string letters = letters_of(text);
    int left = 0, top = 0, right = 0, bottom = 0;
    bool is_first = true;
    font.for_each_letter(letters, [&](const FT_Bitmap& letter, int x, int y) {
      const int width = static_cast<int>(letter.width), height = static_cast<int>(letter.rows);
      if (width == 0 || height == 0) return;
      left = is_first ? x : std::min(left, x), top = is_first ? y : std::min(top, y);
      right = is_first ? x + width : std::max(right, x + width);
      bottom = is_first ? y + height : std::max(bottom, y + height);
      is_first = false;
    });
    out = {.left = left, .top = top, .width = right - left, .height = bottom - top, .coverage = {}};
    out.coverage.resize(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
    font.for_each_letter(letters, [&](const FT_Bitmap& letter, int x, int y) {
      for (int row = 0; row < static_cast<int>(letter.rows); ++row)
        for (int column = 0; column < static_cast<int>(letter.width); ++column) {
          const float covered = static_cast<float>(letter.buffer[row * letter.pitch + column]) / 255;
          const int at = (y + row - top) * out.width + x + column - left;
          float& pixel = out.coverage[static_cast<std::size_t>(at)];
          pixel = std::max(pixel, covered);
        }
    });
    return {};
  } catch (const std::exception&) {
    return "cannot be used";
  }
}

namespace {

/// The bytes of an image, and how its pixels hold one channel.
struct ChannelBytes {
  const std::uint8_t* first;  ///< in the first pixel
  std::size_t pixel_bytes;
};

/// A floating-point number of 16 bits.
struct Half {
  std::uint16_t bits;

  explicit operator double() const {
    float number = 0;
    OIIO::convert_pixel_values(OIIO::TypeDesc::HALF, &bits, OIIO::TypeDesc::FLOAT, &number, 1);
    return number;
  }
};

/// Takes the numbers of one channel as StoredPicture::numbers has them.
template <class T>
void take_numbers(const ChannelBytes& bytes, std::size_t channel, StoredPicture& picture) {
  const std::uint8_t* from = bytes.first;
  for (std::size_t at = channel; at < picture.numbers.size(); at += picture.channels.size()) {
    T number;
    std::memcpy(&number, from, sizeof number);
    picture.numbers[at] = static_cast<double>(number);
    if constexpr (std::is_integral_v<T> && sizeof(T) <= 2) picture.numbers[at] /= std::numeric_limits<T>::max();
    from += bytes.pixel_bytes;
  }
}

using TakeNumbers = void(const ChannelBytes& bytes, std::size_t channel, StoredPicture& picture);

/// take_numbers of a type; null for types that no picture has.
TakeNumbers* numbers_taker(const OIIO::TypeDesc& type) {
  using OIIO::TypeDesc;
  static constexpr std::pair<int, TakeNumbers*> takers[] = {{TypeDesc::UINT8, take_numbers<std::uint8_t>},
                                                            {TypeDesc::INT8, take_numbers<std::int8_t>},
                                                            {TypeDesc::UINT16, take_numbers<std::uint16_t>},
                                                            {TypeDesc::INT16, take_numbers<std::int16_t>},
                                                            {TypeDesc::UINT32, take_numbers<std::uint32_t>},
                                                            {TypeDesc::INT32, take_numbers<std::int32_t>},
                                                            {TypeDesc::HALF, take_numbers<Half>},
                                                            {TypeDesc::FLOAT, take_numbers<float>},
                                                            {TypeDesc::DOUBLE, take_numbers<double>}};
  for (const auto& [base, take] : takers)
    if (type.basetype == base) return take;
  return nullptr;
}

/// Reads each channel in the file's own type: OpenImageIO would divide 32-bit integers by 2^32 - 1.
/// Returns the error message, or nothing.
std::string read_numbers(OIIO::ImageInput& file, const OIIO::ImageSpec& spec, StoredPicture& picture) {
  std::vector<std::uint8_t> bytes(spec.image_bytes(true));
  if (!file.read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UNKNOWN, bytes.data())) return file.geterror();
  picture.numbers.resize(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
  const std::uint8_t* first = bytes.data();
  for (int channel = 0; channel < spec.nchannels; ++channel) {
    TakeNumbers* const take = numbers_taker(spec.channelformat(channel));
    if (take == nullptr) return concat("its channels are of type ", spec.channelformat(channel).c_str());
    take({first, spec.pixel_bytes(true)}, static_cast<std::size_t>(channel), picture);
    first += spec.channel_bytes(channel, true);
  }
  return {};
}

}  // namespace

extern "C" __attribute__((visibility("default"))) std::string rhoray_decode_picture(const std::string& path,
                                                                                    StoredPicture& picture) noexcept {
  try {
    OIIO::ImageSpec as_stored;
    as_stored.attribute("oiio:UnassociatedAlpha", 1);
    const auto file = OIIO::ImageInput::open(path, &as_stored);
    if (!file) return OIIO::geterror();
    const OIIO::ImageSpec spec = file->spec();
    if (spec.depth != 1) return "it has several layers of pixels";
    picture = {.width = spec.width, .height = spec.height, .channels = spec.channelnames, .numbers = {}, .texts = {}};
    for (const OIIO::ParamValue& attribute : spec.extra_attribs)
      if (attribute.type() == OIIO::TypeString)
        picture.texts.push_back({attribute.name().string(), attribute.get_string()});
    return read_numbers(*file, spec, picture);
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace rhoray::tools
