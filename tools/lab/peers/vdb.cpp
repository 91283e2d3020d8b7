#include "tools/lab/peers/vdb.h"

#include <nanovdb/util/Ray.h>
// HDDA.h requires Ray.h.
#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetRebuild.h>
#include <openvdb/tools/RayIntersector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tools/lab/peers/pixel_rays.h"
#include "tools/lab/plain_grid.h"

namespace rhoray::study {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

using Leaf = openvdb::FloatTree::LeafNodeType;
constexpr std::int64_t leaf_edge = Leaf::DIM;

/// Whether the surface can pass between two samples of the leaf at `first`, or between one of them
/// and a neighbour.
template <class T>
bool is_crossed(const T* samples, const Index3& n, const Index3& first, double isovalue) {
  bool is_any_inside = false, is_any_outside = false;
  const auto begin = [&](int axis) { return std::max<std::int64_t>(first[axis] - 1, 0); };
  const auto end = [&](int axis) { return std::min(first[axis] + leaf_edge + 1, n[axis]); };
  for (std::int64_t k = begin(2); k < end(2); ++k)
    for (std::int64_t j = begin(1); j < end(1); ++j)
      for (std::int64_t i = begin(0); i < end(0); ++i) {
        const bool is_inside = static_cast<double>(samples[(k * n.y + j) * n.x + i]) >= isovalue;
        is_any_inside |= is_inside;
        is_any_outside |= !is_inside;
      }
  return is_any_inside && is_any_outside;
}

/// isovalue - value, negative inside, in the frame of sample positions; voxels with samples are
/// active.
/// @param only_crossed  leaves without the surface become tiles that are not active
openvdb::FloatGrid::Ptr vdb_grid(const preprocess::NeutralVolume& grid, double isovalue, bool only_crossed) {
  openvdb::initialize();
  constexpr float outside = 1;
  auto out = openvdb::FloatGrid::create(outside);
  const Index3 n = grid.sample_count;
  formats::with_element_type(grid.type, [&]<class T>(T) {
    const T* const samples = reinterpret_cast<const T*>(grid.samples.data());
    const auto difference = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      return static_cast<float>(isovalue - static_cast<double>(samples[(k * n.y + j) * n.x + i]));
    };
    Index3 first;
    for (first.z = 0; first.z < n.z; first.z += leaf_edge)
      for (first.y = 0; first.y < n.y; first.y += leaf_edge)
        for (first.x = 0; first.x < n.x; first.x += leaf_edge) {
          const openvdb::Coord origin(static_cast<int>(first.x), static_cast<int>(first.y), static_cast<int>(first.z));
          if (only_crossed && !is_crossed(samples, n, first, isovalue)) {
            const bool is_inside = difference(first.x, first.y, first.z) <= 0;
            out->tree().addTile(1, origin, is_inside ? -outside : outside, false);
            continue;
          }
          auto leaf = std::make_unique<Leaf>(origin, outside, false);
          for (openvdb::Index s = 0; s < Leaf::SIZE; ++s) {
            const openvdb::Coord at = leaf->offsetToGlobalCoord(s);
            if (at.x() < n.x && at.y() < n.y && at.z() < n.z) leaf->setValueOn(s, difference(at.x(), at.y(), at.z()));
          }
          out->tree().addLeaf(leaf.release());
        }
  });
  return out;
}

Vec3 frame_per_world(const preprocess::NeutralVolume& grid) {
  return Vec3(1) / spacing_of(grid);
}

class NanoVdbPeer final : public Peer {
 public:
  explicit NanoVdbPeer(bool only_crossed) : only_crossed_(only_crossed) {}

  std::string name() const override { return only_crossed_ ? "NanoVDB, narrow" : "NanoVDB, dense"; }
  std::string does() const override {
    return only_crossed_ ? "ZeroCrossing (nearest voxel), only leaves with the surface"
                         : "ZeroCrossing (nearest voxel), every voxel active";
  }

  Preparation prepare(const PeerData& data, double isovalue) override {
    grid_ = {};
    stretch_ = frame_per_world(*data.grid);
    Preparation preparation;
    preparation.build_ms = cpu_ms_of([&] {
      const auto source = vdb_grid(*data.grid, isovalue, only_crossed_);
      has_voxels_ = !source->empty();
      grid_ = nanovdb::openToNanoVDB(*source, nanovdb::StatsMode::BBox, nanovdb::ChecksumMode::Disable);
    });
    return preparation;
  }

  std::optional<double> prepared_mb() const override { return static_cast<double>(grid_.size()) / 1e6; }

  void draw(const PeerView& view) override {
    using Ray = nanovdb::Ray<float>;
    color_.resize(4 * view.pixel_count());
    distance_.assign(view.pixel_count(), std::numeric_limits<float>::infinity());
    const PixelRays<float> rays(view.camera, view.width, view.height, stretch_);
    const auto from = rays.origin();
    // Half a voxel further, so that rounding a position down gives the nearest voxel.
    const nanovdb::Vec3f origin(from.x + 0.5F, from.y + 0.5F, from.z + 0.5F);
    const auto* const grid = grid_.grid<float>();
    auto accessor = grid->getAccessor();
    std::size_t pixel = 0;
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x, ++pixel) {
        const auto through = rays.through(x, y);
        nanovdb::Vec3f direction(through.x, through.y, through.z);
        const float length = direction.length();
        direction *= 1 / length;
        Ray ray(origin, direction, 0, 1e9F);
        nanovdb::Coord voxel;
        float value = 0, time = 0;
        if (!has_voxels_ || !nanovdb::ZeroCrossing(ray, accessor, voxel, value, time)) {
          light_background(&color_[4 * pixel]);
          continue;
        }
        distance_[pixel] = time / length;
        light_pixel(&color_[4 * pixel], gradient(accessor, voxel).normalize().dot(direction));
      }
  }

  std::vector<double> answers(const PeerView& view) override {
    draw(view);
    return {distance_.begin(), distance_.end()};
  }

 private:
  /// Central differences between the six neighbours.
  template <class Accessor>
  static nanovdb::Vec3f gradient(Accessor& accessor, const nanovdb::Coord& at) {
    const auto difference = [&](int i, int j, int k) {
      return accessor.getValue(at.offsetBy(i, j, k)) - accessor.getValue(at.offsetBy(-i, -j, -k));
    };
    return {difference(1, 0, 0), difference(0, 1, 0), difference(0, 0, 1)};
  }

  bool only_crossed_, has_voxels_ = false;
  Vec3 stretch_{1, 1, 1};
  nanovdb::GridHandle<nanovdb::HostBuffer> grid_;
  std::vector<float> color_, distance_;
};

class LevelSetPeer final : public Peer {
 public:
  std::string name() const override { return "OpenVDB, level set"; }
  std::string does() const override { return "LevelSetRayIntersector on what levelSetRebuild makes, 3 voxels wide"; }

  Preparation prepare(const PeerData& data, double isovalue) override {
    grid_ = nullptr;
    stretch_ = frame_per_world(*data.grid);
    Preparation preparation;
    openvdb::FloatGrid::Ptr source;
    preparation.once_ms = cpu_ms_of([&] { source = vdb_grid(*data.grid, isovalue, false); });
    preparation.build_ms = cpu_ms_of([&] {
      constexpr float half_width = 3;
      grid_ = openvdb::tools::levelSetRebuild(*source, 0.0F, half_width);
      grid_->setGridClass(openvdb::GRID_LEVEL_SET);
    });
    return preparation;
  }

  std::optional<double> prepared_mb() const override { return static_cast<double>(grid_->memUsage()) / 1e6; }

  void draw(const PeerView& view) override {
    using Ray = openvdb::math::Ray<double>;
    color_.resize(4 * view.pixel_count());
    distance_.assign(view.pixel_count(), infinity);
    const PixelRays<double> rays(view.camera, view.width, view.height, stretch_);
    const auto from = rays.origin();
    const openvdb::Vec3d origin(from.x, from.y, from.z);
    const bool has_voxels = !grid_->empty();
    std::optional<openvdb::tools::LevelSetRayIntersector<openvdb::FloatGrid>> intersector;
    if (has_voxels) intersector.emplace(*grid_);
    std::size_t pixel = 0;
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x, ++pixel) {
        const auto through = rays.through(x, y);
        openvdb::Vec3d direction(through.x, through.y, through.z), place, normal;
        const double length = direction.length();
        direction *= 1 / length;
        double time = 0;
        if (!has_voxels || !intersector->intersectsWS(Ray(origin, direction), place, normal, time)) {
          light_background(&color_[4 * pixel]);
          continue;
        }
        distance_[pixel] = time / length;
        light_pixel(&color_[4 * pixel], static_cast<float>(normal.dot(direction)));
      }
  }

  std::vector<double> answers(const PeerView& view) override {
    draw(view);
    return distance_;
  }

 private:
  Vec3 stretch_{1, 1, 1};
  openvdb::FloatGrid::Ptr grid_;
  std::vector<float> color_;
  std::vector<double> distance_;
};

}  // namespace

PeerPointer nanovdb_dense() {
  return std::make_unique<NanoVdbPeer>(false);
}

PeerPointer nanovdb_narrow() {
  return std::make_unique<NanoVdbPeer>(true);
}

PeerPointer openvdb_level_set() {
  return std::make_unique<LevelSetPeer>();
}

}  // namespace rhoray::study
