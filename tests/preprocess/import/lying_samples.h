#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "preprocess/import/readers.h"

namespace rhoray::preprocess {

/// A small valid file, and how it is read.
struct Sample {
  std::string file;
  std::string content;
  std::function<void(const std::filesystem::path&)> read;
  std::map<std::string, std::string> others{};  ///< files beside it
};

inline void volume(const std::filesystem::path& path) {
  read_volume(path, {});
}
inline void cells(const std::filesystem::path& path) {
  read_cells(path, {});
}
inline void surface(const std::filesystem::path& path) {
  read_surface(path);
}

template <class T>
std::string bytes_of(const std::vector<T>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T)};
}

inline const std::string eight_bytes = "\1\2\3\4\5\6\7\10";
inline const std::string four_points = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";

inline std::vector<Sample> text_samples() {
  const std::string tet_of_vtk =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n" + four_points +
      "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 4\nSCALARS f float 1\nLOOKUP_TABLE default\n1 2 3 4\n";
  const std::string vtu =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">"
      "<UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><PointData><DataArray type=\"Float32\" "
      "Name=\"f\" format=\"ascii\">1 2 3 4</DataArray></PointData><Points><DataArray type=\"Float32\" "
      "NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells><DataArray "
      "type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray><DataArray type=\"Int64\" "
      "Name=\"offsets\" format=\"ascii\">4</DataArray><DataArray type=\"UInt8\" Name=\"types\" "
      "format=\"ascii\">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>\n";
  const std::string vti =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData "
      "WholeExtent=\"0 1 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 1 0 1 0 1\"><PointData "
      "Scalars=\"f\"><DataArray type=\"UInt8\" Name=\"f\" format=\"ascii\">1 2 3 4 5 6 7 8</DataArray></PointData>"
      "</Piece></ImageData></VTKFile>\n";
  return {
      {"a.nrrd",
       "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nline skip: 0\nbyte skip: 0\n\n" + eight_bytes,
       volume},
      {"a.mha",
       "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementNumberOfChannels = 1\nHeaderSize = 0\nElementType = "
       "MET_UCHAR\nElementDataFile = LOCAL\n" +
           eight_bytes,
       volume},
      {"a.cube", "c\nd\n 1 0 0 0\n 2 1 0 0\n 2 0 1 0\n 2 0 0 1\n 1 1 0 0 0\n 1 2\n 3 4\n 5 6\n 7 8\n", volume},
      {"a.bov",
       "DATA_FILE: a.raw\nDATA_SIZE: 2 2 2\nDATA_FORMAT: BYTE\nVARIABLE: f\nDATA_COMPONENTS: 1\nBYTE_OFFSET: 0\n"
       "BRICK_ORIGIN: 0 0 0\nBRICK_SIZE: 1 1 1\n",
       volume,
       {{"a.raw", eight_bytes}}},
      {"a.vtk",
       "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 "
       "1\nPOINT_DATA 8\nSCALARS f float 1\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8\n",
       volume},
      {"b.vtk", tet_of_vtk, cells},
      {"a.vti", vti, volume},
      {"a.vtu", vtu, cells},
      {"a.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
       surface},
      {"b.ply",
       "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
       "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
           bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}) + "\3" + bytes_of<std::int32_t>({0, 1, 2}),
       surface},
      {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", surface},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", surface},
      {"a.msh",
       "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 "
       "1\n$EndNodes\n$Elements\n1\n1 "
       "4 2 0 1 1 2 3 4\n$EndElements\n",
       cells},
      {"b.msh",
       "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n" + four_points +
           "$EndNodes\n$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n",
       cells},
      {"a.mesh",
       "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\nTetrahedra\n1\n1 2 3 4 "
       "1\nEnd\n",
       cells},
      {"a.vol",
       "mesh3d\ndimension\n3\ngeomtype\n0\nsurfaceelements\n0\nvolumeelements\n1\n1 4 1 2 3 4\nedgesegmentsgi2\n0\n"
       "points\n4\n" +
           four_points + "endmesh\n",
       cells},
      {"a.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n", cells, {{"a.ele", "1 4 0\n0 3 2 1 0\n"}}},
      {"b.ele", "1 4 0\n0 3 2 1 0\n", cells, {{"b.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n"}}},
      {"a.smesh", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 0\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n0\n0\n",
       surface},
      {"a.xdmf",
       "<Xdmf Version=\"3.0\"><Domain><Grid><Topology TopologyType=\"Tetrahedron\" NumberOfElements=\"1\" "
       "NodesPerElement=\"4\" BaseOffset=\"0\"><DataItem Dimensions=\"1 4\" NumberType=\"Int\" Precision=\"4\">0 1 2 3"
       "</DataItem></Topology><Geometry><DataItem Dimensions=\"4 3\">0 0 0 1 0 0 0 1 0 0 0 1</DataItem></Geometry>"
       "<Attribute Name=\"f\"><DataItem ItemType=\"HyperSlab\" Dimensions=\"4\"><DataItem Dimensions=\"3 2\" "
       "NumberType=\"Int\">1 0 1 1 1 4</DataItem><DataItem Dimensions=\"2 4\" Format=\"Binary\" NumberType=\"UChar\" "
       "Seek=\"0\">a.bin</DataItem></DataItem></Attribute></Grid></Domain></Xdmf>\n",
       cells,
       {{"a.bin", eight_bytes}}},
  };
}

}  // namespace rhoray::preprocess
