#include "tools/lab/peers/triangles.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkContour3DLinearGrid.h>
#include <vtkDoubleArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkMarchingCubes.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSynchronizedTemplates3D.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <optional>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "tools/lab/peers/vtk_image.h"
#include "tools/lab/plain_grid.h"
#include "tools/validate/grid_surface.h"

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

/// A method that makes triangles.
class Triangles::Extractor {
 public:
  virtual ~Extractor() = default;

  /// Converts the data to the form that VTK needs. Not timed.
  virtual void take(const PeerData& data) = 0;
  virtual vtkSmartPointer<vtkPolyData> surface(double isovalue) = 0;
  /// True when the first surface makes something that later ones use.
  virtual bool prepares_once() const { return false; }
  virtual bool is_complete() const { return true; }

  vtkSmartPointer<vtkPolyData> last;
};

namespace {

/// One of VTK's filters that make triangles of a grid.
template <class Filter>
class GridFilter final : public Triangles::Extractor {
 public:
  void take(const PeerData& data) override { image_ = vtk_image(*data.grid); }

  vtkSmartPointer<vtkPolyData> surface(double isovalue) override {
    vtkNew<Filter> filter;
    filter->SetInputData(image_);
    filter->SetValue(0, isovalue);
    filter->ComputeNormalsOff();
    filter->ComputeGradientsOff();
    filter->ComputeScalarsOff();
    filter->Update();
    return filter->GetOutput();
  }

 private:
  vtkSmartPointer<vtkImageData> image_;
};

class CgalMesher final : public Triangles::Extractor {
 public:
  explicit CgalMesher(double facet_count) : facet_count_(facet_count) {}

  void take(const PeerData& data) override {
    field_.emplace(formats::BrickGrid(formats::PackedFile::open(data.packed_file)), data.field);
    spacing_ = spacing_of(*data.grid);
  }

  vtkSmartPointer<vtkPolyData> surface(double isovalue) override {
    constexpr std::size_t most_seeds = 400'000;  // as in `rhoray validate`
    const auto seeds = tools::validate::edge_points(*field_, isovalue, most_seeds, 1);
    const auto meshed = tools::validate::mesh_surface(*field_, isovalue, seeds,
                                                      {.facet_count = facet_count_, .measures_offsets = false});
    is_complete_ = meshed.stopped_because.empty();
    vtkNew<vtkPoints> points;
    points->SetDataTypeToFloat();
    for (const Vec3& p : meshed.triangles.points)
      points->InsertNextPoint((spacing_ * p).x, (spacing_ * p).y, (spacing_ * p).z);
    vtkNew<vtkCellArray> triangles;
    for (const auto& corners : meshed.triangles.corners)
      triangles->InsertNextCell({vtkIdType{corners[0]}, vtkIdType{corners[1]}, vtkIdType{corners[2]}});
    const auto made = vtkSmartPointer<vtkPolyData>::New();
    made->SetPoints(points);
    made->SetPolys(triangles);
    return made;
  }

  bool is_complete() const override { return is_complete_; }

 private:
  double facet_count_;
  std::optional<tools::validate::GridField> field_;
  Vec3 spacing_{1, 1, 1};
  bool is_complete_ = true;
};

/// Tetrahedra with one field as a VTK grid.
vtkSmartPointer<vtkUnstructuredGrid> vtk_tetrahedra(const preprocess::NeutralMesh& mesh) {
  const auto count = static_cast<vtkIdType>(mesh.points.size());
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  for (vtkIdType p = 0; p < count; ++p) points->SetPoint(p, mesh.points[static_cast<std::size_t>(p)].data());
  vtkNew<vtkCellArray> cells;
  cells->AllocateExact(static_cast<vtkIdType>(mesh.cells.size()), 4 * static_cast<vtkIdType>(mesh.cells.size()));
  for (const auto& cell : mesh.cells) {
    const vtkIdType corners[4] = {static_cast<vtkIdType>(cell[0]), static_cast<vtkIdType>(cell[1]),
                                  static_cast<vtkIdType>(cell[2]), static_cast<vtkIdType>(cell[3])};
    cells->InsertNextCell(4, corners);
  }
  vtkNew<vtkDoubleArray> values;
  values->SetNumberOfTuples(count);
  for (vtkIdType p = 0; p < count; ++p) values->SetValue(p, mesh.point_fields[0].values[static_cast<std::size_t>(p)]);
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->SetCells(VTK_TETRA, cells);
  grid->GetPointData()->SetScalars(values);
  return grid;
}

class LinearGridContour final : public Triangles::Extractor {
 public:
  explicit LinearGridContour(bool with_tree) : with_tree_(with_tree) {
    filter_->SequentialProcessingOn();
    filter_->SetOutputPointsPrecision(vtkAlgorithm::SINGLE_PRECISION);
    filter_->MergePointsOff();
    filter_->InterpolateAttributesOff();
    filter_->ComputeNormalsOff();
    filter_->ComputeScalarsOff();
    filter_->SetUseScalarTree(with_tree);
  }

  void take(const PeerData& data) override {
    if (mesh_ == data.mesh) return;
    mesh_ = data.mesh;
    filter_->SetInputData(vtk_tetrahedra(*data.mesh));
  }

  vtkSmartPointer<vtkPolyData> surface(double isovalue) override {
    filter_->SetValue(0, isovalue);
    filter_->Modified();
    filter_->Update();
    const auto copy = vtkSmartPointer<vtkPolyData>::New();
    copy->ShallowCopy(filter_->GetOutput());
    return copy;
  }

  bool prepares_once() const override { return with_tree_; }

 private:
  bool with_tree_;
  const preprocess::NeutralMesh* mesh_ = nullptr;
  vtkNew<vtkContour3DLinearGrid> filter_;
};

}  // namespace

Triangles::Triangles(std::unique_ptr<Extractor> extractor, const std::string& maker, const std::string& variant)
    : extractor_(std::move(extractor)), maker_(maker), variant_(variant) {}
Triangles::~Triangles() = default;

std::shared_ptr<Triangles> flying_edges() {
  return std::make_shared<Triangles>(std::make_unique<GridFilter<vtkFlyingEdges3D>>(), "FlyingEdges", "");
}
std::shared_ptr<Triangles> marching_cubes() {
  return std::make_shared<Triangles>(std::make_unique<GridFilter<vtkMarchingCubes>>(), "MarchingCubes", "");
}
std::shared_ptr<Triangles> synchronized_templates() {
  return std::make_shared<Triangles>(std::make_unique<GridFilter<vtkSynchronizedTemplates3D>>(),
                                     "SynchronizedTemplates", "");
}

std::shared_ptr<Triangles> cgal_mesher(double facet_count) {
  return std::make_shared<Triangles>(std::make_unique<CgalMesher>(facet_count), "CGAL's surface mesher", "");
}

std::shared_ptr<Triangles> linear_grid_contour(bool with_tree) {
  return std::make_shared<Triangles>(std::make_unique<LinearGridContour>(with_tree),
                                     with_tree ? "Contour3DLinearGrid with its tree" : "Contour3DLinearGrid",
                                     with_tree ? "tree" : "");
}

bool Triangles::is_complete() const {
  return extractor_->is_complete();
}

std::string Triangles::named(const std::string& system) const {
  return variant_.empty() ? system : concat(system, ", ", variant_);
}

Preparation Triangles::extract(const PeerData& data, double isovalue) {
  if (isovalue_ == isovalue) return preparation_;
  const bool is_first = !isovalue_;
  extractor_->take(data);
  const auto extraction_ms = [&] {
    extractor_->last = nullptr;
    return cpu_ms_of([&] { extractor_->last = extractor_->surface(isovalue); });
  };
  preparation_.extraction_ms = extraction_ms();
  if (is_first && extractor_->prepares_once()) {
    const double with_preparation = preparation_.extraction_ms;
    preparation_.extraction_ms = extraction_ms();
    preparation_.once_ms = std::max(0.0, with_preparation - preparation_.extraction_ms);
  }
  isovalue_ = isovalue;
  return preparation_;
}

std::size_t Triangles::vertex_count() const {
  return static_cast<std::size_t>(extractor_->last->GetNumberOfPoints());
}

std::size_t Triangles::triangle_count() const {
  return static_cast<std::size_t>(extractor_->last->GetNumberOfPolys());
}

void Triangles::copy_vertices(std::span<float> out) const {
  if (vertex_count() == 0) return;
  const auto* points = vtkAOSDataArrayTemplate<float>::FastDownCast(extractor_->last->GetPoints()->GetData());
  RHORAY_CHECK(points != nullptr && out.size() == 3 * vertex_count());
  std::copy_n(const_cast<vtkAOSDataArrayTemplate<float>*>(points)->GetPointer(0), out.size(), out.begin());
}

void Triangles::copy_triangles(std::span<std::uint32_t> out) const {
  vtkCellArray* const polygons = extractor_->last->GetPolys();
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
  return 1.024e-3 * static_cast<double>(extractor_->last->GetActualMemorySize());  // from kibibytes
}

vtkPolyData* Triangles::vtk() const {
  return extractor_->last;
}

}  // namespace rhoray::study
