#include "tools/lab/peers/embree_triangles.h"

#include "formats/base/text.h"

namespace rhoray::study {

namespace {

class TriangleScene final : public EmbreeScene {
 public:
  explicit TriangleScene(std::shared_ptr<Triangles> triangles) : triangles_(std::move(triangles)) {}

  std::string named(const std::string& way) const override { return triangles_->named(concat("Embree, ", way)); }
  std::string shows() const override { return "triangles of " + triangles_->maker(); }

 private:
  Preparation build(const PeerData& data, double isovalue) override {
    Preparation preparation = triangles_->extract(data, isovalue);
    preparation.build_ms = cpu_ms_of([&] {
      start();
      if (triangles_->triangle_count() == 0) return finish(nullptr);
      const RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_TRIANGLE);
      const std::size_t vertices = triangles_->vertex_count(), triangles = triangles_->triangle_count();
      auto* const points = static_cast<float*>(
          rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices));
      triangles_->copy_vertices({points, 3 * vertices});
      auto* const corners = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
          geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles));
      triangles_->copy_triangles({corners, 3 * triangles});
      finish(geometry);
    });
    return preparation;
  }

  std::shared_ptr<Triangles> triangles_;
};

}  // namespace

std::shared_ptr<EmbreeScene> embree_triangles(std::shared_ptr<Triangles> triangles) {
  return std::make_shared<TriangleScene>(std::move(triangles));
}

}  // namespace rhoray::study
