#pragma once

namespace rhoray::render {

/// How a ray's question is answered: by which search, and in which precision. A picture names the one it was made with.
///
/// The ways, and how each answers the three questions: first crossing in a grid; first crossing in tetrahedra; largest
/// value.
/// - direct: bracketed root of the cell's cubic; canonical edges, no gaps; critical points of the cubic
/// - preview: entry and exit, one secant step; as direct; as direct
/// - paper: Appendix A, Schwarze's cubic; Appendix B; values on the cells' faces (4.3)
/// - slack: none; Appendix B with a tolerance; none
/// - sampled: a change of side between samples; the same; the largest sample
/// - certified: proven, or decided by the judge; the same; direct, with a bound
/// - judged: every decision exact; the same; the same
///
/// Promises: direct meets every crossing that its arithmetic tells apart and none twice; preview misses what enters and
/// leaves a cell on one side; paper is what was published in 1999, gaps and all; sampled misses what lies between two
/// samples. What certified calls a miss is one, what it calls a hit lies within its bound: in a grid at most 1e-3 cells
/// where single precision decided, 1e-6 where double did, 1e-12 where the judge did; more where the ray's own numbers
/// leave more open (cells/certified_crossing.h: is_placed_well). Judged is the exact answer for the ray's numbers and
/// the stored data.
struct Method {
  enum class Way { direct, preview, paper, slack, sampled, certified, judged };
  enum class Precision { single, twofold };  ///< inside a cell; the way from cell to cell is always in double

  Way way = Way::direct;
  Precision precision = Precision::twofold;  ///< of direct, preview, paper, slack
  double step = 0.5;                         ///< of sampled: cells of the lattice
  bool bisect = false;                       ///< of sampled: refine by bisection, not by one linear step
  double slack = 0;                          ///< of slack: what a barycentric coordinate may lie below 0

  friend bool operator==(const Method&, const Method&) = default;
};

/// True when every hit carries a bound of its error.
constexpr bool proves(const Method& method) {
  return method.way == Method::Way::certified || method.way == Method::Way::judged;
}

/// The levels of accuracy that a user chooses from; commands and pictures call `single` float and `twofold` double.
enum class Accuracy { preview, single, twofold, certified, exact };

constexpr Method method_of(Accuracy accuracy) {
  switch (accuracy) {
    case Accuracy::preview:
      return {.way = Method::Way::preview, .precision = Method::Precision::single};
    case Accuracy::single:
      return {.way = Method::Way::direct, .precision = Method::Precision::single};
    case Accuracy::twofold:
      return {};
    case Accuracy::certified:
      return {.way = Method::Way::certified};
    case Accuracy::exact:
      break;
  }
  return {.way = Method::Way::judged};
}

}  // namespace rhoray::render
