// Arrays of samples become grids.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"
#include "tests/support/run_program.h"

namespace rhoray::tests {
namespace {

using testing::HasSubstr;

std::string packed_bytes(GridArrays grid, AxisOrder order) {
  const TemporaryFolder folder;
  pack(grid, order, {.file = folder / "grid.rho"});
  return read_file(folder / "grid.rho");
}

/// A value that tells its three indices.
double indexed(std::int64_t i, std::int64_t j, std::int64_t k) {
  return static_cast<double>(i + 10 * j + 100 * k);
}

/// The value at a point.
double value_at(const FieldSampler& sampler, const Vec3& p) {
  const std::array<double, 3> point{p.x, p.y, p.z};
  double value = 0;
  sampler.at({std::span<const double>(point), {1, 3}}, {&value, 1});
  return value;
}

TEST(PackGrid, places_samples_by_the_order_of_axes) {
  const Samples<float> zyx = samples_of<float>(4, 3, 2, indexed);
  const Samples<float> xyz =
      samples_of<float>(2, 3, 4, [](auto k, auto j, auto i) { return indexed(i, j, k); });  // its slowest axis is x
  const GridArrays grid{.fields = {{.name = "f", .values = zyx.view()}}, .spacing = {2, 3, 4}, .origin = {10, 20, 30}};
  GridArrays turned = grid;
  turned.fields[0].values = xyz.view();
  EXPECT_TRUE(packed_bytes(grid, AxisOrder::zyx) == packed_bytes(turned, AxisOrder::xyz));
  const Dataset data = pack(turned, AxisOrder::xyz);
  EXPECT_EQ(data.bounds(), (Box3{{10, 20, 30}, {16, 26, 34}}));
  const FieldSampler sampler(data);
  EXPECT_EQ(value_at(sampler, {10, 20, 30}), 0);
  EXPECT_EQ(value_at(sampler, {12, 20, 30}), 1);
  EXPECT_EQ(value_at(sampler, {10, 23, 30}), 10);
  EXPECT_EQ(value_at(sampler, {10, 20, 34}), 100);
  EXPECT_EQ(value_at(sampler, {16, 26, 34}), 123);
}

TEST(PackGrid, takes_any_strides) {
  const Samples<float> plain = samples_of<float>(5, 4, 3, indexed);
  GridArrays grid{.fields = {{.name = "f", .values = plain.view()}}};
  const std::string expected = packed_bytes(grid, AxisOrder::zyx);
  const std::array<std::int64_t, 3> shape{3, 4, 5};
  const auto with = [&](const void* first, const std::array<std::int64_t, 3>& strides) {
    grid.fields[0].values = ArrayView(first, ElementType::F32, shape, strides);
    return packed_bytes(grid, AxisOrder::zyx);
  };
  const Samples<float> mirrored =
      samples_of<float>(5, 4, 3, [](auto i, auto j, auto k) { return indexed(4 - i, 3 - j, 2 - k); });
  EXPECT_TRUE(with(&mirrored.values.back(), {-80, -20, -4}) == expected) << "negative";
  const Samples<float> sparse = samples_of<float>(
      15, 8, 3, [](auto i, auto j, auto k) { return i % 3 + j % 2 == 0 ? indexed(i / 3, j / 2, k) : -1; });
  EXPECT_TRUE(with(sparse.values.data(), {480, 120, 12}) == expected) << "every third and every second";
  std::vector<char> unaligned(1 + 4 * 60);
  std::memcpy(unaligned.data() + 1, plain.values.data(), 4 * 60);
  EXPECT_TRUE(with(unaligned.data() + 1, {80, 20, 4}) == expected) << "unaligned";
  std::vector<char> odd(60 * 7);  // records of 7 bytes
  for (std::size_t at = 0; at < 60; ++at) std::memcpy(odd.data() + 7 * at + 2, &plain.values[at], 4);
  EXPECT_TRUE(with(odd.data() + 2, {140, 35, 7}) == expected) << "records";
  // As numpy.broadcast_to makes them.
  const std::vector<float> row{0, 1, 2, 3, 4};
  const Samples<float> repeated = samples_of<float>(5, 4, 3, [](auto i, auto, auto) { return i; });
  const std::string broadcast = with(row.data(), {0, 0, 4});
  grid.fields[0].values = repeated.view();
  EXPECT_TRUE(broadcast == packed_bytes(grid, AxisOrder::zyx)) << "broadcast";
}

template <class T>
void expect_type(ElementType type) {
  const T low = std::is_signed_v<T> ? static_cast<T>(-100) : static_cast<T>(1), high = 120;
  const Samples<T> samples = samples_of<T>(3, 2, 2, [&](auto i, auto j, auto k) {
    return i + j + k == 0 ? low : i + j + k == 4 ? high : T{7};
  });
  const Dataset data = pack({.fields = {samples.field("f")}}, AxisOrder::zyx);
  EXPECT_EQ(static_cast<int>(samples.view().type()), static_cast<int>(type));
  const FieldInfo& field = data.field();
  EXPECT_EQ(field.range, (Interval{static_cast<double>(low), static_cast<double>(high)})) << static_cast<int>(type);
  const bool is_wide = type == ElementType::U64 || type == ElementType::I64;  // stored as F64
  EXPECT_EQ(static_cast<int>(field.type), static_cast<int>(is_wide ? ElementType::F64 : type));
  const FieldSampler sampler(data);
  EXPECT_EQ(value_at(sampler, {0, 0, 0}), static_cast<double>(low));
  EXPECT_EQ(value_at(sampler, {2, 1, 1}), static_cast<double>(high));
  EXPECT_EQ(value_at(sampler, {1.5, 0, 0}), 7);
}

TEST(PackGrid, takes_every_type_of_elements) {
  expect_type<std::uint8_t>(ElementType::U8), expect_type<std::int8_t>(ElementType::I8);
  expect_type<std::uint16_t>(ElementType::U16), expect_type<std::int16_t>(ElementType::I16);
  expect_type<std::uint32_t>(ElementType::U32), expect_type<std::int32_t>(ElementType::I32);
  expect_type<std::uint64_t>(ElementType::U64), expect_type<std::int64_t>(ElementType::I64);
  expect_type<float>(ElementType::F32), expect_type<double>(ElementType::F64);
}

TEST(PackGrid, keeps_names_units_labels_and_several_fields) {
  const Samples<std::uint8_t> labels = samples_of<std::uint8_t>(4, 3, 3, [](auto i, auto, auto) { return i; });
  const Samples<double> flat = samples_of<double>(4, 3, 3, [](auto, auto, auto) { return 5; });
  const Samples<float> density =
      samples_of<float>(4, 3, 3, [](auto i, auto j, auto k) { return i == 3 && j + k == 0 ? NAN : indexed(i, j, k); });
  GridArrays grid{.fields = {flat.field("flat"), density.field("density"), labels.field("organs")},
                  .length_unit = "mm"};
  grid.fields[1].unit = "g/cm3";
  grid.fields[2].label_names = {{1, "liver"}, {3, "spleen"}};
  const Dataset data = pack(grid, AxisOrder::zyx);
  EXPECT_EQ(data.kind(), DataKind::grid);
  EXPECT_EQ(data.length_unit(), "mm");
  ASSERT_EQ(data.fields().size(), 3U);
  EXPECT_EQ(data.fields()[0].name, "flat");
  EXPECT_EQ(data.field().name, "density") << "the first that is not constant";
  EXPECT_EQ(data.field("density").unit, "g/cm3");
  EXPECT_EQ(data.field("density").no_data_count, 1U);
  EXPECT_EQ(data.field("organs").label_names, (std::map<int, std::string>{{1, "liver"}, {3, "spleen"}}));
  EXPECT_FALSE(data.field("organs").is_of_cells);
  std::uint64_t counted = 0;
  for (const std::uint64_t bin : data.field("density").histogram) counted += bin;
  EXPECT_EQ(counted, 35U);
  EXPECT_EQ(value_at(FieldSampler(data), {2, 1, 1}), 112);
  EXPECT_TRUE(std::isnan(value_at(FieldSampler(data), {2.5, 0.5, 0.5}))) << "beside a sample without data";
  EXPECT_EQ(value_at(FieldSampler(data, "flat"), {2.5, 0.5, 0.5}), 5);
  EXPECT_EQ(value_at(FieldSampler(data, "organs"), {2.5, 0.5, 0.5}), 2.5);
}

TEST(PackGrid, keeps_positions_of_a_rectilinear_grid) {
  const Samples<float> samples = samples_of<float>(4, 3, 2, indexed);
  GridArrays grid{.fields = {samples.field("f")}};
  grid.positions = {{{-1, 0, 0.5, 10}, {0, 1, 4}, {7, 7.25}}};
  const Dataset data = pack(grid, AxisOrder::zyx);
  EXPECT_EQ(data.bounds(), (Box3{{-1, 0, 7}, {10, 4, 7.25}}));
  const FieldSampler sampler(data);
  EXPECT_EQ(value_at(sampler, {0.5, 4, 7.25}), 122);
  EXPECT_NEAR(value_at(sampler, {5.25, 2.5, 7}), 2.5 + 15, 1e-12);
}

TEST(PackGrid, keeps_rotated_sheared_and_mirrored_lattices) {
  const Samples<float> samples = samples_of<float>(4, 3, 2, indexed);
  const Affine maps[] = {{.x_axis = {0, 2, 0}, .y_axis = {-3, 0, 0}, .z_axis = {0, 0, 1}, .origin = {1, 2, 3}},
                         {.x_axis = {1, 0, 0}, .y_axis = {0.5, 1, 0}, .z_axis = {0.25, 0, 2}, .origin = {0, 0, -9}},
                         {.x_axis = {-1, 0, 0}, .y_axis = {0, 1, 0}, .z_axis = {0, 0, 1}, .origin = {5, 0, 0}}};
  for (const Affine& map : maps) {
    const Dataset data = pack({.fields = {samples.field("f")}, .world_from_grid = map}, AxisOrder::zyx);
    const FieldSampler sampler(data);
    for (const auto& [i, j, k] : {std::array{0, 0, 0}, {3, 0, 0}, {1, 2, 0}, {3, 2, 1}}) {
      const auto along = [i = i, j = j, k = k](double x, double y, double z, double from) {
        return from + i * x + j * y + k * z;
      };
      const Vec3 p{along(map.x_axis.x, map.y_axis.x, map.z_axis.x, map.origin.x),
                   along(map.x_axis.y, map.y_axis.y, map.z_axis.y, map.origin.y),
                   along(map.x_axis.z, map.y_axis.z, map.z_axis.z, map.origin.z)};
      EXPECT_NEAR(value_at(sampler, p), indexed(i, j, k), 1e-9);
    }
  }
}

TEST(PackGrid, in_memory_and_in_a_file_makes_the_same_bytes) {
  const TemporaryFolder folder;
  const Dataset in_memory = gyroid_grid(), in_file = gyroid_grid({.file = folder / "file.rho"});
  in_memory.save(folder / "saved.rho");
  EXPECT_TRUE(read_file(folder / "saved.rho") == read_file(folder / "file.rho"));
  const Dataset opened = Dataset::open(folder / "saved.rho");
  const std::string bits = bits_of(rendered(certified_scene(in_memory, 0.3, {50, 40}), {.size = {50, 40}}));
  EXPECT_TRUE(bits_of(rendered(certified_scene(in_file, 0.3, {50, 40}), {.size = {50, 40}})) == bits);
  EXPECT_TRUE(bits_of(rendered(certified_scene(opened, 0.3, {50, 40}), {.size = {50, 40}})) == bits);
  expect_refused(ErrorCode::usage, "saved.rho", [&] { in_memory.save(folder / "saved.rho"); });
  in_memory.save(folder / "saved.rho", true);
  in_file.save(folder / "again.rho");
  EXPECT_TRUE(read_file(folder / "again.rho") == read_file(folder / "file.rho"));
  expect_refused(ErrorCode::usage, "file.rho", [&] { gyroid_grid({.file = folder / "file.rho"}); });
  gyroid_grid({.file = folder / "file.rho", .replace_existing = true});
  expect_refused(ErrorCode::usage, "no/such", [&] { gyroid_grid({.file = folder / "no/such/folder.rho"}); });
}

/// The bytes of a .npy file.
template <class T>
std::string npy(const Samples<T>& samples, const std::string& type) {
  std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + std::to_string(samples.nz) +
                       ", " + std::to_string(samples.ny) + ", " + std::to_string(samples.nx) + "), }";
  header.resize((10 + header.size()) / 64 * 64 + 64 - 10 - 1, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size() % 256), bytes += static_cast<char>(header.size() / 256);
  return bytes + header +
         std::string(reinterpret_cast<const char*>(samples.values.data()), samples.values.size() * sizeof(T));
}

/// The arrays of a packed file with the padding between them, without header and checksums.
std::string arrays_of(const std::filesystem::path& file) {
  const std::string info = run_program({RHORAY_PROGRAM, "info", file, "--json"}).out;
  const auto number = [&](const std::string& key, std::size_t at) { return std::stoul(info.substr(at + key.size())); };
  const std::string first = "\"first_byte\":", bytes = "\"byte_count\":";
  const std::size_t begin = number(first, info.find(first));
  const std::size_t end = number(first, info.rfind(first)) + number(bytes, info.rfind(bytes));
  return read_file(file).substr(begin, end - begin);
}

/// A member of the program's JSON up to a comma.
std::string member(const std::string& json, const std::string& name) {
  const std::size_t at = json.find('"' + name + "\":");
  return at == json.npos ? "" : json.substr(at, json.find("\":", at + name.size() + 4) - at);
}

template <class T>
void expect_what_the_program_packs(const Samples<T>& samples, const std::string& type) {
  const TemporaryFolder folder;
  write_file(folder / "field.npy", npy(samples, type));
  const RunResult run = run_program(
      {RHORAY_PROGRAM, "pack", "field.npy", "-o", "program.rho", "--spacing", "0.5,0.5,0.75"}, folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  pack({.fields = {samples.field("field")}, .spacing = {0.5, 0.5, 0.75}}, AxisOrder::zyx,
       {.file = folder / "library.rho"});
  const std::string of_program = run_program({RHORAY_PROGRAM, "info", "program.rho", "--json"}, folder.path()).out;
  const std::string of_library = run_program({RHORAY_PROGRAM, "info", "library.rho", "--json"}, folder.path()).out;
  for (const char* const name :
       {"samples", "geometry", "range", "histogram", "percentiles", "layout", "macro_levels"}) {
    EXPECT_NE(member(of_library, name), "") << name;
    EXPECT_EQ(member(of_library, name), member(of_program, name)) << type;
  }
  const std::string expected = arrays_of(folder / "program.rho"), found = arrays_of(folder / "library.rho");
  EXPECT_GT(expected.size(), samples.values.size() * sizeof(T));
  EXPECT_TRUE(found == expected) << type;
}

TEST(PackGrid, writes_the_arrays_that_the_program_writes) {
  expect_what_the_program_packs(gyroid_samples(), "<f4");
  expect_what_the_program_packs(samples_of<std::int16_t>(9, 11, 6, indexed), "<i2");
  expect_what_the_program_packs(
      samples_of<double>(
          17, 5, 6,
          [](auto i, auto j, auto k) { return i == 3 && j == 2 ? NAN : std::sin(static_cast<double>(i + j * k)); }),
      "<f8");
}

}  // namespace
}  // namespace rhoray::tests
