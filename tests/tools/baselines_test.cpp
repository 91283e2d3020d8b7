#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <set>
#include <sstream>

#include "formats/base/text.h"
#include "tests/tools/workbench.h"

/// tests/tools/baselines: small pictures of synthetic data, one for each feature that pictures may
/// show.
namespace rhoray::tests {
namespace {

const std::filesystem::path baselines = std::filesystem::path(RHORAY_SOURCE_DIR) / "tests/tools/baselines";

struct Baseline {
  std::string name;
  std::string words;  ///< arguments of `rhoray render`
};

std::vector<Baseline> listed_baselines() {
  std::vector<Baseline> listed;
  std::istringstream lines(read_file(baselines / "pictures.txt"));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    const std::size_t end = line.find(' ');
    listed.push_back({line.substr(0, end), line.substr(line.find_first_not_of(' ', end))});
  }
  return listed;
}

/// cloud.raw: 32^3 floats that decrease with the distance from the centre, with waves. No data
/// beyond 15 samples from the centre.
void write_cloud(const std::filesystem::path& file) {
  std::string bytes;
  for (int k = 0; k < 32; ++k)
    for (int j = 0; j < 32; ++j)
      for (int i = 0; i < 32; ++i) {
        const double distance = std::hypot(i - 15.5, j - 15.5, k - 15.5);
        const auto value = distance > 15 ? std::numeric_limits<float>::quiet_NaN()
                                         : static_cast<float>(1.5 - distance / 10 + 0.2 * std::sin(i) * std::cos(j));
        char four[sizeof value];
        std::memcpy(four, &value, sizeof value);
        bytes.append(four, sizeof four);
      }
  write_file(file, bytes);
}

void make_data(const Workbench& bench) {
  bench.make_ball();
  bench.make_box();
  bench.make_cube();
  bench.make_photo();
  write_cloud(bench / "cloud.raw");
  write_file(bench / "star.off",  // an octahedron around ball.rho
             "OFF\n6 8 0\n2 11.5 11.5\n21 11.5 11.5\n11.5 2 11.5\n11.5 21 11.5\n11.5 11.5 2\n11.5 11.5 21\n"
             "3 0 4 2\n3 2 4 1\n3 1 4 3\n3 3 4 0\n3 2 5 0\n3 1 5 2\n3 3 5 1\n3 0 5 3\n");
  const RunResult made = bench.shell(
      "set -e; rhoray-recipes smooth --size 48 -o smooth.nhdr; rhoray-recipes turbulent --size 48 -o turbulent.nhdr; "
      "pack() { rhoray pack \"$@\" -q; }; "
      "pack smooth.nhdr -o smooth.rho; pack smooth.nhdr --layout linear -o linear.rho; "
      "pack smooth.nhdr --spacing 0.1,1,3 -o thin.rho; pack turbulent.nhdr -o turbulent.rho; "
      "pack cloud.raw --raw 32x32x32:float32 -o cloud.rho; "
      "pack cloud.raw --raw 32x32x32:float32 --layout sparse -o sparse.rho; rhoray export sparse.rho -o cloud.vdb -q; "
      "pack box.vtu --structure leaves -o leaves.rho; pack star.off -o star.rho");
  ASSERT_EQ(made.exit_code, 0) << made.err;
}

/// The largest difference of any channel in each pixel, in units of 1/255.
std::vector<int> differences_of_pixels(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto bytes_of = [](const std::filesystem::path& file) {
    const auto input = OIIO::ImageInput::open(file.string());
    if (!input) throw std::runtime_error(OIIO::geterror());
    const OIIO::ImageSpec& spec = input->spec();
    std::vector<std::uint8_t> bytes(spec.image_pixels() * 3);
    EXPECT_EQ(spec.nchannels, 3);
    EXPECT_TRUE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, bytes.data()));
    return bytes;
  };
  const std::vector<std::uint8_t> of_a = bytes_of(a), of_b = bytes_of(b);
  if (of_a.size() != of_b.size()) return {};
  std::vector<int> differences(of_a.size() / 3);
  for (std::size_t i = 0; i < of_a.size(); ++i)
    differences[i / 3] = std::max(differences[i / 3], std::abs(of_a[i] - of_b[i]));
  return differences;
}

/// The numbers of an EXR file, unconverted.
std::vector<float> floats_of(const std::filesystem::path& file) {
  const auto input = OIIO::ImageInput::open(file.string());
  if (!input) throw std::runtime_error(OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  std::vector<float> numbers(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
  EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, numbers.data()));
  return numbers;
}

TEST(Baselines, are_at_least_40_and_each_has_its_picture) {
  std::set<std::string> names, pictures;
  for (const Baseline& baseline : listed_baselines())
    EXPECT_TRUE(names.insert(baseline.name).second) << baseline.name << " stands there twice";
  for (const auto& entry : std::filesystem::directory_iterator(baselines))
    if (entry.path().extension() == ".png") pictures.insert(entry.path().stem());
  EXPECT_EQ(names, pictures);
  EXPECT_GE(names.size(), 40U);
}

/// One pixel in 5,000 may differ by more than 1 of 255, none by more than 3: machines differ in the
/// last bit of a colour where rays graze a surface. Failed pictures are stored in BUILD/baselines,
/// with the expected picture and the difference. RHORAY_WRITE_BASELINES=1 renders the baselines
/// anew instead; look at each before it is committed.
TEST(Baselines, are_drawn_again) {
  const Workbench bench;
  make_data(bench);
  if (HasFatalFailure()) return;
  const bool are_written = std::getenv("RHORAY_WRITE_BASELINES") != nullptr;
  const std::filesystem::path failed = RHORAY_BINARY_DIR "/baselines";
  std::filesystem::remove_all(failed);
  for (const auto& [name, words] : listed_baselines()) {
    SCOPED_TRACE(name);
    const std::string picture = name + ".png", expected = (baselines / picture).string();
    const RunResult drawn = bench.shell("rhoray render " + words + " --size 96x96 --background '#203040' -q -o " +
                                        (are_written ? "'" + expected + "' --force" : picture));
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    if (are_written || drawn.exit_code != 0) continue;
    const std::vector<int> differences = differences_of_pixels(expected, bench / picture);
    const auto beyond = [&](int most) {
      return std::count_if(differences.begin(), differences.end(), [&](int difference) { return difference > most; });
    };
    const bool is_the_same = differences.size() == 96U * 96U && beyond(1) <= 1 && beyond(3) == 0;
    EXPECT_TRUE(is_the_same) << beyond(1) << " pixels differ by more than 1 of 255, " << beyond(3) << " by more than 3";
    if (is_the_same) continue;
    std::filesystem::create_directories(failed);
    std::filesystem::copy(bench / picture, failed / (name + "_is.png"));
    std::filesystem::copy(expected, failed / (name + "_expected.png"));
    bench.rhoray({"compare", expected, picture, "--map", (failed / (name + "_map.png")).string()});
  }
  EXPECT_FALSE(are_written) << "the pictures were drawn, not compared";
}

TEST(Baselines, have_the_same_bytes_with_any_number_of_threads) {
  const Workbench bench;
  make_data(bench);
  if (HasFatalFailure()) return;
  const std::vector<Baseline> all = listed_baselines();
  int compared = 0;
  for (std::size_t i = 0; i < all.size(); i += 4) {
    SCOPED_TRACE(all[i].name);
    std::vector<float> of_one;
    for (const int threads : {1, 2, 3, 4, 8}) {
      const RunResult drawn = bench.shell(
          concat("rhoray render ", all[i].words, " --size 96x96 -q --force -o drawn.exr --threads ", threads));
      ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
      const std::vector<float> numbers = floats_of(bench / "drawn.exr");
      ASSERT_GE(numbers.size(), 96U * 96U * 3U);
      if (threads == 1) of_one = numbers;
      EXPECT_TRUE(numbers.size() == of_one.size() &&
                  std::memcmp(numbers.data(), of_one.data(), numbers.size() * sizeof(float)) == 0)
          << threads << " threads";
    }
    ++compared;
  }
  EXPECT_GE(compared, 12);
}

}  // namespace
}  // namespace rhoray::tests
