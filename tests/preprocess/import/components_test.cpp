#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "formats/base/error.h"
#include "preprocess/components.h"
#include "preprocess/import/readers.h"
#include "tests/preprocess/import/support.h"

// One rule for arrays with several numbers for each sample, whatever the format: the same numbers
// give the same fields under the same names.

namespace rhoray::preprocess {
namespace {

using namespace tests;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int nx = 4, ny = 3, nz = 2, samples = nx * ny * nz;

float number(int sample, int component) {
  return static_cast<float>(sample * 10 - 7 * component * component);
}

/// All numbers of a sample side by side, or all samples of a number.
std::vector<float> numbers(int components, bool side_by_side = true) {
  std::vector<float> all;
  for (int outer = 0; outer < (side_by_side ? samples : components); ++outer)
    for (int inner = 0; inner < (side_by_side ? components : samples); ++inner)
      all.push_back(side_by_side ? number(outer, inner) : number(inner, outer));
  return all;
}

std::string ascii(int components) {
  std::string text;
  for (const float value : numbers(components)) text += concat(value, " ");
  return text;
}

std::string vti(int components) {
  return concat(
      "<VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"0 3 0 ",
      "2 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 3 0 2 0 1\"><PointData><DataArray ",
      "type=\"Float32\" Name=\"a\" NumberOfComponents=\"", components, "\" format=\"ascii\">", ascii(components),
      "</DataArray></PointData></Piece></ImageData></VTKFile>\n");
}

std::string legacy_vtk(int components) {
  return concat("# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nORIGIN 0 0 0\n",
                "SPACING 1 1 1\nPOINT_DATA 24\nFIELD FieldData 1\na ", components, " 24 float\n", ascii(components),
                "\n");
}

std::string nrrd(int components, const char* kind, bool first) {
  const std::string sizes = first ? concat(components, " 4 3 2") : concat("4 3 2 ", components);
  const std::string kinds = first ? concat(kind, " space space space") : concat("space space space ", kind);
  return concat("NRRD0004\ntype: float\ndimension: 4\nsizes: ", sizes, "\nkinds: ", kinds,
                "\nencoding: raw\nendian: little\n\n", bytes_of_values(numbers(components, first)));
}

std::string nrrd_vectors(int components) {
  return nrrd(components, "vector", true);
}

std::string nrrd_list(int components) {
  return nrrd(components, "list", false);
}

std::string metaimage(int components) {
  return concat("ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementNumberOfChannels = ", components,
                "\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n") +
         bytes_of_values(numbers(components));
}

std::string nifti(int components) {
  std::string header(352, '\0');
  const auto set = [&]<class T>(std::size_t at, const std::vector<T>& values) {
    header.replace(at, sizeof(T) * values.size(), bytes_of_values(values));
  };
  set(0, std::vector<std::int32_t>{348});
  set(40, std::vector<std::int16_t>{5, nx, ny, nz, 1, static_cast<std::int16_t>(components), 1, 1});
  set(70, std::vector<std::int16_t>{16, 32});
  set(76, std::vector<float>{1, 1, 1, 1, 0, 0, 0, 0});
  set(108, std::vector<float>{352});
  header.replace(344, 4, std::string("n+1\0", 4));
  return header + bytes_of_values(numbers(components, false));
}

std::string npy(const std::string& numbers_as_bytes, int components, bool fortran_order) {
  std::string dictionary = concat("{'descr': '<f4', 'fortran_order': ", fortran_order ? "True" : "False",
                                  ", 'shape': (2, 3, 4, ", components, "), }");
  dictionary.append(63 - (10 + dictionary.size()) % 64, ' ');
  dictionary += '\n';
  return concat("\x93NUMPY\x01", std::string(1, '\0'),
                bytes_of_values(std::vector{static_cast<std::uint16_t>(dictionary.size())}), dictionary,
                numbers_as_bytes);
}

std::string npy_c(int components) {
  return npy(bytes_of_values(numbers(components)), components, false);
}

std::string npy_fortran(int components) {
  std::vector<float> z_fastest;
  for (int c = 0; c < components; ++c)
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < ny; ++j)
        for (int k = 0; k < nz; ++k) z_fastest.push_back(number((k * ny + j) * nx + i, c));
  return npy(bytes_of_values(z_fastest), components, true);
}

struct Format {
  const char* name;
  const char* extension;
  std::string (*content)(int components);

  friend void PrintTo(const Format& format, std::ostream* to) { *to << format.name; }
};

class Components : public testing::TestWithParam<Format> {
 protected:
  NeutralVolume read(int components, const std::string& field = {}) {
    const std::filesystem::path path = folder_ / concat("a", GetParam().extension);
    write_file(path, GetParam().content(components));
    return read_volume(path, {.raw = {}, .field = field});
  }
  TemporaryFolder folder_;
};

/// By hand: squares of numbers off the diagonal count twice in a symmetric tensor.
double length(int sample, int components) {
  double sum = 0;
  for (int c = 0; c < components; ++c) sum += std::pow(number(sample, c), 2) * (components == 6 && c >= 3 ? 2 : 1);
  return std::sqrt(sum);
}

TEST_P(Components, have_the_same_names_and_values_in_every_format) {
  const std::map<int, std::vector<std::string>> names{{2, {"x", "y"}},
                                                      {3, {"x", "y", "z"}},
                                                      {4, {"0", "1", "2", "3"}},
                                                      {6, {"xx", "yy", "zz", "xy", "yz", "xz"}},
                                                      {9, {"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"}}};
  for (const auto& [count, words] : names) {
    const int components = count;  // clang captures no structured bindings
    SCOPED_TRACE(components);
    const NeutralVolume shown = read(components);
    EXPECT_EQ(shown.sample_count, Index3(nx, ny, nz));
    EXPECT_EQ(shown.field_name, "a.mag");
    ASSERT_EQ(shown.vectors.size(), 1U);
    EXPECT_EQ(shown.vectors[0].component_count, components);
    EXPECT_THAT(shown.notes, Contains(AllOf(HasSubstr("'a.mag'"), HasSubstr(concat("--field: a.", words[0])))));
    for (int i = 0; i < samples; ++i) EXPECT_NEAR(values_of(shown)[i], length(i, components), 1e-4) << i;
    for (int c = 0; c < components; ++c) {
      const NeutralVolume part = read(components, concat("a.", words[c]));
      EXPECT_EQ(part.field_name, concat("a.", words[c]));
      for (int i = 0; i < samples; ++i) EXPECT_EQ(values_of(part)[i], number(i, c)) << words[c] << ' ' << i;
    }
    expect_refusal([&] { read(components, "a"); }, ErrorCode::usage,
                   {"field 'a'", concat(components, " components"), "a.mag, a."});
    expect_refusal([&] { read(components, "a.no"); }, ErrorCode::usage, {"no field 'a.no'", "a.mag, a."});
  }
}

constexpr Format formats_with_components[] = {{"vti", ".vti", vti},
                                              {"legacy_vtk", ".vtk", legacy_vtk},
                                              {"nrrd", ".nrrd", nrrd_vectors},
                                              {"nrrd_list", ".nrrd", nrrd_list},
                                              {"metaimage", ".mha", metaimage},
                                              {"nifti", ".nii", nifti},
                                              {"npy", ".npy", npy_c},
                                              {"npy_fortran", ".npy", npy_fortran}};

INSTANTIATE_TEST_SUITE_P(Of, Components, testing::ValuesIn(formats_with_components),
                         [](const auto& format) { return std::string(format.param.name); });

TEST(ScalarNames, are_the_rule) {
  EXPECT_THAT(scalars_of("p", 1), ElementsAre("p"));
  EXPECT_THAT(scalars_of("v", 2), ElementsAre("v.mag", "v.x", "v.y"));
  EXPECT_EQ(scalars_text("dwi", 64), "dwi.mag, dwi.0 to dwi.63");
  EXPECT_EQ(component_in("v.mag", "v", 3), magnitude_component);
  EXPECT_EQ(component_in("a.b.z", "a.b", 3), 2);
  for (const char* other : {"v", "v.", "v.0", "v.xx", "w.x", "v.x.x"})
    EXPECT_FALSE(component_in(other, "v", 3)) << other;
  EXPECT_FALSE(component_in("t.04", "t", 5)) << "each component has one name";
}

TEST(ScalarNames, of_declared_symmetric_tensors_come_in_one_order) {
  TemporaryFolder folder;
  const auto path = folder / "a.nrrd";
  const auto yy = [&] { return values_of(read_volume(path, {.raw = {}, .field = "a.yy"}))[1]; };
  write_file(path, nrrd(6, "3D-symmetric-matrix", true));  // xx xy xz yy yz zz
  EXPECT_EQ(yy(), number(1, 3));
  write_file(path, nrrd(7, "3D-masked-symmetric-matrix", true));
  EXPECT_EQ(yy(), number(1, 4));
  std::string content = nifti(6);
  content.replace(68, 2, bytes_of_values(std::vector<std::int16_t>{1005}));  // xx yx yy zx zy zz
  write_file(folder / "a.nii", content);
  EXPECT_EQ(values_of(read_volume(folder / "a.nii", {.raw = {}, .field = "a.yy"}))[1], number(1, 2));
  EXPECT_EQ(values_of(read_volume(folder / "a.nii", {.raw = {}, .field = "a.zz"}))[1], number(1, 5));
}

}  // namespace
}  // namespace rhoray::preprocess
