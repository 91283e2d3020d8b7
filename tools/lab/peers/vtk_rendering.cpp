#include "tools/lab/peers/vtk_rendering.h"

#include <dlfcn.h>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkFixedPointRayCastImage.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkFloatArray.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "formats/base/text.h"
#include "tools/lab/peers/pixel_rays.h"
#include "tools/lab/peers/vtk_image.h"
#include "tools/lab/plain_grid.h"

namespace rhoray::study {

namespace {

/// The range that contains all data: distances along the view's axis.
struct DepthRange {
  double near, far;
};

DepthRange depth_range(const PeerView& view, const Box3& box) {
  const Vec3 forward = (view.camera.target - view.camera.position).normalized();
  double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                 corner & 4 ? box.max.z : box.min.z);
    const double depth = (p - view.camera.position).dot(forward);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  return {std::max(0.999 * nearest, 1e-3 * farthest), 1.001 * farthest};
}

void set_camera(vtkRenderer* renderer, const PeerView& view, const DepthRange& range) {
  vtkCamera* const camera = renderer->GetActiveCamera();
  const auto &position = view.camera.position, &target = view.camera.target, &up = view.camera.up;
  camera->SetPosition(position.x, position.y, position.z);
  camera->SetFocalPoint(target.x, target.y, target.z);
  camera->SetViewUp(up.x, up.y, up.z);
  camera->SetViewAngle(view.camera.vertical_fov_deg);
  camera->SetClippingRange(range.near, range.far);
}

/// A view of few pixels from outside the box, to trigger what only the first picture does.
PeerView few_pixels(const Box3& box) {
  return {.camera = {.position = box.center() + box.size() * 2.5, .target = box.center()}, .width = 16, .height = 16};
}

class Drawing final : public Peer {
 public:
  explicit Drawing(std::shared_ptr<Triangles> triangles) : triangles_(std::move(triangles)) {
    window_->SetOffScreenRendering(1);
    window_->SetMultiSamples(0);
    window_->AddRenderer(renderer_);
    renderer_->SetBackground(1, 1, 1);
    actor_->SetMapper(mapper_);
    actor_->GetProperty()->SetColor(0.78, 0.74, 0.68);
    actor_->GetProperty()->SetInterpolationToFlat();
    renderer_->AddActor(actor_);
  }

  std::string name() const override { return triangles_->named("VTK, drawing"); }
  std::string does() const override {
    return concat("triangles of ", triangles_->maker(), " through OpenGL, in software without a GPU");
  }

  Preparation prepare(const PeerData& data, double isovalue) override {
    Preparation preparation;
    preparation.once_ms = triangles_->extract(data, isovalue).once_ms;
    preparation.extraction_ms = triangles_->extract(data, isovalue).extraction_ms;
    bounds_ = data.bounds;
    mapper_->SetInputData(triangles_->vtk());
    // The first picture sends the triangles to OpenGL.
    preparation.build_ms = cpu_ms_of([&] { draw(few_pixels(bounds_)); });
    return preparation;
  }

  std::optional<double> prepared_mb() const override { return triangles_->memory_mb(); }

  void draw(const PeerView& view) override {
    window_->SetSize(view.width, view.height);
    set_camera(renderer_, view, depth_range(view, bounds_));
    window_->Render();
    window_->GetRGBACharPixelData(0, 0, view.width - 1, view.height - 1, 0, color_);
  }

  std::vector<double> answers(const PeerView& view) override {
    draw(view);
    vtkNew<vtkFloatArray> depths;
    window_->GetZbufferData(0, 0, view.width - 1, view.height - 1, depths);
    const DepthRange range = depth_range(view, bounds_);
    const Vec3 forward = (view.camera.target - view.camera.position).normalized();
    const PixelRays<double> rays(view.camera, view.width, view.height);
    std::vector<double> distances;
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x) {
        // Rows from below.
        const double z = depths->GetValue(vtkIdType{view.height - 1 - y} * view.width + x);
        const double depth = range.near * range.far / (range.far - z * (range.far - range.near));
        const auto d = rays.through(x, y);
        distances.push_back(z >= 1 ? std::numeric_limits<double>::infinity()
                                   : depth / Vec3(d.x, d.y, d.z).dot(forward));
      }
    return distances;
  }

 private:
  std::shared_ptr<Triangles> triangles_;
  Box3 bounds_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkActor> actor_;
  vtkNew<vtkPolyDataMapper> mapper_;
  vtkNew<vtkUnsignedCharArray> color_;
};

class LargestValues final : public Peer {
 public:
  explicit LargestValues(double step) : step_(step) {
    window_->AddRenderer(renderer_);
    volume_->SetMapper(mapper_);
    renderer_->AddVolume(volume_);
    mapper_->SetBlendModeToMaximumIntensity();
    mapper_->SetNumberOfThreads(1);
    mapper_->AutoAdjustSampleDistancesOff();
    mapper_->LockSampleDistanceToInputSpacingOff();
    mapper_->IntermixIntersectingGeometryOff();
    mapper_->SetImageSampleDistance(1);
    volume_->GetProperty()->SetInterpolationTypeToLinear();
    volume_->GetProperty()->ShadeOff();
  }

  std::string name() const override { return concat("VTK, step ", step_); }
  std::string does() const override { return "fixed-point mapper, the cast alone"; }

  Preparation prepare(const PeerData& data, double) override {
    range_ = data.range;
    bounds_ = data.bounds;
    const Vec3 spacing = spacing_of(*data.grid);
    mapper_->SetInputData(vtk_image(*data.grid));
    mapper_->SetSampleDistance(static_cast<float>(step_ * std::min({spacing.x, spacing.y, spacing.z})));
    vtkNew<vtkColorTransferFunction> gray;
    gray->AddRGBPoint(range_.lo, 0, 0, 0);
    gray->AddRGBPoint(range_.hi, 1, 1, 1);
    vtkNew<vtkPiecewiseFunction> opaque;
    opaque->AddPoint(range_.lo, 1);
    opaque->AddPoint(range_.hi, 1);
    volume_->GetProperty()->SetColor(gray);
    volume_->GetProperty()->SetScalarOpacity(opaque);
    Preparation preparation;
    // The first cast also makes the mapper's own table of smallest and largest values.
    preparation.once_ms = cpu_ms_of([&] { draw(few_pixels(bounds_)); });
    return preparation;
  }

  void draw(const PeerView& view) override {
    window_->SetSize(view.width, view.height);
    set_camera(renderer_, view, depth_range(view, bounds_));
    // What the mapper's Render does, up to the point where the picture goes to OpenGL.
    mapper_->PerImageInitialization(renderer_, volume_, 0, nullptr, nullptr, nullptr);
    mapper_->PerVolumeInitialization(renderer_, volume_);
    mapper_->PerSubVolumeInitialization(renderer_, volume_, 0);
    mapper_->RenderSubVolume();
  }

  std::vector<double> answers(const PeerView& view) override {
    draw(view);
    vtkFixedPointRayCastImage* const image = mapper_->GetRayCastImage();
    int in_use[2], in_memory[2], origin[2];
    image->GetImageInUseSize(in_use);
    image->GetImageMemorySize(in_memory);
    image->GetImageOrigin(origin);
    std::vector<double> values(view.pixel_count(), std::numeric_limits<double>::quiet_NaN());
    for (int v = 0; v < in_use[1]; ++v)
      for (int u = 0; u < in_use[0]; ++u) {
        const unsigned short* const rgba = image->GetImage() + 4 * (v * in_memory[0] + u);
        const int x = origin[0] + u, y = view.height - 1 - (origin[1] + v);  // rows from below
        if (rgba[3] == 0 || x < 0 || y < 0 || x >= view.width || y >= view.height) continue;
        constexpr double brightest = 32767;  // 15 bits
        const std::size_t pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(x);
        values[pixel] = range_.lo + rgba[0] / brightest * (range_.hi - range_.lo);
      }
    return values;
  }

 private:
  double step_;
  Interval<double> range_;
  Box3 bounds_;
  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkVolume> volume_;
  vtkNew<vtkFixedPointVolumeRayCastMapper> mapper_;
};

}  // namespace

PeerPointer vtk_drawing(std::shared_ptr<Triangles> triangles) {
  return std::make_unique<Drawing>(std::move(triangles));
}

std::string no_display() {
  // VTK ends the program if it finds no X server, so test for one first.
  void* const library = ::dlopen("libX11.so.6", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return "no libX11";
  const auto open = reinterpret_cast<void* (*)(const char*)>(::dlsym(library, "XOpenDisplay"));
  const auto close = reinterpret_cast<int (*)(void*)>(::dlsym(library, "XCloseDisplay"));
  void* const display = open == nullptr || close == nullptr ? nullptr : open(nullptr);
  if (display == nullptr) return "no X display: run under xvfb-run";
  close(display);
  return {};
}

PeerPointer vtk_largest_values(double step) {
  return std::make_unique<LargestValues>(step);
}

}  // namespace rhoray::study
