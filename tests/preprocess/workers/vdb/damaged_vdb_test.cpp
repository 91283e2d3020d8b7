#include <algorithm>
#include <random>

#include "tests/preprocess/import/support.h"
#include "tests/preprocess/workers/vdb/support.h"

namespace rhoray::preprocess {
namespace {

using namespace tests;

std::filesystem::path small_file(const std::filesystem::path& path) {
  const auto grid = named_grid<openvdb::FloatGrid>("density", 0);
  for (int i = 0; i < 12; ++i) grid->tree().setValueOn(openvdb::Coord(i, 2 * i, 3), static_cast<float>(i));
  openvdb::io::File(path.string()).write(openvdb::GridPtrVec{grid});
  return path;
}

/// OpenVDB itself reads on behind the end of a file and makes values up.
TEST_F(Vdb, is_refused_where_it_ends_too_early) {
  const auto path = small_file(folder_ / "cut.vdb");
  const std::string whole = read_file(path);
  for (std::size_t size = 1; size < whole.size(); size += whole.size() / 8) {
    write_file(path, std::string_view(whole).substr(0, size));
    expect_refusal([&] { open_vdb(path, ""); }, ErrorCode::invalid, {"cut.vdb"});
  }
  write_file(path, std::string_view(whole).substr(0, whole.size() - 1));
  expect_refusal([&] { open_vdb(path, ""); }, ErrorCode::invalid, {"cut.vdb"});
  write_file(path, whole);
  EXPECT_EQ(loaded(path).field().range, (Interval<double>{0, 11}));
}

TEST_F(Vdb, is_refused_or_read_whatever_bytes_are_changed) {
  const auto path = small_file(folder_ / "changed.vdb");
  const std::string whole = read_file(path);
  std::mt19937_64 random(20240607);
  int refused = 0;
  constexpr int trials = 12;
  for (int trial = 0; trial < trials; ++trial) {
    std::string bytes = whole;
    for (int change = 0; change < 6; ++change) bytes[random() % bytes.size()] = static_cast<char>(random());
    write_file(path, bytes);
    const LibraryText said;
    try {
      open_vdb(path, "", std::uint64_t{4} << 30);
    } catch (const Error& error) {
      ++refused;
      // The address sanitizer ends a process that asks for terabytes; other builds refuse them.
      if (std::any_of(said.lines().begin(), said.lines().end(),
                      [](const std::string& line) { return line.find("allocation-size-too-big") != line.npos; }))
        continue;
      EXPECT_NE(static_cast<int>(error.code()), static_cast<int>(ErrorCode::internal)) << error.what();
      EXPECT_THAT(std::string(error.what()), testing::HasSubstr("changed.vdb"));
    }
  }
  EXPECT_GT(refused, 0);
}

TEST_F(Vdb, is_refused_when_it_is_no_such_file) {
  expect_refusal([&] { open_vdb(folder_ / "none.vdb", ""); }, ErrorCode::unreadable, {"none.vdb"});
  write_file(folder_ / "text.vdb", "this is not one, although its name says so");
  expect_refusal([&] { open_vdb(folder_ / "text.vdb", ""); }, ErrorCode::invalid, {"text.vdb", "OpenVDB"});
}

}  // namespace
}  // namespace rhoray::preprocess
