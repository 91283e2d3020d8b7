#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <set>

#include "formats/base/error.h"
#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "tests/support/made_grid.h"
#include "tests/support/memory_file.h"
#include "tests/support/packed_samples.h"

// "Refused or harmless", checked for every damaged file, means:
//   - opening refuses it with an Error, or
//   - it opens, and then `damaged_blocks` names only the block that holds the changed byte.
//     The grid or mesh made from such a file then either refuses with an Error, or hands out views
//     that stay inside the file and indices that stay inside their arrays. This also holds for a
//     caller who never calls `damaged_blocks`.
namespace rhoray::formats {
namespace {

using tests::MemoryFile;

enum class Kind { bricked_grid, linear_grid, sparse_grid, tets, clustered_tets };

std::string bytes_of(Kind kind) {
  const MemoryFile memory;
  const auto value = [](std::int64_t i, std::int64_t j, std::int64_t k) { return i * 7 + j * 3 + k; };
  if (kind == Kind::bricked_grid) {
    const auto grid = tests::sample_grid<std::uint8_t>(BrickLayout::bricked({5, 4, 3}), value);
    PackedFileWriter writer(memory.descriptor(), describe(grid.description), grid_arrays(grid.description));
    grid.write_into(writer).commit();
  } else if (kind == Kind::sparse_grid) {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    const auto some = [](std::int64_t i, std::int64_t j, std::int64_t k) {
      return i < 2 ? nan : static_cast<float>(i + j + k);
    };
    return tests::made_grid({.sample_count = {4, 3, 3},
                             .brick_edge = 2,
                             .is_sparse = true,
                             .axes = {{{-1, 0, 0.5, 3}, {}, {0, 1, 8}}}},
                            {{"density", some, true}})
        .file();
  } else if (kind == Kind::linear_grid) {
    const auto grid = tests::sample_grid<float>(BrickLayout::linear({3, 4, 5}), value);
    PackedFileWriter writer(memory.descriptor(), describe(grid.description), grid_arrays(grid.description));
    grid.write_into(writer).commit();
  } else {
    auto mesh = tests::sample_tets(1, {{"f", [](const Vec3& p) { return p.x; }}}, {2, 2, 1});
    if (kind == Kind::clustered_tets) mesh = clustered(mesh, 4);
    PackedFileWriter writer(memory.descriptor(), describe(mesh.description), tet_mesh_arrays(mesh.description));
    mesh.write_into(writer).commit();
  }
  return memory.content();
}

template <class T>
double sum_of_samples(const BrickGrid& grid, std::size_t field) {
  const std::span<const T> samples = grid.samples<T>(field);
  const BrickLayout& layout = grid.description().layout;
  std::optional<SparseAddress> sparse;
  if (layout.is_sparse) sparse.emplace(layout, grid.tables(), grid.brick_slots());
  const Index3 padded = layout.padded_count();
  double sum = 0;
  for (std::int64_t k = 0; k < padded.z; ++k)
    for (std::int64_t j = 0; j < padded.y; ++j)
      for (std::int64_t i = 0; i < padded.x; ++i) {
        const std::uint64_t address = sparse ? (*sparse)(i, j, k) : grid.tables().address(i, j, k);
        if (sparse && address == SparseAddress::no_sample) continue;
        EXPECT_LT(address, samples.size());
        const auto value = static_cast<double>(samples[address]);
        if (!std::isnan(value)) sum += value;
      }
  return sum;
}

/// Reads everything that a renderer would read, through the indices in the file. Also runs under
/// address sanitizer.
double read_all(const PackedFile& file) {
  double sum = 0;
  const auto add_levels = [&sum](const auto& levels) {
    for (const auto& level : levels.ranges)
      for (const auto value : level)
        if (std::isfinite(static_cast<double>(value))) sum += static_cast<double>(value);
  };
  if (file.description().kind == "grid") {
    const BrickGrid grid(file);
    for (std::size_t f = 0; f < grid.description().fields.size(); ++f)
      with_element_type(grid.description().fields[f].type, [&](auto zero) {
        sum += sum_of_samples<decltype(zero)>(grid, f);
        add_levels(grid.macro_levels<decltype(zero)>(f));
      });
    for (const std::vector<double>& axis : grid.description().axes)
      for (std::size_t i = 1; i < axis.size(); ++i) EXPECT_GT(axis[i], axis[i - 1]);
    return sum;
  }
  const TetMesh mesh(file);
  const auto add_cell = [&](std::uint64_t cell) {
    for (const std::uint32_t point : mesh.cell(cell)) {
      EXPECT_LT(point, mesh.points().size());
      sum += mesh.points()[point][0] + static_cast<double>(mesh.values<float>(0)[point]);
    }
  };
  if (mesh.has_clusters()) {
    for (std::uint64_t cell = 0; cell < mesh.description().cell_count; ++cell) add_cell(cell);
    for (const auto& level : mesh.cluster_ranges<float>(0))
      for (const RangeBlock<float>& block : level)
        for (const float value : block.hi)
          if (std::isfinite(value)) sum += static_cast<double>(value);
    return sum;
  }
  const auto leaves = static_cast<std::uint64_t>(volume(mesh.description().lattice.macro.leaf_count));
  for (std::uint64_t leaf = 0; leaf < leaves; ++leaf)
    for (const std::uint32_t cell : mesh.leaf_lists().list(leaf)) {
      EXPECT_LT(cell, mesh.description().cell_count);
      add_cell(cell);
    }
  add_levels(mesh.macro_levels<float>(0));
  return sum;
}

struct Outcome {
  bool refused_by_open = false;
  bool refused_by_view = false;
};

/// @param changed  offset of the only changed byte
Outcome judge(const MemoryFile& memory, std::uint64_t changed) {
  Outcome outcome;
  std::optional<PackedFile> file;
  try {
    file = PackedFile::from_descriptor(memory.descriptor(), "damaged.rho");
  } catch (const Error&) {
    outcome.refused_by_open = true;
    return outcome;
  }
  const std::vector<DamagedBlock> damaged = file->damaged_blocks(1);
  EXPECT_EQ(damaged.size(), 1U) << "byte " << changed;
  if (!damaged.empty()) {
    EXPECT_LE(damaged[0].first_byte, changed);
    EXPECT_LT(changed, damaged[0].first_byte + damaged[0].byte_count);
  }
  try {
    read_all(*file);
  } catch (const Error&) {
    outcome.refused_by_view = true;
  }
  return outcome;
}

class DamagedFile : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, DamagedFile,
                         testing::Values(Kind::bricked_grid, Kind::linear_grid, Kind::sparse_grid, Kind::tets,
                                         Kind::clustered_tets));

TEST_P(DamagedFile, every_flipped_bit_is_refused_or_harmless) {
  const std::string bytes = bytes_of(GetParam());
  const MemoryFile memory(bytes);
  ASSERT_GE(read_all(PackedFile::from_descriptor(memory.descriptor(), "whole.rho")), 0);
  std::size_t by_open = 0, by_view = 0;
  for (std::uint64_t at = 0; at < bytes.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      memory.put(at, static_cast<char>(bytes[at] ^ (1 << bit)));
      const Outcome outcome = judge(memory, at);
      by_open += outcome.refused_by_open;
      by_view += outcome.refused_by_view;
    }
    memory.put(at, bytes[at]);
  }
  EXPECT_GE(by_open, 8U * (4096 + 64)) << "header and seal are checked at opening";
  EXPECT_LT(by_open, 8 * bytes.size()) << "the data area is not";
  EXPECT_EQ(by_view > 0, GetParam() != Kind::bricked_grid && GetParam() != Kind::linear_grid)
      << "a mesh holds indices and a sparse grid slots that a flip can make too large; the others hold none";
  EXPECT_EQ(memory.content(), bytes);
}

TEST_P(DamagedFile, every_truncation_is_refused) {
  const std::string bytes = bytes_of(GetParam());
  const MemoryFile memory(bytes);
  for (std::uint64_t length = bytes.size(); length-- > 0;) {
    memory.resize(length);
    EXPECT_THROW(PackedFile::from_descriptor(memory.descriptor(), "cut.rho"), Error) << length;
  }
}

TEST_P(DamagedFile, appended_bytes_are_refused) {
  const std::string bytes = bytes_of(GetParam());
  for (const std::string& tail :
       {std::string(1, '\0'), std::string(64, '\0'), std::string(4096, 'x'), bytes, bytes.substr(bytes.size() - 64)}) {
    const MemoryFile memory(bytes + tail);
    EXPECT_THROW(PackedFile::from_descriptor(memory.descriptor(), "longer.rho"), Error) << tail.size();
  }
}

TEST_P(DamagedFile, random_byte_substitutions_are_refused_or_harmless) {
  const std::string bytes = bytes_of(GetParam());
  const MemoryFile memory(bytes);
  std::mt19937_64 random(20260101);
  for (int round = 0; round < 20'000; ++round) {
    const std::uint64_t at = random() % bytes.size();
    const char other = static_cast<char>(bytes[at] ^ static_cast<char>(1 + random() % 255));
    memory.put(at, other);
    judge(memory, at);
    memory.put(at, bytes[at]);
  }
}

// Several bytes at once, anywhere: if the file opens, reading must stay inside it.
TEST_P(DamagedFile, random_bursts_never_lead_out_of_the_file) {
  const std::string bytes = bytes_of(GetParam());
  const MemoryFile memory(bytes);
  std::mt19937_64 random(7);
  std::size_t opened = 0;
  for (int round = 0; round < 5'000; ++round) {
    const std::uint64_t at = 4096 + random() % (bytes.size() - 4096 - 64 - 8);
    std::string burst(1 + random() % 8, '\0');
    for (char& byte : burst) byte = static_cast<char>(random());
    memory.put(at, burst);
    try {
      const PackedFile file = PackedFile::from_descriptor(memory.descriptor(), "burst.rho");
      ++opened;
      read_all(file);
    } catch (const Error&) {
    }
    memory.put(at, std::string_view(bytes).substr(at, burst.size()));
  }
  EXPECT_GT(opened, 1000U);
}

/// Writes 1 GiB of data that do not repeat, in one array.
void make_large_file(const MemoryFile& memory) {
  constexpr std::uint64_t bytes = std::uint64_t{1} << 30;
  PackedFileWriter writer(memory.descriptor(), {.kind = "bytes"},
                          {{.name = "all", .type = ElementType::U64, .shape = {bytes / 8}}});
  std::vector<std::uint64_t> part(1 << 20);
  std::uint64_t value = 1;
  for (std::uint64_t at = 0; at < bytes; at += part.size() * 8) {
    // the product of odd numbers never becomes 0
    for (std::uint64_t& number : part) number = value *= 6364136223846793005U;
    writer.write("all", at, std::as_bytes(std::span(part)));
  }
  writer.commit();
}

TEST(LargeFile, loses_none_of_10000_flipped_bits) {
  if (std::getenv("RHORAY_LARGE_FILES") == nullptr) GTEST_SKIP() << "RHORAY_LARGE_FILES is not set (tests/nightly)";
  const MemoryFile memory;
  make_large_file(memory);
  const PackedFile file = PackedFile::from_descriptor(memory.descriptor(), "large.rho");
  ASSERT_TRUE(file.damaged_blocks().empty());
  const ArrayEntry& array = file.entry("all");
  std::mt19937_64 random(1);
  std::size_t flips = 0;
  while (flips < 10'000) {
    std::map<std::uint64_t, char> damage;  // by offset; at most one per block
    std::set<std::uint64_t> blocks;
    while (damage.size() < 2'000) {
      const std::uint64_t at = array.first_byte + random() % array.byte_count;
      if (!blocks.insert((at - array.first_byte) >> 16).second) continue;
      char byte = 0;
      ASSERT_EQ(::pread(memory.descriptor(), &byte, 1, static_cast<off_t>(at)), 1);
      damage[at] = byte;
      memory.put(at, static_cast<char>(byte ^ (1 << (random() % 8))));
    }
    const std::vector<DamagedBlock> found = file.damaged_blocks();
    EXPECT_EQ(found.size(), damage.size());
    for (const DamagedBlock& block : found) {
      const auto flipped = damage.lower_bound(block.first_byte);
      EXPECT_TRUE(flipped != damage.end() && flipped->first < block.first_byte + block.byte_count) << block.first_byte;
    }
    for (const auto& [at, byte] : damage) memory.put(at, byte);
    flips += damage.size();
  }
  EXPECT_TRUE(file.damaged_blocks().empty());
}

TEST(LargeFile, is_refused_when_it_is_cut_at_any_page) {
  if (std::getenv("RHORAY_LARGE_FILES") == nullptr) GTEST_SKIP() << "RHORAY_LARGE_FILES is not set (tests/nightly)";
  const MemoryFile memory;
  make_large_file(memory);
  std::uint64_t bytes = PackedFile::from_descriptor(memory.descriptor(), "large.rho").file_bytes(), refused = 0;
  std::clock_t longest = 0;
  for (bytes = (bytes - 1) / 4096 * 4096; bytes > 0; bytes -= 4096) {
    memory.resize(bytes);
    const std::clock_t begin = std::clock();
    try {
      PackedFile::from_descriptor(memory.descriptor(), "large.rho");
      ADD_FAILURE() << "opened with " << bytes << " bytes";
    } catch (const Error& error) {
      ++refused;
      const std::string_view fact = error.what();
      EXPECT_NE(fact.find(bytes > 4096 ? "cut short" : "at least 4160 bytes"), fact.npos) << fact;
    }
    longest = std::max(longest, std::clock() - begin);
  }
  EXPECT_GT(refused, (std::uint64_t{1} << 30) / 4096);
  RecordProperty("longest_refusal_us", std::to_string(longest * 1'000'000 / CLOCKS_PER_SEC));
  std::cout << refused << " cuts refused, the slowest in " << longest * 1'000'000 / CLOCKS_PER_SEC << " us of CPU\n";
}

}  // namespace
}  // namespace rhoray::formats
