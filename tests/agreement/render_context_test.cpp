#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "tests/agreement/pictures.h"
#include "tests/support/memory_file.h"

// A frame with a RenderContext is the same, bit for bit, as one without. This holds whatever
// volumes earlier frames showed, wherever these lay in memory, and whether or not they still exist.
namespace rhoray::tests {

namespace {

struct Scenes {
  std::string name;
  render::Scene scene;
};

/// Every kind of frame for which something is kept from one frame to the next.
std::vector<Scenes> scenes_of(const render::Dataset& volume, double isovalue) {
  std::vector<Scenes> scenes(5);
  for (Scenes& of : scenes) {
    of.scene = oblique_scene(volume, isovalue);
    of.scene.layers[0].method = render::default_method(volume, render::Mode::isosurface);
  }
  scenes[0].name = "isosurface";
  scenes[1].name = "largest values";
  scenes[1].scene.layers[0].mode = render::Mode::mip;
  scenes[1].scene.layers[0].method = {};
  scenes[2].name = "certified isosurface";
  scenes[2].scene.layers[0].method = render::method_of(render::Accuracy::certified);
  scenes[3].name = "shadows";
  scenes[3].scene.lights = {{.kind = render::Light::Kind::directional, .place = {1, 0.4, 0.3}, .casts_shadows = true},
                            {.kind = render::Light::Kind::point, .place = {-3, 2, 5}, .casts_shadows = true}};
  scenes[4].name = "clear surfaces";
  scenes[4].scene.layers[0].material.opacity = 0.5;
  scenes[4].scene.layers.push_back(scenes[4].scene.layers[0]);
  scenes[4].scene.layers[1].isovalue = 1.1 * isovalue;
  return scenes;
}

constexpr render::FrameOptions options{.width = 160, .height = 120, .channels = all_channels, .threads = 1};

void expect_memory_changes_nothing(const render::Dataset& volume, double isovalue, render::RenderContext& memory,
                                   const std::string& where) {
  // Each scene is rendered twice: a mesh's shadow data are known from the second frame on.
  for (int frame = 0; frame < 2; ++frame)
    for (const Scenes& of : scenes_of(volume, isovalue)) {
      SCOPED_TRACE(where + ", " + of.name);
      render::Framebuffer expected, found;
      render::render(volume, of.scene, options, expected);
      render::render(volume, of.scene, options, found, memory);
      EXPECT_GT(hit_count(expected), 1000U) << "shows too little";
      expect_same_bits(expected, found);
    }
}

/// Two fields with the same values at different positions: the descriptions of files with them do
/// not differ.
double lopsided(const Vec3& p) {
  return 4 + 2 * p.x - p.y * p.z + p.x * p.x * p.y;
}
double mirrored(const Vec3& p) {
  return lopsided({1 - p.x, p.y, p.z});
}
constexpr double shown = 4.75;

std::string packed_bytes(const preprocess::NeutralMesh& mesh, const preprocess::PackMeshOptions& packing = {}) {
  const TemporaryFolder folder;
  preprocess::pack_mesh(mesh, folder / "mesh.rho", packing);
  return read_file(folder / "mesh.rho");
}
std::string packed_bytes(const preprocess::NeutralVolume& volume) {
  const TemporaryFolder folder;
  preprocess::pack_volume(volume, folder / "grid.rho");
  return read_file(folder / "grid.rho");
}

struct Pair {
  std::string name, first, second;
};

/// Packed files that can replace each other in memory.
std::vector<Pair> pairs() {
  const BoxMesh box{.cells = {8, 8, 8}};
  const preprocess::NeutralMesh first = box_mesh(box, lopsided), second = box_mesh(box, mirrored);
  const preprocess::NeutralMesh first_single = box_mesh(box, lopsided, true),
                                second_single = box_mesh(box, mirrored, true);
  const preprocess::PackMeshOptions lists{.structure = preprocess::MeshStructure::leaves};
  const Index3 count(17, 17, 17);
  const Affine lattice = lattice_over({{0, 0, 0}, {1, 1, 1}}, count);
  return {{"mesh", packed_bytes(first), packed_bytes(second)},
          {"mesh in single precision", packed_bytes(first_single), packed_bytes(second_single)},
          {"mesh with lists", packed_bytes(first, lists), packed_bytes(second, lists)},
          {"grid", packed_bytes(sampled_volume<float>(count, lattice, lopsided)),
           packed_bytes(sampled_volume<float>(count, lattice, mirrored))}};
}

}  // namespace

// A second mesh, mapped where the first one had been, was drawn with the first one's values:
// prepared clusters were identified by the address of the values. Here the first file's bytes are
// replaced in its own mapping, so all addresses in the file are certainly the same.
TEST(RenderContext, does_not_take_a_volume_for_another_that_lies_at_the_same_address) {
  for (const Pair& pair : pairs()) {
    ASSERT_EQ(pair.first.size(), pair.second.size()) << pair.name;
    ASSERT_NE(pair.first, pair.second) << pair.name;
    const MemoryFile bytes(pair.first);
    const auto file = formats::PackedFile::from_descriptor(bytes.descriptor(), pair.name);
    render::RenderContext memory;
    const char* const names[] = {"the first", "the second in its place", "the first again"};
    for (const std::size_t at : {0U, 1U, 2U}) {
      bytes.put(0, at == 1 ? pair.second : pair.first);
      const render::Dataset volume = render::Dataset::load(file);
      expect_memory_changes_nothing(volume, shown, memory, pair.name + ", " + names[at]);
    }
  }
}

// Objects kept for a volume are destroyed with it, and others are created in their place on the
// heap.
TEST(RenderContext, does_not_take_a_volume_for_one_that_is_gone) {
  for (const Pair& pair : pairs()) {
    render::RenderContext memory;
    std::optional<MemoryFile> bytes;
    for (int round = 0; round < 6; ++round) {
      bytes.emplace(round % 2 == 0 ? pair.first : pair.second);
      const auto volume = render::Dataset::load(formats::PackedFile::from_descriptor(bytes->descriptor(), pair.name));
      expect_memory_changes_nothing(volume, shown, memory, pair.name + ", round " + std::to_string(round));
    }
  }
}

// The fields of one mesh share its points and clusters.
TEST(RenderContext, does_not_take_a_field_for_another_of_the_same_mesh) {
  preprocess::NeutralMesh mesh = box_mesh({.cells = {8, 8, 8}}, lopsided);
  add_point_field(mesh, "mirrored", mirrored);
  const TemporaryFolder folder;
  preprocess::pack_mesh(mesh, folder / "mesh.rho");
  const auto file = formats::PackedFile::open(folder / "mesh.rho");
  render::RenderContext memory;
  for (const char* field : {"value", "mirrored", "value"})
    expect_memory_changes_nothing(render::Dataset::load(file, field), shown, memory, field);
}

}  // namespace rhoray::tests
