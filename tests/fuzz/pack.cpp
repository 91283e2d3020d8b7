// Packs arbitrary numbers. The first byte of an input chooses what is packed and how; the other
// bytes are the numbers, repeated as often as needed. Every packed file must be proven sound. After
// a refusal, or when memory runs out, the old file and no other must be left.
#include <cstring>
#include <filesystem>
#include <iterator>
#include <new>
#include <string>
#include <variant>
#include <vector>

#include "formats/base/checks.h"
#include "formats/base/parallel.h"
#include "formats/brick_grid.h"
#include "formats/tet_mesh.h"
#include "formats/triangle_mesh.h"
#include "preprocess/pack_mesh.h"
#include "preprocess/pack_surface.h"
#include "preprocess/pack_volume.h"
#include "preprocess/resample.h"
#include "tests/fuzz/harness.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace rhoray;
using namespace rhoray::preprocess;
using Path = std::filesystem::path;

/// The bytes of an input, repeated cyclically.
class Numbers {
 public:
  Numbers(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  template <class T>
  T next() {
    std::byte bytes[sizeof(T)];
    for (std::byte& byte : bytes) {
      byte = size_ == 0 ? std::byte{0} : static_cast<std::byte>(data_[at_ % size_]);
      ++at_;
    }
    T number;
    std::memcpy(&number, bytes, sizeof number);
    return number;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

NeutralVolume volume_of(Numbers& numbers, formats::ElementType type) {
  NeutralVolume volume;
  volume.sample_count = {9, 6, 7};
  volume.type = type;
  volume.field_name = "value";
  volume.owned_samples.resize(9 * 6 * 7 * formats::element_bytes(type));
  for (std::byte& byte : volume.owned_samples) byte = numbers.next<std::byte>();
  volume.samples = volume.owned_samples;
  return volume;
}

/// Values are any numbers. Points are moved by up to a cube's edge, or are any numbers, too.
NeutralMesh mesh_of(Numbers& numbers, bool any_points) {
  NeutralMesh mesh = tests::box_mesh({.cells = {3, 2, 2}, .box = Box3({0, 0, 0}, {3, 2, 2})});
  for (auto& point : mesh.points)
    for (double& x : point) x = any_points ? numbers.next<double>() : x + numbers.next<std::int8_t>() / 128.0;
  NeutralField field;
  field.name = "value";
  for (std::size_t p = 0; p < mesh.points.size(); ++p) field.values.push_back(numbers.next<float>());
  mesh.point_fields.push_back(std::move(field));
  return mesh;
}

NeutralSurface surface_of(Numbers& numbers) {
  NeutralSurface surface;
  constexpr std::uint64_t points = 12, facets = 20;
  for (std::uint64_t p = 0; p < points; ++p)
    surface.points.push_back({numbers.next<float>(), numbers.next<float>(), numbers.next<float>()});
  for (std::uint64_t f = 0; f < facets; ++f) {
    for (std::uint64_t corner = 0; corner < 3 + f % 3; ++corner)
      surface.facet_corners.push_back(numbers.next<std::uint8_t>() % points);
    surface.facet_offsets.push_back(surface.facet_corners.size());
  }
  return surface;
}

constexpr unsigned kinds = 8;

void pack(unsigned kind, Numbers& numbers, const Path& path) {
  using formats::ElementType;
  switch (kind) {
    case 0:
      pack_volume(volume_of(numbers, ElementType::U8), path, {.replace_existing = true});
      return;
    case 1:
      pack_volume(volume_of(numbers, ElementType::F32), path,
                  {.order = SampleOrder::sparse, .brick_edge = 4, .replace_existing = true});
      return;
    case 2:
      pack_volume(volume_of(numbers, ElementType::F64), path, {.macro_factor = 2, .replace_existing = true});
      return;
    case 3:
    case 4:
      pack_mesh(mesh_of(numbers, kind == 4), path, {.cluster_size = 8, .replace_existing = true});
      return;
    case 5:
      pack_mesh(mesh_of(numbers, false), path, {.structure = MeshStructure::leaves, .replace_existing = true});
      return;
    case 6:
      pack_surface(surface_of(numbers), path, {.replace_existing = true});
      return;
    default:
      resample(mesh_of(numbers, false), path, {.lattice = {.longest_axis = 9}, .replace_existing = true});
      return;
  }
}

void check_sound(const Path& path) {
  const formats::PackedFile file = formats::PackedFile::open(path);
  RHORAY_CHECK(file.damaged_blocks(1).empty());
  const std::string& kind = file.description().kind;
  std::vector<std::string> findings;
  if (kind == "grid")
    findings = deep_findings(formats::BrickGrid(file));
  else if (kind == "tets")
    findings = deep_findings(formats::TetMesh(file));
  else
    findings = deep_findings(formats::TriangleMesh(file));
  for (const std::string& finding : findings) std::fprintf(stderr, "%s\n", finding.c_str());
  RHORAY_CHECK(findings.empty());
}

constexpr const char* old_content = "an old file";

void check_untouched(const Path& path) {
  RHORAY_CHECK(tests::read_file(path) == old_content);
  RHORAY_CHECK(std::distance(std::filesystem::directory_iterator(path.parent_path()), {}) == 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tests::TemporaryFolder folder;
  static const Path path = folder / "packed.rho";
  if (size == 0) return 0;
  const ThreadLimit one(1);
  tests::write_file(path, old_content);
  Numbers numbers(data + 1, size - 1);
  try {
    pack(data[0] % kinds, numbers, path);
  } catch (const Error& error) {
    tests::check_refusal(error);
    check_untouched(path);
    return 0;
  } catch (const std::bad_alloc&) {
    check_untouched(path);
    throw;
  }
  check_sound(path);
  return 0;
}
