// Rays and answers of wrong shapes are refused before anything is written.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"

namespace rhoray::tests {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

/// Some rays through a grid. Each call is made with a scratch and with a context.
class BadRays : public testing::Test {
 protected:
  void refuse(const std::string& words, const Rays& rays, ErrorCode code = ErrorCode::usage) {
    std::vector<double> t(made_.size(), -7);
    std::vector<std::uint8_t> is_hit(made_.size(), 7);
    AllHits all;
    all.t = {-7};
    expect_refused(code, words, [&] { caster_.first_hits(rays, {.t = t}, scratch_); });
    expect_refused(code, words, [&] { caster_.first_hits(rays, {.t = t}, context_); });
    expect_refused(code, words, [&] { caster_.any_hits(rays, is_hit, scratch_); });
    expect_refused(code, words, [&] { caster_.any_hits(rays, is_hit, context_); });
    expect_refused(code, words, [&] { caster_.all_hits(rays, all, scratch_); });
    expect_refused(code, words, [&] { caster_.all_hits(rays, all, context_); });
    expect_refused(code, words, [&] { sampler_.largest_values(rays, {.t = t}, scratch_); });
    expect_refused(code, words, [&] { sampler_.largest_values(rays, {.t = t}, context_); });
    EXPECT_EQ(t, std::vector<double>(made_.size(), -7));
    EXPECT_EQ(is_hit, std::vector<std::uint8_t>(made_.size(), 7));
    EXPECT_EQ(all.t, std::vector<double>{-7});
  }

  Dataset grid_ = gyroid_grid();
  MadeRays made_ = random_rays(grid_.bounds(), 20);
  RayCaster caster_{grid_, Isosurface{0}, Accuracy::float64};
  FieldSampler sampler_{grid_};
  RenderContext context_;
  RayScratch scratch_;
};

TEST_F(BadRays, of_wrong_shapes) {
  const std::span<const double> numbers(made_.origins);
  const auto with = [&](const std::function<void(Rays&)>& spoil) {
    Rays rays = made_.rays();
    spoil(rays);
    return rays;
  };
  refuse("Rays::origins: not given", with([](Rays& rays) { rays.origins = {}; }));
  refuse("Rays::directions: not given", with([](Rays& rays) { rays.directions = {}; }));
  refuse("Rays::origins: an array of the shape [60]; expected [n, 3]",
         with([&](Rays& rays) { rays.origins = numbers; }));
  refuse("Rays::origins: an array of the shape [3, 20]; expected [n, 3]", with([&](Rays& rays) {
           rays.origins = {numbers, {3, 20}};
         }));
  refuse("Rays::directions: an array of the shape [19, 3]; expected [20, 3]", with([&](Rays& rays) {
           rays.directions = {numbers.first(57), {19, 3}};
         }));
  refuse("Rays::t_min: an array of the shape [19]; expected [20]",
         with([&](Rays& rays) { rays.t_min = numbers.first(19); }));
  refuse("Rays::t_max: an array of the shape [20, 1]; expected [20]", with([&](Rays& rays) {
           rays.t_max = {numbers.first(20), {20, 1}};
         }));
  const std::vector<std::int64_t> whole(60, 1);
  refuse("Rays::origins: elements of the type I64; expected F32 or F64", with([&](Rays& rays) {
           rays.origins = {std::span<const std::int64_t>(whole), {20, 3}};
         }));
}

TEST_F(BadRays, that_are_not_finite_or_have_no_direction) {
  const std::vector<double> good_origins = made_.origins, good_directions = made_.directions;
  for (const double bad : {nan, infinite, -infinite}) {
    made_.origins[3 * 17 + 1] = bad;
    refuse("Rays::origins[17]: (", made_.rays());
    made_.origins = good_origins;
    made_.directions[3 * 4 + 2] = bad;
    refuse("Rays::directions[4]: (", made_.rays());
    made_.directions = good_directions;
  }
  for (const double zero : {0.0, -0.0}) {
    std::fill_n(made_.directions.begin() + 57, 3, zero);
    refuse("Rays::directions[19]: (", made_.rays());
  }
  made_.directions = good_directions;
  std::vector<double> limits(20, 1);
  limits[11] = nan;
  Rays rays = made_.rays();
  rays.t_min = std::span<const double>(limits);
  refuse("Rays::t_min[11]: NaN; expected a number", rays);
  rays = made_.rays();
  rays.t_max = std::span<const double>(limits);
  refuse("Rays::t_max[11]: NaN; expected a number", rays);
}

/// Kernels would miss hits beyond these limits. Within them first_hits_test.cpp finds all.
TEST_F(BadRays, that_are_out_of_range) {
  const std::vector<double> good_origins = made_.origins, good_directions = made_.directions;
  for (const double far : {1e151, -1e290, std::numeric_limits<double>::max()}) {
    made_.origins[3 * 17 + 1] = far;
    refuse("is too far from the data; expected at most 1e+150 cells", made_.rays());
    made_.origins = good_origins;
  }
  for (const double length : {5e-324, 1e-295, 1e-112, 1e112, 1e300}) {
    std::fill_n(made_.directions.begin() + 57, 3, length);
    refuse("expected a length between 1e-110 and 1e+110 cells", made_.rays());
  }
  made_.directions = good_directions;
}

TEST_F(BadRays, with_too_little_room_for_answers) {
  std::vector<double> numbers(60);
  std::vector<std::uint64_t> cells(21);
  const std::span<double> all(numbers);
  const auto refuse_hits = [&](const std::string& words, const Hits& hits) {
    expect_refused(ErrorCode::usage, words, [&] { caster_.first_hits(made_.rays(), hits, scratch_); });
    expect_refused(ErrorCode::usage, words, [&] { caster_.first_hits(made_.rays(), hits, context_); });
    expect_refused(ErrorCode::usage, words, [&] { sampler_.largest_values(made_.rays(), hits, scratch_); });
  };
  refuse_hits("Hits::t: 19 elements; expected 20 for 20 rays, or none", {.t = all.first(19)});
  refuse_hits("Hits::value: 60 elements; expected 20", {.value = all});
  refuse_hits("Hits::gradient: 20 elements; expected 60 for 20 rays", {.gradient = all.first(20)});
  refuse_hits("Hits::cell: 21 elements; expected 20", {.cell = cells});
  refuse_hits("Hits::error: 1 elements; expected 20", {.error = all.first(1)});
  refuse_hits("Hits::error: the method proves no errors; expected certified or exact", {.error = all.first(20)});
  std::vector<std::uint8_t> flags(21);
  expect_refused(ErrorCode::usage, "RayCaster::any_hits: room for 21 answers; expected 20",
                 [&] { caster_.any_hits(made_.rays(), flags, scratch_); });
  AllHits hits;
  expect_refused(ErrorCode::usage, "RayCaster::all_hits: max_hits is 0; expected at least 1",
                 [&] { caster_.all_hits(made_.rays(), hits, scratch_, 0); });
}

TEST_F(BadRays, through_data_that_do_not_answer_them) {
  expect_refused(ErrorCode::usage, "isovalue", [&] { RayCaster(grid_, Isosurface{}, Accuracy::float64); });
  expect_refused(ErrorCode::usage, "isovalue", [&] { RayCaster(grid_, Isosurface{infinite}, Accuracy::certified); });
  expect_refused(ErrorCode::usage, "no field 'x'; it has gyroid",
                 [&] { RayCaster(grid_, Isosurface{0}, Accuracy::float64, "x"); });
  expect_refused(ErrorCode::usage, "no field 'x'; it has gyroid", [&] { FieldSampler(grid_, "x"); });
  expect_refused(ErrorCode::usage, "holds no triangles; expected an Isosurface",
                 [&] { RayCaster(grid_, Triangles{}, Accuracy::float64); });
  const Dataset surface = octahedron();
  expect_refused(ErrorCode::usage, "holds triangles; expected Triangles",
                 [&] { RayCaster(surface, Isosurface{0}, Accuracy::float64); });
  for (const Method& method : {Method(Accuracy::preview), Method(Accuracy::certified), Method(Accuracy::exact),
                               Method::paper(), Method::sampled(1)})
    expect_refused(ErrorCode::unsupported, "triangles are traced only at float32 and float64",
                   [&] { RayCaster(surface, Triangles{}, method); });
  expect_refused(ErrorCode::unsupported, "a surface has no values in space", [&] { FieldSampler{surface}; });
  const Dataset mesh = ball_mesh();
  expect_refused(ErrorCode::usage, "part", [&] { RayCaster(mesh, Isosurface{1}, Accuracy::float64, "part"); });
  expect_refused(ErrorCode::usage, "part", [&] { FieldSampler(mesh, "part"); });
}

TEST_F(BadRays, and_points) {
  std::vector<double> points(6, 1), values(2, -7);
  std::vector<std::uint64_t> cells(1);
  const std::span<const double> numbers(points);
  const auto refuse_points = [&](const std::string& words, const ArrayView& view, std::size_t room = 2,
                                 std::size_t cell_room = 0) {
    expect_refused(ErrorCode::usage, words,
                   [&] { sampler_.at(view, std::span(values).first(room), std::span(cells).first(cell_room)); });
  };
  refuse_points("points: not given", {});
  refuse_points("points: an array of the shape [6]; expected [n, 3]", numbers);
  refuse_points("values: room for 1 numbers; expected 2", {numbers, {2, 3}}, 1);
  refuse_points("cells: room for 1 numbers; expected 2, or none", {numbers, {2, 3}}, 2, 1);
  for (const double bad : {nan, infinite}) {
    points[4] = bad;
    refuse_points("points[1]: (1, ", {numbers, {2, 3}});
  }
  EXPECT_EQ(values, std::vector<double>(2, -7));
}

}  // namespace
}  // namespace rhoray::tests
