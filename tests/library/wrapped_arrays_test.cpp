// Datasets whose samples are in the caller's memory.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <memory>

#include "tests/library/expect_refused.h"
#include "tests/library/made_arrays.h"
#include "tests/library/pictures.h"

namespace rhoray::tests {
namespace {

constexpr Size size{48, 40};
constexpr ChannelSet channels{.depth = true, .normal = true, .cell = true, .value = true};

/// A copy of samples between pages that cannot be read: at the end of the pages between them, or at
/// their start.
class GuardedSamples {
 public:
  template <class T>
  GuardedSamples(const Samples<T>& samples, bool at_end) {
    const std::size_t page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)),
                      bytes = samples.values.size() * sizeof(T), inside = (bytes + page - 1) / page * page;
    byte_count_ = inside + 2 * page;
    pages_ = ::mmap(nullptr, byte_count_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages_ == MAP_FAILED) throw std::bad_alloc();
    std::byte* const first = static_cast<std::byte*>(pages_) + page;
    if (::mprotect(first, inside, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
    samples_ = first + (at_end ? inside - bytes : 0);
    std::memcpy(samples_, samples.values.data(), bytes);
  }
  ~GuardedSamples() { ::munmap(pages_, byte_count_); }
  GuardedSamples(const GuardedSamples&) = delete;
  GuardedSamples& operator=(const GuardedSamples&) = delete;

  template <class T>
  ArrayView view(const Samples<T>& samples) const {
    return {std::span(static_cast<const T*>(static_cast<const void*>(samples_)), samples.values.size()),
            {samples.nz, samples.ny, samples.nx}};
  }

 private:
  void* pages_;
  std::size_t byte_count_;
  std::byte* samples_;
};

/// Pictures of everything that reads samples, on every instruction set, without the channel `cost`:
/// kernels read bricks in other portions.
std::string pictures_of(const Dataset& data) {
  std::string bits;
  Scene scene{.layers = {{.data = data, .show = Isosurface{101.25}}}, .background = Vec3{0, 0, 0}};
  scene.camera = fit_camera(data.bounds(), size, {.azimuth_deg = 140, .elevation_deg = -35});
  for (const Machine machine : {Machine::scalar, Machine::baseline, Machine::avx2, Machine::avx512}) {
    if (!has_machine(machine)) continue;
    RenderContext context({.threads = 2, .machine = machine});
    Picture picture;
    const auto draw = [&] {
      context.render(scene, {.size = size, .channels = channels}, picture);
      bits += bits_of(picture);
    };
    Layer& layer = scene.layers[0];
    for (const Accuracy accuracy :
         {Accuracy::preview, Accuracy::float32, Accuracy::float64, Accuracy::certified, Accuracy::exact}) {
      layer = {.data = data, .show = Isosurface{101.25}, .method = accuracy};
      draw();
      layer.show = MaximumProjection{};
      if (accuracy == Accuracy::float64 || accuracy == Accuracy::certified) draw();
    }
    scene.lights = {{.kind = Light::Kind::point, .place = {40, -30, 50}, .casts_shadows = true}};
    scene.occlusion = {.samples = 2, .radius = 3};
    layer = {.data = data, .show = Isosurface{99}};
    draw();
    scene.layers.push_back({.data = data, .show = Isosurface{150}, .material = {.opacity = 0.5}});
    scene.layers.push_back({.data = data, .show = Isosurface{60}, .material = {.opacity = 0.3}});
    scene.layers.push_back({.data = data, .show = Slice{.plane = {.point = {3, 3, 3}, .normal = {1, 2, 3}}}});
    draw();
    scene.layers.erase(scene.layers.begin() + 1, scene.layers.end());
    scene.lights = {Light{}}, scene.occlusion = {};
  }
  return bits;
}

template <class T>
void expect_same_pictures(std::int64_t nx, std::int64_t ny, std::int64_t nz) {
  const Samples<T> samples = samples_of<T>(nx, ny, nz, [](auto i, auto j, auto k) {
    const double value =
        100 + 60 * gyroid(0.7 * static_cast<double>(i), 0.6 * static_cast<double>(j), 0.5 * static_cast<double>(k));
    return std::is_floating_point_v<T> && i == 1 && j == 1
               ? std::nan("")
               : std::clamp(value, 0.0, 127.0 + (sizeof(T) > 1 ? 60.0 : 0.0));
  });
  const std::string expected = pictures_of(pack({.fields = {samples.field("f")}}, AxisOrder::zyx));
  for (const bool at_end : {false, true}) {
    const GuardedSamples guarded(samples, at_end);
    const Dataset wrapped =
        pack({.fields = {{.name = "f", .values = guarded.view(samples)}}}, AxisOrder::zyx, {.memory = Memory::wrap});
    EXPECT_TRUE(pictures_of(wrapped) == expected)
        << nx << " x " << ny << " x " << nz << " of " << sizeof(T) << " bytes, " << at_end;
  }
}

TEST(WrappedArrays, give_the_bits_of_a_copy_and_are_read_nowhere_else) {
  expect_same_pictures<std::uint8_t>(21, 18, 13);
  expect_same_pictures<std::uint8_t>(4, 4, 8);  // squares and bricks of 4 follow each other
  expect_same_pictures<std::int8_t>(16, 12, 20);
  expect_same_pictures<std::uint16_t>(4, 16, 9);
  expect_same_pictures<std::int16_t>(13, 9, 10);
  expect_same_pictures<std::int32_t>(9, 13, 17);
  expect_same_pictures<float>(18, 17, 16);
  expect_same_pictures<double>(17, 5, 21);
  expect_same_pictures<float>(2, 2, 2);
}

TEST(WrappedArrays, are_not_copied) {
  const Samples<float> samples = gyroid_samples();
  const Samples<std::uint8_t> other = samples_of<std::uint8_t>(24, 20, 16, [](auto i, auto, auto) { return i; });
  GridArrays grid{.fields = {samples.field("gyroid"), other.field("other")}};
  for (int axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < 24 - 4 * axis; ++i)
      grid.positions[static_cast<std::size_t>(axis)].push_back(static_cast<double>(i * i + i));
  const Dataset wrapped = pack(grid, AxisOrder::zyx, {.memory = Memory::wrap});
  EXPECT_EQ(wrapped.array("samples").first(), samples.values.data());
  EXPECT_EQ(wrapped.array("field.1.samples").first(), other.values.data());
  EXPECT_EQ(wrapped.array("samples").shape().size(), 3U);
  EXPECT_EQ(wrapped.field("other").range->hi, 23);
  EXPECT_TRUE(wrapped.damaged_blocks().empty());
  const Dataset copied = pack(grid, AxisOrder::zyx);
  EXPECT_EQ(bits_of(rendered(certified_scene(wrapped, 0.1, size), {.size = size, .channels = channels})),
            bits_of(rendered(certified_scene(copied, 0.1, size), {.size = size, .channels = channels})));
  // Fortran's order: the first index is the fastest.
  const std::int64_t shape[] = {24, 20, 16}, strides[] = {4, 96, 1920};
  const ArrayView fortran(samples.values.data(), ElementType::F32, shape, strides);
  const Dataset first_fastest =
      pack({.fields = {{.name = "f", .values = fortran}}}, AxisOrder::xyz, {.memory = Memory::wrap});
  EXPECT_EQ(first_fastest.array("samples").first(), samples.values.data());
}

TEST(WrappedArrays, keep_their_owner_until_the_last_handle_goes) {
  auto samples = std::make_shared<Samples<float>>(gyroid_samples());
  const std::weak_ptr<Samples<float>> watched = samples;
  std::optional<Scene> scene;
  {
    const Dataset data =
        pack({.fields = {samples->field("f")}}, AxisOrder::zyx, {.memory = Memory::wrap, .owner = samples});
    samples.reset();
    scene = certified_scene(data, 0.1, size);
  }
  EXPECT_FALSE(watched.expired());
  EXPECT_GT(bits_of(rendered(*scene, {.size = size})).size(), 0U);
  scene.reset();
  EXPECT_TRUE(watched.expired());
}

TEST(WrappedArrays, are_refused_where_rays_cannot_read_them) {
  const Samples<float> samples = gyroid_samples();
  const auto expect_not_wrapped = [](const std::string& words, const ArrayView& values, AxisOrder order) {
    expect_refused(ErrorCode::usage, "GridArrays::fields[0].values: cannot be wrapped: " + words,
                   [&] { pack({.fields = {{.name = "f", .values = values}}}, order, {.memory = Memory::wrap}); });
  };
  expect_not_wrapped(
      "its strides along x, y and z are 1920, 96 and 4 bytes; expected 4, 64 and 1280: contiguous, x fastest",
      samples.view(), AxisOrder::xyz);
  const std::int64_t half[] = {16, 20, 12}, strides[] = {1920, 96, 8};
  expect_not_wrapped("its strides along x, y and z are 8, 96 and 1920 bytes; expected 4, 48 and 960",
                     ArrayView(samples.values.data(), ElementType::F32, half, strides), AxisOrder::zyx);
  const std::int64_t small[] = {4, 4, 4}, dense[] = {64, 16, 4};
  expect_not_wrapped(
      "its first sample is not at a multiple of 4 bytes",
      ArrayView(reinterpret_cast<const char*>(samples.values.data()) + 2, ElementType::F32, small, dense),
      AxisOrder::zyx);
  const Samples<std::int64_t> whole = samples_of<std::int64_t>(4, 4, 4, [](auto i, auto, auto) { return i; });
  expect_not_wrapped("its 64-bit integers have to be converted to doubles", whole.view(), AxisOrder::zyx);
  const Samples<float> other = samples_of<float>(24, 20, 16, [](auto i, auto, auto) { return i; });
  GridArrays mixed{.fields = {samples.field("f"), {.name = "g", .values = whole.view()}}};
  expect_refused(ErrorCode::usage, "GridArrays::fields[1].values",
                 [&] { pack(mixed, AxisOrder::zyx, {.memory = Memory::wrap}); });
  expect_refused(ErrorCode::usage, "PackOptions::file: found some.rho; expected none with Memory::wrap", [&] {
    pack({.fields = {samples.field("f")}}, AxisOrder::zyx, {.file = "some.rho", .memory = Memory::wrap});
  });
  const std::string grids_only = "only the samples of a grid can be wrapped; expected Memory::copy";
  expect_refused(ErrorCode::usage, grids_only, [] { ball_mesh(2, {.memory = Memory::wrap}); });
  expect_refused(ErrorCode::usage, grids_only, [] { octahedron({.memory = Memory::wrap}); });
  const PackOptions copied{.owner = std::make_shared<int>(0)};
  for (const auto& act : {+[](const PackOptions& options) { gyroid_grid(options); },
                          +[](const PackOptions& options) { ball_mesh(2, options); }})
    expect_refused(ErrorCode::usage, "PackOptions::owner: found one; expected none", [&] { act(copied); });
}

TEST(WrappedArrays, are_in_no_file) {
  const Samples<float> samples = gyroid_samples();
  const Dataset data = pack({.fields = {samples.field("f")}}, AxisOrder::zyx, {.memory = Memory::wrap});
  expect_refused(ErrorCode::usage, "save: the samples are wrapped, so they are in no file",
                 [&] { data.save("wrapped.rho"); });
  expect_refused(ErrorCode::usage, "path: the samples are wrapped, so they are in no file", [&] { data.path(); });
  expect_refused(ErrorCode::usage, "to_document: the samples are wrapped, so they are in no file",
                 [&] { to_document({.layers = {{.data = data, .show = Isosurface{0.1}}}}, {}); });
  EXPECT_FALSE(std::filesystem::exists("wrapped.rho"));
}

}  // namespace
}  // namespace rhoray::tests
