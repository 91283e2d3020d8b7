#pragma once

#include <vtkXMLUnstructuredGridReader.h>

#include <filesystem>

#include "preprocess/import/mesh/mesh_cells.h"

namespace rhoray::preprocess {

/// VTK's reader of VTU files that also keeps the faces of polyhedra in the layout of VTK 9.4 and
/// later. VTK 9.1 ignores them.
class VtuReader : public vtkXMLUnstructuredGridReader {
 public:
  static VtuReader* New();
  vtkTypeMacro(VtuReader, vtkXMLUnstructuredGridReader);

  /// Faces of the piece that was read last. Cell c has the faces cell_faces[cell_offsets[c-1]] ..,
  /// and face f the corners corners[face_offsets[f-1]] .. (0 before the first). Empty when the
  /// piece has none. Not checked yet.
  struct Faces {
    Array<std::uint64_t> cell_offsets, cell_faces, face_offsets, corners;
  };
  const Faces& faces() const { return faces_; }

 protected:
  VtuReader() = default;
  ~VtuReader() override = default;
  int ReadPieceData() override;

 private:
  bool read(const char* name, std::uint64_t count, Array<std::uint64_t>& numbers);
  bool read_faces();

  Faces faces_;
};

/// Replaces each polyhedron's nodes by its face stream, from either layout. Refuses polyhedra
/// without faces, and face indices and counts that do not exist.
void put_face_streams(ForeignCells& cells, VtuReader& reader, const std::filesystem::path& path);

}  // namespace rhoray::preprocess
