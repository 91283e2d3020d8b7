#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <filesystem>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "formats/base/text.h"
#include "preprocess/import_mesh.h"
#include "preprocess/input_file.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

/// A whole XDMF file with these Grids.
inline std::string xdmf(const std::string& grids, const std::string& version = "3.0") {
  return concat("<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"", version,
                "\" xmlns:xi=\"http://www.w3.org/2001/XInclude\">\n<Domain>\n", grids, "</Domain>\n</Xdmf>\n");
}

template <class Numbers>
std::string in_words(const Numbers& numbers) {
  std::string text;
  for (const auto& number : numbers) text += concat(text.empty() ? "" : " ", number);
  return text;
}

/// A DataItem of text. `more` are further attributes.
inline std::string item(const std::string& sizes, const std::string& text, const std::string& more = "Format=\"XML\"") {
  return concat("<DataItem Dimensions=\"", sizes, "\" ", more, ">", text, "</DataItem>\n");
}

inline std::string geometry(const std::string& items, const std::string& type = "XYZ") {
  return concat("<Geometry GeometryType=\"", type, "\">\n", items, "</Geometry>\n");
}

inline std::string topology(const std::string& type, const std::string& items, const std::string& more = "") {
  return concat("<Topology TopologyType=\"", type, "\" ", more, ">\n", items, "</Topology>\n");
}

inline std::string attribute(const std::string& name, const std::string& items, const std::string& center = "Node",
                             const std::string& type = "Scalar") {
  return concat("<Attribute Name=\"", name, "\" AttributeType=\"", type, "\" Center=\"", center, "\">\n", items,
                "</Attribute>\n");
}

inline std::string grid(const std::string& name, const std::string& content) {
  return concat("<Grid Name=\"", name, "\" GridType=\"Uniform\">\n", content, "</Grid>\n");
}

inline std::string collection(const std::string& name, const std::string& type, const std::string& content) {
  return concat("<Grid Name=\"", name, "\" GridType=\"Collection\" CollectionType=\"", type, "\">\n", content,
                "</Grid>\n");
}

/// Points and cells of one tetrahedron.
inline const std::string tet_points = geometry(item("4 3", "0 0 0 1 0 0 0 1 0 0 0 1"));
inline const std::string tet_cells =
    topology("Tetrahedron", item("1 4", "0 1 2 3", "NumberType=\"Int\""), "NumberOfElements=\"1\"");

/// An HDF5 file, written by its library.
class Hdf5Writer {
 public:
  /// @param access  H5F_ACC_RDWR adds to an existing file
  explicit Hdf5Writer(const std::filesystem::path& path, unsigned access = H5F_ACC_TRUNC)
      : file_(access == H5F_ACC_TRUNC ? H5Fcreate(path.c_str(), access, H5P_DEFAULT, H5P_DEFAULT)
                                      : H5Fopen(path.c_str(), access, H5P_DEFAULT)) {
    EXPECT_GE(file_, 0);
  }
  ~Hdf5Writer() { EXPECT_GE(H5Fclose(file_), 0); }
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  hid_t id() const { return file_; }

  /// Writes numbers as `type`, below groups that are made. `chunk` and deflate when it is not
  /// empty.
  void array(const std::string& name, hid_t type, const std::vector<hsize_t>& shape, const std::vector<double>& numbers,
             const std::vector<hsize_t>& chunk = {}) const {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (!chunk.empty()) {
      H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
      H5Pset_deflate(creation, 9);
    }
    const hid_t set = make(name, type, shape, creation);
    EXPECT_GE(H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()), 0);
    H5Dclose(set);
    H5Pclose(creation);
  }

  /// A data set without numbers, to be closed by the caller.
  hid_t make(const std::string& name, hid_t type, const std::vector<hsize_t>& shape, hid_t creation) const {
    const hid_t links = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(links, 1);
    const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
    const hid_t set = H5Dcreate2(file_, name.c_str(), type, space, links, creation, H5P_DEFAULT);
    EXPECT_GE(set, 0);
    H5Sclose(space);
    H5Pclose(links);
    return set;
  }

  /// Doubles 1, 2, 3, 4 at the beginning of a data set; the rest is not written.
  void part(const std::string& name, const std::vector<hsize_t>& shape, hid_t creation) const {
    const hid_t set = make(name, H5T_IEEE_F64LE, shape, creation), space = H5Dget_space(set);
    const std::vector<hsize_t> first(shape.size(), 0);
    std::vector<hsize_t> count(shape.size(), 1);
    count.back() = 4;
    const double four[] = {1, 2, 3, 4};
    const hid_t memory = H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr);
    EXPECT_GE(H5Dwrite(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, four), 0);
    H5Sclose(memory);
    H5Sclose(space);
    H5Dclose(set);
  }

 private:
  hid_t file_;
};

// Small documents for tests that change them.

/// Two time steps of one mesh; the second has its values in a.bin.
inline std::string xdmf_mesh() {
  const auto step = [](const std::string& numbers) {
    return "<Grid><xi:include xpointer=\"xpointer(//Grid[@Name='m']/*[self::Topology or self::Geometry])\"/>" +
           attribute("f", numbers) + "<Time Value=\"2\"/></Grid>";
  };
  const std::string cells = item("9", "6 0 1 2 3 4 0 1 2", "NumberType=\"Int\"");
  return xdmf(grid("m", topology("Mixed", cells, "NumberOfElements=\"2\"") + tet_points) +
              collection("c", "Temporal", step(item("4", "1 2 3 4")) + step(item("4", "a.bin", "Format=\"Binary\""))));
}

/// A tetrahedron in HDF5, its points in chunks.
inline std::string hdf5() {
  const TemporaryFolder folder;
  {
    const Hdf5Writer file(folder / "a.h5");
    file.array("cells", H5T_STD_I32LE, {1, 4}, {0, 1, 2, 3});
    file.array("points", H5T_IEEE_F64LE, {4, 3}, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {2, 3});
  }
  return read_file(folder / "a.h5");
}

/// Its document.
inline std::string xdmf_hdf5() {
  const std::string more = "Format=\"HDF\"";
  return xdmf(grid(
      "a", topology("Tetrahedron", item("1 4", "a.h5:/cells", more)) + geometry(item("4 3", "a.h5:/points", more))));
}

/// 3 x 4 x 5 samples in a.bin.
inline std::string xdmf_volume() {
  return xdmf(grid("a", "<Topology Type=\"3DCoRectMesh\" Dimensions=\"5 4 3\"/>" +
                            geometry(item("3", "0 0 0") + item("3", "1 1 1"), "ORIGIN_DXDYDZ") +
                            attribute("a", item("5 4 3", "a.bin", "NumberType=\"Short\" Format=\"Binary\""))));
}

/// Reads meshes from texts.
class XdmfMeshes : public testing::Test {
 protected:
  preprocess::CellMesh read(const std::string& content, const std::string& time = {}) {
    write_file(folder_ / "a.xdmf", content);
    return preprocess::read_cells(folder_ / "a.xdmf", {.time = time});
  }

  TemporaryFolder folder_;
};

}  // namespace rhoray::tests
