// Runs the whole catalogue of hard cases (catalogue/hard_case.h) with every method that answers
// them and with exact arithmetic.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/hard_cases/catalogue/trial.h"

namespace rhoray::tests {
namespace {

std::string listed(const std::vector<std::string>& complaints) {
  std::string text;
  for (const std::string& complaint : complaints) text += complaint + '\n';
  return text;
}

TEST(Catalogue, certified_is_right_in_every_case) {
  for (const HardCase& hard_case : catalogue()) {
    Trial trial(hard_case);
    const Tally tally = trial.tally(method_named("certified"));
    EXPECT_EQ(tally.wrong(), 0) << hard_case.id << " of " << tally.queries << '\n' << listed(tally.complaints);
  }
}

TEST(Catalogue, the_judge_says_what_closed_forms_say) {
  int judged = 0;
  for (const HardCase& hard_case : catalogue()) {
    if (!hard_case.known) continue;
    ++judged;
    const Tally tally = Trial(hard_case).against_known_answers();
    EXPECT_EQ(tally.wrong(), 0) << hard_case.id << '\n' << listed(tally.complaints);
    EXPECT_GT(tally.queries, static_cast<int>(hard_case.rays.size()) / 2) << hard_case.id;
  }
  EXPECT_GE(judged, 20) << "cases with a closed form";
}

TEST(Catalogue, every_case_is_still_hard) {
  for (const HardCase& hard_case : catalogue()) {
    if (hard_case.naive.method.empty()) {
      EXPECT_FALSE(hard_case.naive.reason.empty()) << hard_case.id;
      continue;
    }
    ASSERT_GT(hard_case.naive.at_least, 0) << hard_case.id;
    const Tally tally = Trial(hard_case).tally(method_named(hard_case.naive.method));
    EXPECT_GE(tally.not_seen(), hard_case.naive.at_least)
        << hard_case.id << ": " << hard_case.naive.method << " no longer fails: is this case still the hard one?";
  }
}

TEST(Catalogue, direct_methods_are_right_where_they_promise_it) {
  for (const HardCase& hard_case : catalogue()) {
    Trial trial(hard_case);
    const Tally tally = trial.tally(method_named("direct double"));
    const int allowed = hard_case.direct_may_fail_by.empty() ? 0 : tally.queries / 10;
    EXPECT_LE(tally.wrong(), allowed) << hard_case.id << " of " << tally.queries << '\n' << listed(tally.complaints);
  }
}

// Many rays of the catalogue pass exactly through edges and vertices. Single precision moves the
// corners of a mesh's surface along each axis by up to 2^-25 of the longest edge of the mesh's box
// (render/triangles/facets.h), so rounding decides there. Each answer must be right for a ray this
// close. An answer is right for no such ray if the ray slipped through between two facets.
TEST(Catalogue, float_on_meshes_is_right_for_a_ray_next_to_the_one_asked) {
  constexpr double moved_by = 0x1p-25;
  int cases = 0;
  for (const HardCase& hard_case : catalogue()) {
    if (hard_case.asked != Asked::surface_of_mesh) continue;
    Trial trial(hard_case);
    if (!trial.resolves(moved_by)) continue;
    ++cases;
    const Tally tally = trial.tally(method_named("direct float"), moved_by);
    // Where a point's value is the isovalue, moving the ray does not help: T22 needs 2 of 460.
    const int allowed = hard_case.direct_may_fail_by.empty() ? 0 : tally.queries / 200;
    EXPECT_LE(tally.wrong(), allowed) << hard_case.id << " of " << tally.queries << '\n' << listed(tally.complaints);
  }
  EXPECT_EQ(cases, 26) << "all but T07, whose box is a million times as long as its cells are thick";
}

/// Cases of the families that are not in the catalogue: where they are tested, or why they cannot
/// be tested yet.
struct Elsewhere {
  std::string_view id, test, reason;
};
constexpr std::array elsewhere{
    Elsewhere{"R32", "", "a scene shows one isosurface; several belong with transparency"},
    Elsewhere{"V16", "MoreThan32Bits.of_samples_are_told_apart", ""},
    Elsewhere{"V23", "",
              "there are no masks of active cells: ranges are compared with the isovalue that a frame keeps"},
    Elsewhere{"D15", "RawVolume.of_swapped_bytes_behind_an_odd_header_is_the_same_volume", ""},
    Elsewhere{"T21", "DefectiveMeshes.are_crossed_first_where_a_cell_is_and_nowhere_without_both_sides", ""},
    Elsewhere{"T27", "CleanMesh.refuses_a_vertex_index_out_of_range_naming_cell_and_index", ""},
    Elsewhere{"T29", "CleanMesh.refuses_a_mesh_without_volume", ""},
    Elsewhere{"T30", "LinearCells.of_every_kind_agree_on_their_faces", ""},
    Elsewhere{"T31", "", "offsets of lists are 64 bits wide in the format; a mesh that needs them fits no test"},
    Elsewhere{"M13",
              "MaximumQueue.gives_entries_back_by_bound_then_nearness_then_found_first_whatever_the_order_of_insertion",
              ""},
    Elsewhere{"M15", "", "no question asks for the smallest value"},
    Elsewhere{"X01", "House.compiles_every_own_source_with_one_set_of_warnings_and_one_arithmetic", ""},
    Elsewhere{"X02", "FloatingPoint.of_the_host_does_not_change_pictures_and_is_kept", ""},
    Elsewhere{"X03", "FloatingPoint.of_the_host_does_not_change_answers_to_rays_and_is_kept", ""},
    Elsewhere{"X04", "Machines.answer_rays_with_the_same_bits_as_far_as_is_promised", ""},
    Elsewhere{"X05", "OddPictures.are_made_of_the_answers_to_single_rays", ""},
    Elsewhere{"X06", "PackedFile.a_file_cut_short_while_open_has_damaged_blocks_and_does_not_end_the_process", ""},
    Elsewhere{"X07", "Spacings.without_an_inverse_are_refused", ""},
    Elsewhere{"X08", "ExtremeFieldsOfView.show_every_pixel_in_its_own_direction", ""}};

/// TEST(Suite, name) of every test source, as Suite.name.
std::set<std::string> tests_in_the_sources() {
  std::set<std::string> names;
  const std::regex definition(R"(TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\))");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(RHORAY_TESTS_FOLDER)) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream file(entry.path());
    const std::string text(std::istreambuf_iterator<char>(file), {});
    for (std::sregex_iterator match(text.begin(), text.end(), definition), end; match != end; ++match)
      names.insert((*match)[1].str() + '.' + (*match)[2].str());
  }
  return names;
}

TEST(Catalogue, holds_every_case_of_the_families) {
  const std::set<std::string> tests = tests_in_the_sources();
  std::multiset<std::string> ids;
  for (const HardCase& hard_case : catalogue()) ids.insert(hard_case.id.substr(0, 3));
  for (const Elsewhere& other : elsewhere) {
    ids.insert(std::string(other.id));
    EXPECT_NE(other.test.empty(), other.reason.empty()) << other.id;
    if (!other.test.empty()) {
      EXPECT_TRUE(tests.contains(std::string(other.test))) << other.id << ": " << other.test;
    }
  }
  for (const auto& [family, count] :
       std::map<char, int>{{'R', 34}, {'V', 23}, {'D', 15}, {'T', 32}, {'M', 15}, {'X', 8}})
    for (int n = 1; n <= count; ++n) {
      const std::string id{family, static_cast<char>('0' + n / 10), static_cast<char>('0' + n % 10)};
      EXPECT_TRUE(ids.contains(id)) << id << " is neither a case nor named as tested elsewhere";
    }
  for (const Elsewhere& other : elsewhere) EXPECT_EQ(ids.count(std::string(other.id)), 1U) << other.id;
}

}  // namespace
}  // namespace rhoray::tests
