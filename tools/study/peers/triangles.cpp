#include "tools/study/peers/triangles.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>

#include "formats/base/checks.h"
#include "formats/base/trouble.h"
#include "tools/study/peers/vtk_image.h"
#include "tools/study/plain_grid.h"

namespace rhoray::study {

vtkSmartPointer<vtkImageData> vtk_image(const preprocess::NeutralVolume& grid) {
  const Index3 n = grid.sample_count;
  const Vec3 spacing = spacing_of(grid);
  const auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(static_cast<int>(n.x), static_cast<int>(n.y), static_cast<int>(n.z));
  image->SetSpacing(spacing.x, spacing.y, spacing.z);
  formats::with_element_type(grid.type, [&]<class T>(T) {
    vtkNew<vtkAOSDataArrayTemplate<T>> samples;
    constexpr int is_kept_by_the_caller = 1;
    samples->SetArray(const_cast<T*>(reinterpret_cast<const T*>(grid.samples.data())), volume(n),
                      is_kept_by_the_caller);
    samples->SetName("value");
    image->GetPointData()->SetScalars(samples);
  });
  return image;
}

struct Triangles::State {
  std::optional<double> isovalue;
  double extraction_ms = 0;
  vtkSmartPointer<vtkPolyData> surface;
};

Triangles::Triangles() : state_(std::make_unique<State>()) {}
Triangles::~Triangles() = default;

double Triangles::extract(const PeerData& data, double isovalue) {
  if (state_->isovalue == isovalue) return state_->extraction_ms;
  state_->surface = nullptr;
  state_->extraction_ms = cpu_ms_of([&] {
    vtkNew<vtkFlyingEdges3D> filter;
    filter->SetInputData(vtk_image(data.grid));
    filter->SetValue(0, isovalue);
    filter->ComputeNormalsOff();
    filter->ComputeGradientsOff();
    filter->ComputeScalarsOff();
    filter->Update();
    state_->surface = filter->GetOutput();
  });
  state_->isovalue = isovalue;
  return state_->extraction_ms;
}

std::size_t Triangles::vertex_count() const {
  return static_cast<std::size_t>(state_->surface->GetNumberOfPoints());
}

std::size_t Triangles::triangle_count() const {
  return static_cast<std::size_t>(state_->surface->GetNumberOfPolys());
}

void Triangles::copy_vertices(std::span<float> out) const {
  if (vertex_count() == 0) return;
  const auto* points = vtkAOSDataArrayTemplate<float>::FastDownCast(state_->surface->GetPoints()->GetData());
  RHORAY_CHECK(points != nullptr && out.size() == 3 * vertex_count());
  std::copy_n(const_cast<vtkAOSDataArrayTemplate<float>*>(points)->GetPointer(0), out.size(), out.begin());
}

void Triangles::copy_triangles(std::span<std::uint32_t> out) const {
  vtkCellArray* const polygons = state_->surface->GetPolys();
  RHORAY_CHECK(polygons->IsHomogeneous() == 3 || triangle_count() == 0);
  const auto copy = [&](const auto* corners) {
    std::transform(corners, corners + out.size(), out.begin(), [](auto c) { return static_cast<std::uint32_t>(c); });
  };
  if (polygons->IsStorage64Bit())
    copy(polygons->GetConnectivityArray64()->GetPointer(0));
  else
    copy(polygons->GetConnectivityArray32()->GetPointer(0));
}

double Triangles::memory_mb() const {
  return 1.024e-3 * static_cast<double>(state_->surface->GetActualMemorySize());  // of kibibytes
}

vtkPolyData* Triangles::vtk() const {
  return state_->surface;
}

}  // namespace rhoray::study
