#include "preprocess/import/vtk/piece_files.h"

#include <set>

namespace rhoray::preprocess {

std::vector<std::filesystem::path> piece_paths(const VtkXmlStream& whole, const std::filesystem::path& path) {
  std::vector<std::filesystem::path> paths;
  std::set<std::string_view> names;
  for (const XmlElement& piece : whole.data_set().children) {
    if (piece.name != "Piece") continue;
    const std::string place = concat("element Piece ", paths.size());
    const std::string_view name = piece.attribute("Source");
    if (name.empty()) whole.refuse(place, "no attribute Source", "the name of a VTK XML file");
    if (!names.insert(name).second) whole.refuse(place, concat("'", name, "' once more"), "each piece once");
    const std::filesystem::path beside = path.parent_path() / name;
    if (!is_there(beside))
      whole.refuse(place, concat("no file ", beside.string()), "each piece beside it", ErrorCode::unreadable);
    paths.push_back(beside);
  }
  if (paths.empty()) whole.refuse(concat("element ", whole.data_set().name), "no pieces", "at least one");
  return paths;
}

PieceFiles::PieceFiles(const VtkXmlStream& whole, const std::filesystem::path& path, std::string_view type) {
  const std::string_view layers = whole.data_set().attribute("GhostLevel");
  if (!layers.empty() && layers != "0")
    whole.refuse("attribute GhostLevel", in_quotes(layers), "0: pieces without ghost cells", ErrorCode::unsupported);
  for (const std::filesystem::path& piece : piece_paths(whole, path))
    streams_.emplace_back(sources_.emplace_back(piece), type);
}

std::vector<const VtkXmlStream*> PieceFiles::streams() const {
  std::vector<const VtkXmlStream*> streams;
  for (const VtkXmlStream& stream : streams_) streams.push_back(&stream);
  return streams;
}

}  // namespace rhoray::preprocess
