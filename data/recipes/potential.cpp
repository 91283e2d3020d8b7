#include "data/recipes/potential.h"

#include <Eigen/Dense>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "data/recipes/torso_surface.h"
#include "formats/base/error.h"

namespace rhoray::recipes {

namespace {

using Matrix = Eigen::SparseMatrix<double>;  // lower triangle only
using Vector = Eigen::VectorXd;
using Point = Eigen::Vector3d;

/// A tetrahedron with the gradients of its four basis functions.
struct Element {
  std::array<Point, 4> corners;
  std::array<Point, 4> gradients;
  double volume = 0;
};

Element element(const preprocess::NeutralMesh& mesh, std::size_t cell) {
  Element e;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint64_t corner = mesh.cells[cell][i];
    if (corner >= mesh.points.size())
      throw Error(ErrorCode::invalid,
                  concat("mesh: cell ", cell, " names point ", corner, "; there are ", mesh.points.size()));
    e.corners[i] = Point(mesh.points[corner].data());
  }
  Eigen::Matrix3d edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = e.corners[static_cast<std::size_t>(i) + 1] - e.corners[0];
  const double determinant = edges.determinant();
  e.volume = std::abs(determinant) / 6;
  if (!(e.volume > 0) || !std::isfinite(e.volume))
    throw Error(ErrorCode::invalid, concat("mesh: cell ", cell, " has volume ", e.volume, "; expected a positive one"));
  const Eigen::Matrix3d inverse = edges.inverse();
  for (int i = 0; i < 3; ++i) e.gradients[static_cast<std::size_t>(i) + 1] = inverse.row(i).transpose();
  e.gradients[0] = -(e.gradients[1] + e.gradients[2] + e.gradients[3]);
  return e;
}

/// Integral of the smoothed dipole's density over the element, by the four-point rule that is exact
/// for quadratics.
double dipole_share(const Element& e, const Dipole& dipole) {
  constexpr double near = 0.5854101966249685, far = 0.1381966011250105;
  const Point centre(dipole.at_mm.data());
  const double w2 = dipole.width_mm * dipole.width_mm;
  const double peak = std::pow(2 * std::numbers::pi * w2, -1.5);
  double mean = 0;
  for (std::size_t q = 0; q < 4; ++q) {
    Point p = Point::Zero();
    for (std::size_t i = 0; i < 4; ++i) p += (i == q ? near : far) * e.corners[i];
    mean += 0.25 * peak * std::exp(-(p - centre).squaredNorm() / (2 * w2));
  }
  return e.volume * mean;
}

struct System {
  Matrix stiffness;      // S/m * mm
  Vector load;           // mA
  Vector point_volumes;  // a quarter of each cell to each corner: weights of the mean
};

System assemble(const preprocess::NeutralMesh& mesh, std::span<const double> conductivity, const Dipole& dipole) {
  const auto n = static_cast<Eigen::Index>(mesh.points.size());
  System system{Matrix(n, n), Vector::Zero(n), Vector::Zero(n)};
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(10 * mesh.cells.size());
  const Point moment(dipole.moment_ma_mm.data());
  double dipole_inside = 0;
  for (std::size_t cell = 0; cell < mesh.cells.size(); ++cell) {
    const Element e = element(mesh, cell);
    const double share = dipole_share(e, dipole);
    dipole_inside += share;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto row = static_cast<int>(mesh.cells[cell][i]);
      system.load[row] += share * moment.dot(e.gradients[i]);
      system.point_volumes[row] += e.volume / 4;
      for (std::size_t j = 0; j < 4; ++j)
        if (const auto column = static_cast<int>(mesh.cells[cell][j]); column <= row)
          entries.emplace_back(row, column, conductivity[cell] * e.volume * e.gradients[i].dot(e.gradients[j]));
    }
  }
  system.stiffness.setFromTriplets(entries.begin(), entries.end());
  if (!(moment.norm() > 0)) return system;
  // Coarse cells integrate the density roughly. Dividing by the integral makes the strength right
  // on every mesh.
  if (!(dipole_inside > 0.2 && dipole_inside < 5))
    throw Error(ErrorCode::invalid,
                concat("mesh: holds ", dipole_inside, " of the dipole at (", dipole.at_mm[0], ", ", dipole.at_mm[1],
                       ", ", dipole.at_mm[2], "); expected about 1"),
                "move it inside, make it wider, or use a finer mesh");
  system.load /= dipole_inside;
  return system;
}

/// Replaces the equations of fixed points by "unknown = value" and keeps the matrix symmetric.
void hold(System& system, const HeldFixed& fixed) {
  std::vector<char> is_fixed(static_cast<std::size_t>(system.load.size()), 0);
  Vector values = Vector::Zero(system.load.size());
  for (const auto& [point, value_mv] : fixed) {
    is_fixed.at(point) = 1;
    values[static_cast<Eigen::Index>(point)] = value_mv / 1000;
  }
  system.load -= system.stiffness.selfadjointView<Eigen::Lower>() * values;
  system.stiffness.prune([&](Eigen::Index row, Eigen::Index column, double) {
    return row == column || !(is_fixed[static_cast<std::size_t>(row)] || is_fixed[static_cast<std::size_t>(column)]);
  });
  for (Eigen::Index i = 0; i < system.load.size(); ++i) {
    if (!is_fixed[static_cast<std::size_t>(i)]) continue;
    system.stiffness.coeffRef(i, i) = 1;
    system.load[i] = values[i];
  }
}

Vector solve(const System& system, PotentialReport& report) {
  // unknowns; for more, factorizing a 3-D matrix costs more than iterating
  constexpr Eigen::Index most_direct = 20'000;
  if (system.load.size() <= most_direct) {
    const Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factor(system.stiffness);
    if (factor.info() != Eigen::Success)
      throw Error(ErrorCode::invalid, "mesh: the system of equations is singular", "look for points without cells");
    return factor.solve(system.load);
  }
  Eigen::ConjugateGradient<Matrix, Eigen::Lower, Eigen::IncompleteCholesky<double, Eigen::Lower>> iteration;
  iteration.setTolerance(1e-10);
  iteration.setMaxIterations(20'000);
  iteration.compute(system.stiffness);
  const Vector solution = iteration.solve(system.load);
  report.iteration_count = static_cast<std::uint64_t>(iteration.iterations());
  if (iteration.info() != Eigen::Success)
    throw Error(ErrorCode::invalid,
                concat("mesh: potential not found after ", iteration.iterations(), " iterations; residual ",
                       iteration.error(), ", expected 1e-10"),
                "look for very flat cells and for disconnected parts");
  return solution;
}

void check_input(const preprocess::NeutralMesh& mesh, std::span<const double> conductivity, const Dipole& dipole,
                 const HeldFixed& fixed) {
  if (mesh.cells.empty()) throw Error(ErrorCode::invalid, "mesh: no cells");
  if (mesh.points.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw Error(ErrorCode::unsupported, concat("mesh: ", mesh.points.size(), " points; at most 2147483647"));
  if (conductivity.size() != mesh.cells.size())
    throw Error(ErrorCode::usage, concat(conductivity.size(), " conductivities for ", mesh.cells.size(), " cells"));
  for (const double sigma : conductivity)
    if (!(sigma > 0 && std::isfinite(sigma)))
      throw Error(ErrorCode::usage, concat("conductivity ", sigma, "; expected more than 0"));
  if (!(dipole.width_mm > 0))
    throw Error(ErrorCode::usage, concat("dipole of width ", dipole.width_mm, "; expected more than 0"));
  for (const auto& [point, value] : fixed)
    if (point >= mesh.points.size())
      throw Error(ErrorCode::usage, concat("fixed point ", point, " of ", mesh.points.size()));
}

}  // namespace

PotentialReport solve_potential(const preprocess::NeutralMesh& mesh, std::span<const double> conductivity,
                                const Dipole& dipole, const HeldFixed& fixed) {
  check_input(mesh, conductivity, dipole, fixed);
  System system = assemble(mesh, conductivity, dipole);
  // Without a fixed point, the potential is known up to a constant: fix one point, then subtract
  // the mean.
  hold(system, fixed.empty() ? HeldFixed{{mesh.cells[0][0], 0.0}} : fixed);
  PotentialReport report;
  Vector volts = solve(system, report);
  const double load = system.load.norm();
  const Vector rest = system.stiffness.selfadjointView<Eigen::Lower>() * volts - system.load;
  report.residual = load > 0 ? rest.norm() / load : rest.norm();
  if (fixed.empty()) volts.array() -= volts.dot(system.point_volumes) / system.point_volumes.sum();
  report.potential_mv.resize(mesh.points.size());
  Vector::Map(report.potential_mv.data(), volts.size()) = 1000 * volts;
  return report;
}

std::vector<double> conductivity_of_cells(const preprocess::NeutralMesh& mesh, const Conductivities& conductivities) {
  const auto region = std::find_if(mesh.cell_fields.begin(), mesh.cell_fields.end(),
                                   [](const auto& field) { return field.name == "region"; });
  if (region == mesh.cell_fields.end() || region->values.size() != mesh.cells.size())
    throw Error(ErrorCode::invalid, "mesh: no cell field \"region\" that tells torso, heart and lungs apart",
                "make the mesh with: rhoray tetrahedralize torso.smesh");
  std::vector<double> conductivity;
  conductivity.reserve(mesh.cells.size());
  for (const double number : region->values) {
    if (number == static_cast<double>(Tissue::torso))
      conductivity.push_back(conductivities.torso);
    else if (number == static_cast<double>(Tissue::heart))
      conductivity.push_back(conductivities.heart);
    else if (number == static_cast<double>(Tissue::lungs))
      conductivity.push_back(conductivities.lungs);
    else
      throw Error(ErrorCode::invalid, concat("mesh: cell ", conductivity.size(), " is of region ", number,
                                             "; expected 1 (torso), 2 (heart) or 3 (lungs)"));
  }
  return conductivity;
}

}  // namespace rhoray::recipes
