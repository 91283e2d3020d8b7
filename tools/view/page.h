#pragma once

#include <span>
#include <string_view>

namespace rhoray::tools {

/// A file of the page, compiled in.
struct PageFile {
  std::string_view path;  ///< "/", "/view.js"
  std::string_view type;  ///< of the content, for HTTP
  std::string_view content;
};
std::span<const PageFile> page_files();

}  // namespace rhoray::tools
