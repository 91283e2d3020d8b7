#include "tools/rhoray/pictures.h"

#include <dlfcn.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "formats/base/trouble.h"
#include "tools/rhoray/input_file.h"
#include "tools/rhoray/new_file.h"
#include "tools/rhoray/pictures_module.h"

namespace rhoray::tools {

namespace {

/// OpenImageIO's name of the format, or nothing.
std::string format_of(const std::filesystem::path& path) {
  static const std::pair<std::string_view, std::string_view> formats[] = {
      {".png", "png"}, {".exr", "openexr"}, {".tif", "tiff"}, {".tiff", "tiff"}, {".jpg", "jpeg"}, {".jpeg", "jpeg"}};
  std::string extension = path.extension().string();
  for (char& letter : extension) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  for (const auto& [name, format] : formats)
    if (extension == name) return std::string(format);
  return {};
}

/// An act of the module.
template <class Act>
Act* load(const char* name) {
  const std::filesystem::path module = std::filesystem::read_symlink("/proc/self/exe").parent_path() / pictures_module;
  void* const handle = ::dlopen(module.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const symbol = handle == nullptr ? nullptr : ::dlsym(handle, name);
  if (symbol == nullptr)
    throw Error(Trouble::unsupported, concat("pictures can be neither written nor read: ", ::dlerror()));
  return reinterpret_cast<Act*>(symbol);
}

void require_ids_that_fit(const render::Framebuffer& picture, const std::filesystem::path& path) {
  constexpr std::uint64_t limit = 0xffff'ffff;  // itself means: no cell
  for (const std::uint64_t id : picture.cell)
    if (id >= limit && id != render::Framebuffer::no_cell)
      throw Error(Trouble::unsupported,
                  concat(path.string(), ": channel 'cell': found id ", id, "; EXR holds ids below ", limit),
                  "leave 'cell' out of --channels");
}

}  // namespace

void require_picture_format(const std::filesystem::path& path, const render::ChannelSet& channels) {
  const std::string format = format_of(path);
  if (format.empty())
    throw Error(Trouble::usage, concat(path.string(), ": found extension '", path.extension().string(),
                                       "'; expected .png, .exr, .tif, .tiff, .jpg or .jpeg"));
  if (channels.any() && format != "openexr")
    throw Error(Trouble::usage, concat(path.string(), ": only EXR keeps --channels"),
                "give the picture a name in .exr");
}

void write_picture(const render::Framebuffer& picture, const std::vector<PictureText>& texts,
                   const std::filesystem::path& path, bool replace_existing) {
  require_ids_that_fit(picture, path);
  NewFile file(path);
  const std::string trouble =
      load<EncodePicture>(encode_picture_symbol)(picture, texts, format_of(path), file.open_name().string());
  if (!trouble.empty()) throw Error(Trouble::resource, concat(path.string(), ": ", trouble));
  file.commit(replace_existing);
}

StoredPicture read_picture(const std::filesystem::path& path) {
  require_input(path);
  StoredPicture picture;
  const std::string trouble = load<DecodePicture>(decode_picture_symbol)(path.string(), picture);
  if (!trouble.empty()) throw Error(Trouble::invalid, concat(path.string(), ": no picture: ", trouble));
  return picture;
}

}  // namespace rhoray::tools
