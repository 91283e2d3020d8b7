// Every number of every header, ours and foreign, set to numbers that break sizes: the reader reads
// the file or refuses it, in at most 1 s and with at most 64 MiB more than it takes for the file as
// it was.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <new>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "formats/base/error.h"
#include "formats/base/text.h"
#include "formats/brick_grid.h"
#include "formats/color_grid.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/import/readers.h"
#include "preprocess/import/reading/zip_archive.h"
#include "tests/preprocess/import/lying_samples.h"
#include "tests/support/resealed.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::preprocess {
namespace {

using tests::TemporaryFolder;
using tests::write_file;

/// One number of a header, set to another.
struct Lie {
  std::string content;
  std::string description;
};

constexpr bool memory_is_counted = !tests::sanitized;

enum Ending : int { is_read = 0, is_refused = 10, ran_out_of_memory = 11, threw_something_else = 12 };

struct Cost {
  int status = 0;
  double cpu_s = 0;
  std::int64_t peak_kib = 0;
};

/// Reads the file in a child. CPU time is counted, not time: on a busy machine a child waits, but
/// computes no longer.
Cost cost_of(const Sample& sample, const std::filesystem::path& path) {
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) {
    constexpr rlim_t cpu_seconds = 5, address_bytes = rlim_t{8} << 30;
    const rlimit cpu{cpu_seconds, cpu_seconds}, address{address_bytes, address_bytes}, core{0, 0};
    ::setrlimit(RLIMIT_CPU, &cpu);
    if (memory_is_counted) ::setrlimit(RLIMIT_AS, &address);
    ::setrlimit(RLIMIT_CORE, &core);
    if (std::freopen("/dev/null", "w", stderr) == nullptr) ::_exit(threw_something_else);
    int ending = is_read;
    try {
      sample.read(path);
    } catch (const Error&) {
      ending = is_refused;
    } catch (const std::bad_alloc&) {
      ending = ran_out_of_memory;
    } catch (...) {
      ending = threw_something_else;
    }
    ::_exit(ending);
  }
  Cost cost;
  rusage usage{};
  while (::wait4(child, &cost.status, 0, &usage) < 0) {
  }
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  cost.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  cost.peak_kib = usage.ru_maxrss;
  return cost;
}

/// The lies about an integer that is written in decimal digits.
std::vector<std::string> lies_about(const std::string& number) {
  std::vector<std::string> lies{
      "0",          "1",          "-1",         "2147483647",          "2147483648",          "2147483649",
      "4294967295", "4294967296", "4294967297", "9223372036854775807", "9223372036854775808", "18446744073709551615"};
  if (number.size() < 18) {
    lies.push_back(std::to_string(std::stoll(number) + 1));
    lies.push_back(std::to_string(std::stoll(number) - 1));
  }
  return lies;
}

/// Lies about each integer in the first `header_bytes` bytes of a text. Parts of names and of
/// decimal fractions stay.
std::vector<Lie> lies_in_text(const std::string& content, std::size_t header_bytes) {
  std::vector<Lie> lies;
  const auto is_digit = [&](std::size_t i) { return std::isdigit(static_cast<unsigned char>(content[i])) != 0; };
  const auto is_word = [&](std::size_t i) {
    return std::isalnum(static_cast<unsigned char>(content[i])) != 0 || content[i] == '.' || content[i] == '_';
  };
  for (std::size_t at = 0; at < header_bytes; ++at) {
    if (!is_digit(at) || (at > 0 && is_word(at - 1))) continue;
    std::size_t end = at;
    while (end < content.size() && is_digit(end)) ++end;
    if (end == content.size() || !is_word(end))
      for (const std::string& lie : lies_about(content.substr(at, end - at)))
        lies.push_back({content.substr(0, at) + lie + content.substr(end),
                        concat("byte ", at, ": ", content.substr(at, end - at), " to ", lie)});
    at = end;
  }
  return lies;
}

/// Lies about an integer of `bytes` bytes, little-endian.
std::vector<Lie> lies_in_bytes(const std::string& content, std::size_t at, std::size_t bytes) {
  std::uint64_t old = 0;
  std::memcpy(&old, content.data() + at, bytes);
  constexpr std::uint64_t one = 1;
  std::vector<Lie> lies;
  for (const std::uint64_t number : {std::uint64_t{0}, one, old + 1, old - 1, (one << 15) - 1, one << 15,
                                     (one << 16) - 1, (one << 31) - 1, one << 31, (one << 31) + 1, (one << 32) - 1,
                                     one << 32, (one << 32) + 1, (one << 63) - 1, one << 63, ~std::uint64_t{0}}) {
    Lie lie{content, concat("byte ", at, ": ", old, " to ", number)};
    std::memcpy(lie.content.data() + at, &number, bytes);
    if (lie.content != content) lies.push_back(std::move(lie));
  }
  return lies;
}

/// Some of them, spread evenly; all when the environment asks.
std::vector<Lie> some_of(std::vector<Lie> lies) {
  constexpr std::size_t most = 60;
  if (lies.size() <= most || std::getenv("RHORAY_ALL_LIES") != nullptr) return lies;
  std::vector<Lie> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(std::move(lies[i * lies.size() / most]));
  return some;
}

/// Reads each lie; returns how many were read or refused.
int check_lies(const Sample& sample, const std::vector<Lie>& lies) {
  const TemporaryFolder folder;
  for (const auto& [name, content] : sample.others) write_file(folder / name, content);
  const std::filesystem::path path = folder / sample.file;
  write_file(path, sample.content);
  const Cost honest = cost_of(sample, path);
  EXPECT_TRUE(WIFEXITED(honest.status) && WEXITSTATUS(honest.status) == is_read)
      << sample.file << " as it was: status " << honest.status;
  int checked = 0;
  for (const Lie& lie : lies) {
    write_file(path, lie.content);
    const Cost cost = cost_of(sample, path);
    const std::string what = concat(sample.file, ", ", lie.description);
    EXPECT_FALSE(WIFSIGNALED(cost.status)) << what << ": signal " << WTERMSIG(cost.status);
    if (WIFEXITED(cost.status)) {
      const int ending = WEXITSTATUS(cost.status);
      EXPECT_TRUE(ending == is_read || ending == is_refused)
          << what << ": " << (ending == ran_out_of_memory ? "asks for memory" : "throws what is no Error");
    }
    EXPECT_LE(cost.cpu_s, 1) << what;
    if (memory_is_counted) {
      EXPECT_LE(cost.peak_kib - honest.peak_kib, 64 << 10) << what;
    }
    ++checked;
  }
  return checked;
}

class LyingHeaders : public testing::TestWithParam<std::size_t> {};

TEST_P(LyingHeaders, in_text_are_read_or_refused_at_little_cost) {
  const Sample sample = text_samples()[GetParam()];
  EXPECT_GT(check_lies(sample, lies_in_text(sample.content, sample.content.size())), 20);
}

INSTANTIATE_TEST_SUITE_P(Foreign, LyingHeaders, testing::Range<std::size_t>(0, 20));

TEST(LyingHeaders, are_tried_for_every_sample) {
  EXPECT_EQ(text_samples().size(), 20U) << "the range of the suite above says how many there are";
}

TEST(LyingHeaders, in_nifti_are_read_or_refused_at_little_cost) {
  std::string header(352, '\0');
  const auto put = [&]<class T>(std::size_t at, T value) { std::memcpy(header.data() + at, &value, sizeof value); };
  put(0, std::int32_t{348});
  for (const auto& [at, value] : std::map<std::size_t, int>{
           {40, 3}, {42, 2}, {44, 2}, {46, 2}, {48, 1}, {50, 1}, {52, 1}, {54, 1}, {70, 2}, {72, 8}})
    put(at, static_cast<std::int16_t>(value));
  for (const std::size_t at : {76U, 80U, 84U, 88U}) put(at, 1.0F);
  put(108, 352.0F);
  header.replace(344, 4, std::string("n+1\0", 4));
  const Sample sample{"a.nii", header + eight_bytes, volume};
  std::vector<Lie> lies = lies_in_bytes(sample.content, 0, 4);
  const auto add = [&](std::size_t at, std::size_t bytes) {
    for (Lie& lie : lies_in_bytes(sample.content, at, bytes)) lies.push_back(std::move(lie));
  };
  for (std::size_t at = 40; at < 56; at += 2) add(at, 2);
  add(70, 2), add(72, 2), add(252, 2), add(254, 2);
  for (const float offset : {0.0F, -1.0F, 1.0F, 353.0F, 2147483648.0F, 4294967296.0F, 9.2233720e18F, 3e38F}) {
    Lie lie{sample.content, concat("vox_offset to ", offset)};
    std::memcpy(lie.content.data() + 108, &offset, sizeof offset);
    lies.push_back(std::move(lie));
  }
  EXPECT_GT(check_lies(sample, lies), 100);
}

TEST(LyingHeaders, in_binary_stl_and_plot3d_are_read_or_refused_at_little_cost) {
  const Sample stl{"a.stl",
                   std::string(80, ' ') + bytes_of<std::uint32_t>({1}) +
                       bytes_of<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}) + std::string(2, '\0'),
                   surface};
  EXPECT_GT(check_lies(stl, lies_in_bytes(stl.content, 80, 4)), 5);
  std::vector<float> coordinates;
  for (int axis = 0; axis < 3; ++axis)
    for (int p = 0; p < 8; ++p) coordinates.push_back(static_cast<float>(p >> axis & 1));
  std::vector<float> solution(4 + 40, 1);
  const std::string sizes = bytes_of<std::int32_t>({2, 2, 2});
  const Sample plot3d{"a.xyz", sizes + bytes_of(coordinates), cells, {{"a.q", sizes + bytes_of(solution)}}};
  std::vector<Lie> lies;
  for (const std::size_t at : {0U, 4U, 8U})
    for (Lie& lie : lies_in_bytes(plot3d.content, at, 4)) lies.push_back(std::move(lie));
  EXPECT_GT(check_lies(plot3d, lies), 30);
}

using Reader = void (*)(const std::filesystem::path&);

/// A volume of samples or of colours, whatever the field.
void volume_or_colors(const std::filesystem::path& path) {
  try {
    volume(path);
  } catch (const Error&) {
    read_volume(path, {.colors = true});
  }
}
/// Legacy VTK and XDMF tell in the file what it holds.
void volume_cells_or_surface(const std::filesystem::path& path) {
  for (const Reader reader : {volume, cells}) try {
      return reader(path);
    } catch (const Error&) {
    }
  surface(path);
}
void archive(const std::filesystem::path& path) {
  read_zip(path, [](const std::string&, std::string_view) {});
}

/// A format with seeds of the fuzz harness `import`: small valid files in its variants. A
/// seed holds the file and, after a separating line, its companion file if it has one.
struct SeedFormat {
  const char* name;
  const char* extension;
  const char* extension_beside;
  Reader read;

  friend void PrintTo(const SeedFormat& format, std::ostream* to) { *to << format.name; }
};

constexpr SeedFormat seed_formats[] = {
    {"bov", ".bov", ".raw", volume},
    {"brainvisa", ".tri", "", surface},
    {"carp", ".elem", ".pts", cells},
    {"cube", ".cube", "", volume},
    {"gmsh", ".msh", "", cells},
    {"legacy_vtk", ".vtk", "", volume_cells_or_surface},
    {"matlab", ".mat", "", volume},
    {"medit", ".mesh", ".sol", cells},
    {"medit_binary", ".meshb", ".solb", cells},
    {"metaimage", ".mhd", ".raw", volume_or_colors},
    {"netgen", ".vol", "", cells},
    {"nifti", ".nii", "", volume_or_colors},
    {"npy", ".npy", "", volume_or_colors},
    {"npz", ".npz", "", volume},
    {"nrrd", ".nhdr", ".raw", volume_or_colors},
    {"obj", ".obj", "", surface},
    {"off", ".off", "", surface},
    {"plot3d", ".xyz", ".q", cells},
    {"ply", ".ply", "", surface},
    {"pvti", ".pvti", ".vti", volume},
    {"slc", ".slc", "", volume},
    {"stl", ".stl", "", surface},
    {"tetgen_faces", ".face", ".node", surface},
    {"tetgen_mesh", ".node", ".ele", cells},
    {"tetgen_surface", ".poly", ".mtr", surface},
    {"vti", ".vti", "", volume},
    {"vtu", ".vtu", "", cells},
    {"xdmf", ".xdmf", ".bin", volume_cells_or_surface},
    {"zip", ".zip", "", archive},
};

/// Parts a seed into its files, beside it, and reads them.
void read_parts(const std::filesystem::path& path, const SeedFormat& format) {
  constexpr std::string_view next_file = "\n-- next file --\n";
  const std::string whole = tests::read_file(path);
  const std::size_t end = whole.find(next_file);
  const std::filesystem::path file = path.parent_path() / concat("input", format.extension);
  if (end != std::string::npos)
    write_file(path.parent_path() / concat("input", format.extension_beside), whole.substr(end + next_file.size()));
  write_file(file, whole.substr(0, end));
  format.read(file);
}

/// Lies about the words of four bytes, in either order of bytes, behind the last line before what
/// is not text, and behind the underscore with which appended data of VTK begin.
std::vector<Lie> lies_in_words(const std::string& content) {
  const auto is_text = [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return code == '\n' || code == '\t' || code == '\r' || (code >= 32 && code < 127);
  };
  std::vector<Lie> lies;
  const auto binary = std::find_if_not(content.begin(), content.end(), is_text);
  if (binary == content.end()) return lies;
  const std::size_t line_end = content.rfind('\n', static_cast<std::size_t>(binary - content.begin()));
  std::size_t at = line_end == std::string::npos ? 0 : line_end + 1;
  if (content[at] == '_') ++at;
  for (; at + 4 <= content.size(); at += 4)
    for (const char* word : {"\0\0\0\0", "\xff\xff\xff\xff", "\xff\xff\xff\x7f", "\x7f\xff\xff\xff", "\0\0\0\x80",
                             "\x80\0\0\0", "\1\0\0\0", "\0\0\0\1"}) {
      Lie lie{content,
              concat("byte ", at, ": word of bytes ", static_cast<int>(word[0]), ' ', static_cast<int>(word[3]))};
      std::memcpy(lie.content.data() + at, word, 4);
      if (lie.content != content) lies.push_back(std::move(lie));
    }
  return lies;
}

class LyingSeeds : public testing::TestWithParam<SeedFormat> {};

TEST_P(LyingSeeds, are_read_or_refused_at_little_cost) {
  const SeedFormat& format = GetParam();
  int checked = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(RHORAY_FUZZ_SEEDS) / format.name)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("found_")) continue;  // not valid
    const Sample sample{name, tests::read_file(entry.path()),
                        [&](const std::filesystem::path& path) { read_parts(path, format); }};
    std::vector<Lie> lies = some_of(lies_in_text(sample.content, sample.content.size()));
    for (Lie& lie : some_of(lies_in_words(sample.content))) lies.push_back(std::move(lie));
    checked += check_lies(sample, lies);
  }
  EXPECT_GT(checked, 20);
}

INSTANTIATE_TEST_SUITE_P(Foreign, LyingSeeds, testing::ValuesIn(seed_formats),
                         [](const auto& format) { return std::string(format.param.name); });

TEST(LyingSeeds, are_tried_for_every_format) {
  const std::filesystem::directory_iterator folders(RHORAY_FUZZ_SEEDS);
  EXPECT_EQ(std::distance(begin(folders), end(folders)), std::ssize(seed_formats));
}

/// Opens a packed file as what it is.
void packed(const std::filesystem::path& path) {
  const formats::PackedFile file = formats::PackedFile::open(path);
  const std::string& kind = file.description().kind;
  if (kind == "grid") formats::BrickGrid{file};
  if (kind == "tets") formats::TetMesh{file};
  if (kind == formats::TriangleMesh::kind) formats::TriangleMesh{file};
  if (kind == formats::ColorGrid::kind) formats::ColorGrid{file};
}

TEST(LyingHeaders, of_packed_files_are_read_or_refused_at_little_cost) {
  for (const char* name :
       {"1.0-grid.rho", "1.0-tets.rho", "1.1-rectilinear-grid.rho", "1.1-sparse-grid.rho", "1.2-clustered-tets.rho",
        "1.3-surface.rho", "1.4-colors.rho", "1.5-certified-grid.rho", "1.7-tets.rho", "1.8-grid.rho"}) {
    const std::string content = tests::read_file(std::filesystem::path(RHORAY_RELEASED_FILES) / name);
    const Sample sample{name, content, packed};
    std::vector<Lie> lies = lies_in_bytes(content, 0, 8);
    for (const std::size_t at : {8U, 16U})
      for (Lie& lie : lies_in_bytes(content, content.size() - 64 + at, 8)) lies.push_back(std::move(lie));
    tests::Envelope parts = tests::open_envelope(content);
    const std::string json = parts.json;
    std::vector<Lie> lies_in_json = lies_in_text(json, json.size());
    std::erase_if(lies_in_json, [&](const Lie& lie) {
      // Bins of histograms are many, and nothing is sized by them: the first one stands for all.
      // Arrays of padding too.
      const std::size_t at = std::stoul(lie.description.substr(5));
      const std::size_t list = json.rfind('[', at), name_end = json.rfind("\":{", at);
      const bool in_list = list != std::string::npos && json.find(']', list) > at;
      if (in_list && list > 12 && json.compare(list - 12, 9, "histogram") == 0 && at != list + 1) return true;
      return json.compare(json.rfind('"', name_end - 1) + 1, 5, "_pad.") == 0;
    });
    for (const Lie& lie : some_of(std::move(lies_in_json))) {
      parts.json = lie.content;
      lies.push_back({tests::seal_again(parts), lie.description});
    }
    EXPECT_GT(check_lies(sample, lies), 90) << name;
  }
}

}  // namespace
}  // namespace rhoray::preprocess
