#pragma once

#include <deque>
#include <filesystem>
#include <string_view>
#include <vector>

#include "preprocess/import/vtk/vtk_xml_stream.h"

namespace rhoray::preprocess {

/// The files that a VTK XML file of pieces names, in its order. Refuses a file without pieces, and
/// a piece that is missing or named twice.
std::vector<std::filesystem::path> piece_paths(const VtkXmlStream& whole, const std::filesystem::path& path);

/// The same files, opened.
class PieceFiles {
 public:
  /// Refuses pieces with layers of ghost cells, which overlap.
  /// @param type  of each piece, such as ImageData
  PieceFiles(const VtkXmlStream& whole, const std::filesystem::path& path, std::string_view type);

  std::vector<const VtkXmlStream*> streams() const;

 private:
  std::deque<ForeignFile> sources_;
  std::deque<VtkXmlStream> streams_;
};

}  // namespace rhoray::preprocess
