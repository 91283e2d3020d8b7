#pragma once

namespace rhoray::render {

/// How a ray is intersected: an algorithm and its precision. A picture names the method that made
/// it.
///
/// Each algorithm answers three queries: the first crossing in a grid, the first crossing in
/// tetrahedra, and the largest value.
/// - direct: bracketed root of the cell's cubic; canonical edges, no gaps; critical points of the
///   cubic
/// - preview: entry and exit, one secant step; as direct; as direct
/// - paper: Appendix A, Schwarze's cubic; Appendix B; values on the cells' faces (4.3)
/// - slack: none; Appendix B with a tolerance; none
/// - sampled: a change of side between samples; the same; the largest sample
/// - certified: proven, or decided by exact arithmetic; the same; direct, with a bound
/// - exact: every decision in exact arithmetic; the same; the same
///
/// Promises: direct finds every crossing that its arithmetic resolves, and none twice. preview
/// misses a surface that a ray enters and leaves within one cell. paper is the method of 1999 with
/// its gaps. sampled misses what is between two samples. A certified miss is a miss. A certified
/// hit is within its bound. In a grid the bound is at most 1e-3 cells where single precision
/// decided, 1e-6 where double did, and 1e-12 where exact arithmetic did. It is larger where the
/// ray's own numbers are less precise (cell/certified_crossing.h: is_placed_well). exact is the
/// exact result for the ray's numbers and the stored data.
struct Method {
  enum class Algorithm { direct, preview, paper, slack, sampled, certified, exact };
  /// Precision inside a cell; traversal from cell to cell is always in double.
  enum class Precision { float32, float64 };

  Algorithm algorithm = Algorithm::direct;
  Precision precision = Precision::float64;  ///< of direct, preview, paper, slack
  /// Of sampled: distance between samples, in cells of the lattice.
  double step = 0.5;
  /// Of sampled: refine by bisection, not by one linear step.
  bool bisect = false;
  /// Of slack: how far a barycentric coordinate may be below 0.
  double slack = 0;

  friend bool operator==(const Method&, const Method&) = default;
};

/// True when every hit carries an error bound.
constexpr bool proves(const Method& method) {
  return method.algorithm == Method::Algorithm::certified || method.algorithm == Method::Algorithm::exact;
}

/// The accuracy levels that a user chooses from. Commands and pictures call float32 `float` and
/// float64 `double`.
enum class Accuracy { preview, float32, float64, certified, exact };

constexpr Method method_of(Accuracy accuracy) {
  switch (accuracy) {
    case Accuracy::preview:
      return {.algorithm = Method::Algorithm::preview, .precision = Method::Precision::float32};
    case Accuracy::float32:
      return {.algorithm = Method::Algorithm::direct, .precision = Method::Precision::float32};
    case Accuracy::float64:
      return {};
    case Accuracy::certified:
      return {.algorithm = Method::Algorithm::certified};
    case Accuracy::exact:
      break;
  }
  return {.algorithm = Method::Algorithm::exact};
}

}  // namespace rhoray::render
