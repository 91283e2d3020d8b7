#include "tools/lab/peers/embree.h"

#include <cmath>
#include <limits>

#include "formats/base/error.h"
#include "tools/lab/peers/pixel_rays.h"

namespace rhoray::study {

namespace {

using Vec3f = Imath::V3f;

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Embree requires that numbers too small for the normal format count as zero while rays are
/// traced.
class TinyIsZero {
 public:
  TinyIsZero() : before_(__builtin_ia32_stmxcsr()) { __builtin_ia32_ldmxcsr(before_ | 0x8040); }
  TinyIsZero(const TinyIsZero&) = delete;
  TinyIsZero& operator=(const TinyIsZero&) = delete;
  ~TinyIsZero() { __builtin_ia32_ldmxcsr(before_); }

 private:
  unsigned before_;
};

/// Embree reports what it allocates and, as a negative number, what it frees.
bool count_bytes(void* total, ssize_t bytes, bool) {
  *static_cast<std::atomic<std::int64_t>*>(total) += bytes;
  return true;
}

void refuse(void*, RTCError, const char* reason) {
  throw Error(ErrorCode::internal, concat("Embree: ", reason));
}

}  // namespace

EmbreeScene::EmbreeScene()
    // With "simd512", packets of 16 use AVX-512 where the processor has it; the default stays at
    // AVX2.
    : device_(rtcNewDevice("threads=1,frequency_level=simd512")) {
  if (device_ == nullptr) throw Error(ErrorCode::internal, "Embree: no device");
  rtcSetDeviceErrorFunction(device_, refuse, nullptr);
  rtcSetDeviceMemoryMonitorFunction(device_, count_bytes, &bytes_);
}

EmbreeScene::~EmbreeScene() {
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

Preparation EmbreeScene::prepare(const PeerData& data, double isovalue) {
  if (isovalue_ == isovalue) return preparation_;
  const TinyIsZero tiny_is_zero;
  preparation_ = build(data, isovalue);
  isovalue_ = isovalue;
  return preparation_;
}

double EmbreeScene::memory_mb() const {
  return static_cast<double>(bytes_) / 1e6;
}

void EmbreeScene::start() {
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  scene_ = rtcNewScene(device_);
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
}

void EmbreeScene::finish(RTCGeometry geometry) {
  if (geometry != nullptr) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene_);
}

namespace {

class EmbreePeer : public Peer {
 public:
  explicit EmbreePeer(std::shared_ptr<EmbreeScene> scene) : scene_(std::move(scene)) {}

  Preparation prepare(const PeerData& data, double isovalue) override { return scene_->prepare(data, isovalue); }

  std::optional<double> prepared_mb() const override { return scene_->memory_mb(); }

  void draw(const PeerView& view) override {
    color_.resize(4 * view.pixel_count());
    distance_.resize(view.pixel_count());
    const TinyIsZero tiny_is_zero;
    trace(view, scene_->scene());
  }

  std::vector<double> answers(const PeerView& view) override {
    draw(view);
    return {distance_.begin(), distance_.end()};
  }

 protected:
  virtual void trace(const PeerView& view, RTCScene scene) = 0;

  /// The camera in the frame of the scene's positions.
  render::Camera moved(render::Camera camera) const {
    camera.position -= scene_->middle();
    camera.target -= scene_->middle();
    return camera;
  }

  /// @param normal  of the triangle, of any length
  void take(std::size_t pixel, float distance, const Vec3f& normal, const Vec3f& direction) {
    distance_[pixel] = distance;
    if (distance == infinity) return light_background(&color_[4 * pixel]);
    light_pixel(&color_[4 * pixel], normal.dot(direction) / normal.length());
  }

  std::shared_ptr<EmbreeScene> scene_;

 private:
  std::vector<float> color_, distance_;
};

class Packets final : public EmbreePeer {
 public:
  using EmbreePeer::EmbreePeer;
  std::string name() const override { return scene_->named("packets"); }
  std::string does() const override { return scene_->shows() + ", 16 coherent rays at a time"; }

 private:
  void trace(const PeerView& view, RTCScene scene) override {
    const PixelRays<float> rays(moved(view.camera), view.width, view.height);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (int y = 0; y < view.height; y += 4)
      for (int x = 0; x < view.width; x += 4) trace_block(view, rays, scene, context, x, y);
  }

  void trace_block(const PeerView& view, const PixelRays<float>& rays, RTCScene scene, RTCIntersectContext& context,
                   int left, int top) {
    alignas(64) RTCRayHit16 packet;
    alignas(64) int valid[16];
    const auto origin = rays.origin();
    for (int lane = 0; lane < 16; ++lane) {
      const int x = left + lane % 4, y = top + lane / 4;
      const auto direction = rays.through(x, y);
      valid[lane] = x < view.width && y < view.height ? -1 : 0;
      packet.ray.org_x[lane] = origin.x;
      packet.ray.org_y[lane] = origin.y;
      packet.ray.org_z[lane] = origin.z;
      packet.ray.dir_x[lane] = direction.x;
      packet.ray.dir_y[lane] = direction.y;
      packet.ray.dir_z[lane] = direction.z;
      packet.ray.tnear[lane] = 0;
      packet.ray.tfar[lane] = infinity;
      packet.ray.time[lane] = 0;
      packet.ray.mask[lane] = ~0U;
      packet.ray.flags[lane] = 0;
      packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(valid, scene, &context, &packet);
    for (int lane = 0; lane < 16; ++lane) {
      if (valid[lane] == 0) continue;
      const std::size_t pixel = static_cast<std::size_t>(top + lane / 4) * static_cast<std::size_t>(view.width) +
                                static_cast<std::size_t>(left + lane % 4);
      const bool is_hit = packet.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
      take(pixel, is_hit ? packet.ray.tfar[lane] : infinity,
           {packet.hit.Ng_x[lane], packet.hit.Ng_y[lane], packet.hit.Ng_z[lane]},
           {packet.ray.dir_x[lane], packet.ray.dir_y[lane], packet.ray.dir_z[lane]});
    }
  }
};

class SingleRays final : public EmbreePeer {
 public:
  using EmbreePeer::EmbreePeer;
  std::string name() const override { return scene_->named("single rays"); }
  std::string does() const override { return scene_->shows() + ", ray by ray"; }

 private:
  void trace(const PeerView& view, RTCScene scene) override {
    const PixelRays<float> rays(moved(view.camera), view.width, view.height);
    const auto origin = rays.origin();
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    std::size_t pixel = 0;
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x, ++pixel) {
        const auto direction = rays.through(x, y);
        RTCRayHit ray{};
        ray.ray = {origin.x, origin.y, origin.z, 0, direction.x, direction.y, direction.z, 0, infinity, ~0U, 0, 0};
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &ray);
        const bool is_hit = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        take(pixel, is_hit ? ray.ray.tfar : infinity, {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z},
             {direction.x, direction.y, direction.z});
      }
  }
};

}  // namespace

PeerPointer embree_packets(std::shared_ptr<EmbreeScene> scene) {
  return std::make_unique<Packets>(std::move(scene));
}

PeerPointer embree_single_rays(std::shared_ptr<EmbreeScene> scene) {
  return std::make_unique<SingleRays>(std::move(scene));
}

}  // namespace rhoray::study
