// Pictures do not depend on the number of threads, on memory that frames share, on the part that is
// asked for, or on where a packed file lies.
#include <algorithm>
#include <array>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "formats/base/text.h"
#include "formats/packed_file.h"
#include "tests/agreement/pictures.h"
#include "tests/support/memory_file.h"
#include "tests/support/temporary_folder.h"

namespace rhoray::tests {

namespace {

constexpr int width = 131, height = 97;

struct Data {
  std::string name;
  render::Dataset mapped, read;  ///< the same file, mapped and in memory
  double isovalue;
};

struct Asked {
  std::string name;
  render::Scene scene;
  int antialiasing = 1;
};

template <class Source>
Data data_of(const TemporaryFolder& folder, const std::string& name, const Source& source, double isovalue) {
  render::Dataset mapped = packed(folder, name, source);
  const MemoryFile memory(read_file(folder / name));
  return {name, std::move(mapped),
          render::Dataset::load(formats::PackedFile::from_descriptor(memory.descriptor(), name)), isovalue};
}

/// Six scenes: methods with and without proofs, MIP, transparent surfaces, and shadows with
/// occlusion and antialiasing.
std::vector<Asked> scenes_of(const Data& data) {
  using enum render::Accuracy;
  const render::Scene plain = oblique_scene(data.mapped, data.isovalue);
  std::vector<Asked> all;
  const auto add = [&](const std::string& name, const render::Method& method, const auto& change) -> Asked& {
    Asked& asked = all.emplace_back(Asked{concat(data.name, ", ", name), plain});
    asked.scene.layers[0].method = method;
    change(asked.scene);
    return asked;
  };
  const auto as_it_is = [](render::Scene&) {};
  add("float", render::method_of(float32), as_it_is);
  add("double", render::method_of(float64), as_it_is);
  add("certified", render::method_of(certified), as_it_is);
  add("MIP", render::method_of(float64), [](render::Scene& scene) { scene.layers[0].mode = render::Mode::mip; });
  add("transparent", render::method_of(float32), [&](render::Scene& scene) {
    scene.layers[0].material.opacity = 0.4;
    scene.layers.push_back(scene.layers[0]);
    scene.layers[1].isovalue = 1.2 * data.isovalue;
  });
  add("effects", render::method_of(float32), [](render::Scene& scene) {
    scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, 0.4, 0.3}, .casts_shadows = true}};
    scene.occlusion.radius = 5, scene.occlusion.samples = 4;
  }).antialiasing = 4;
  return all;
}

void expect_same_counts(const render::FrameStatistics& a, const render::FrameStatistics& b) {
  EXPECT_EQ(a.rays, b.rays);
  EXPECT_EQ(a.hits, b.hits);
  EXPECT_EQ(a.shadow_rays, b.shadow_rays);
  EXPECT_EQ(a.occlusion_rays, b.occlusion_rays);
  EXPECT_EQ(a.rays_through, b.rays_through);
  EXPECT_EQ(a.macrocells_visited, b.macrocells_visited);
  EXPECT_EQ(a.cells_visited, b.cells_visited);
  EXPECT_EQ(a.cells_solved, b.cells_solved);
}

/// Copies the colours of a part of a picture.
std::vector<float> colors_in(const render::Framebuffer& picture, const render::PixelRect& part) {
  const auto row = static_cast<std::ptrdiff_t>(picture.color.size() / height), pixel = row / width;
  std::vector<float> colors;
  for (int y = part.y; y < part.y + part.height; ++y) {
    const auto first = picture.color.begin() + y * row + part.x * pixel;
    colors.insert(colors.end(), first, first + part.width * pixel);
  }
  return colors;
}

}  // namespace

TEST(Threads, repeats_parts_and_places_of_a_file_give_the_same_twelve_pictures_and_counts) {
  const TemporaryFolder folder;
  std::vector<Data> all;
  all.push_back(data_of(folder, "grid", noise_volume<std::int16_t>({40, 33, 50}, 20, 3), 15.5));
  all.push_back(data_of(folder, "mesh", box_mesh({.cells = {8, 8, 8}, .jitter = 0.1}, product_field()), 0.05));
  const std::array threads{1U, 2U, 3U, 4U, 8U, std::max(1U, std::thread::hardware_concurrency())};
  for (const Data& data : all)
    for (const Asked& asked : scenes_of(data)) {
      SCOPED_TRACE(asked.name);
      render::FrameOptions options{
          .width = width, .height = height, .channels = all_channels, .antialiasing = asked.antialiasing, .threads = 1};
      render::Framebuffer expected, found;
      const render::FrameStatistics one = render::render(data.mapped, asked.scene, options, expected);
      EXPECT_GT(one.hits, 1000U);
      render::RenderContext memory;
      for (int repeat = 0; repeat < 20; ++repeat) {
        options.threads = threads[static_cast<std::size_t>(repeat) % threads.size()];
        const render::Dataset& dataset = repeat % 4 < 2 ? data.mapped : data.read;
        const render::FrameStatistics again = repeat % 2 == 0
                                                  ? render::render(dataset, asked.scene, options, found)
                                                  : render::render(dataset, asked.scene, options, found, memory);
        expect_same_bits(expected, found);
        expect_same_counts(one, again);
      }
      for (const int edge : {8, 16, 32, 64}) {
        const render::PixelRect part{.x = 37, .y = 21, .width = edge, .height = edge};
        options.window = part;
        render::Framebuffer window;
        render::render(data.mapped, asked.scene, options, window);
        EXPECT_EQ(colors_in(expected, part), colors_in(window, part)) << edge;
      }
    }
}

}  // namespace rhoray::tests
