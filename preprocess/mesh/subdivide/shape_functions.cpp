#include "preprocess/mesh/subdivide/shape_functions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "preprocess/mesh/subdivide/cell_kinds.h"

namespace rhoray::preprocess {
namespace {

constexpr std::size_t most_basis_functions = 27;
constexpr int highest_order = 10;  // VTK's own limit

// Nodes of second-degree cells after the corners: each is at the mean of some corners.
using Middle = std::vector<std::uint8_t>;

std::vector<Middle> middles_of_tetrahedron(CellKind kind, std::size_t count) {
  std::vector<Middle> middles{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  if (kind == CellKind::quadratic_tetrahedron_14)
    middles.insert(middles.end(), {{0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 2, 1}});
  if (count == 15) middles.insert(middles.end(), {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}, {0, 1, 2, 3}});
  return middles;
}

std::vector<Middle> middles_of_hexahedron(std::size_t count) {
  std::vector<Middle> middles{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                              {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  if (count >= 24) middles.insert(middles.end(), {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}});
  if (count == 27) middles.insert(middles.end(), {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}});
  return middles;
}

std::vector<Middle> middles_of_wedge(std::size_t count) {
  std::vector<Middle> middles{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}};
  if (count >= 15) middles.insert(middles.end(), {{0, 3}, {1, 4}, {2, 5}});
  if (count == 21) middles.insert(middles.end(), {{0, 1, 2}, {3, 4, 5}});
  if (count >= 18) middles.insert(middles.end(), {{0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}});
  if (count == 21) middles.push_back({0, 1, 2, 3, 4, 5});
  return middles;
}

std::vector<Middle> middles_of_pyramid(std::size_t count) {
  std::vector<Middle> middles{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}};
  if (count >= 14) middles.push_back({0, 1, 2, 3});
  if (count == 19) middles.insert(middles.end(), {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {0, 1, 2, 3, 4}});
  return middles;
}

std::vector<CellPlace> places_of_corners(CellKind corners) {
  switch (corners) {
    case CellKind::tetrahedron:
      return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    case CellKind::hexahedron:
      return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    case CellKind::wedge:
      return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    case CellKind::pyramid:
      return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
    default:
      break;
  }
  RHORAY_CHECK(false && "a kind with higher orders");
  return {};
}

std::vector<CellPlace> places_of_nodes(CellKind kind, CellKind corners, std::size_t count) {
  std::vector<CellPlace> places = places_of_corners(corners);
  std::vector<Middle> middles;
  if (corners == CellKind::tetrahedron) middles = middles_of_tetrahedron(kind, count);
  if (corners == CellKind::hexahedron) middles = middles_of_hexahedron(count);
  if (corners == CellKind::wedge) middles = middles_of_wedge(count);
  if (corners == CellKind::pyramid) middles = middles_of_pyramid(count);
  for (const Middle& middle : middles) {
    CellPlace place{};
    for (const std::uint8_t corner : middle)
      for (std::size_t axis = 0; axis < 3; ++axis)
        place[axis] += places[corner][axis] / static_cast<double>(middle.size());
    places.push_back(place);
  }
  // The node inside a pyramid is at a quarter of its height, not at the mean of the corners.
  if (corners == CellKind::pyramid && count == 19) places.back() = {0.375, 0.375, 0.25};
  RHORAY_CHECK(places.size() == count);
  return places;
}

double power(double x, int exponent) {
  return exponent == 0 ? 1 : exponent == 1 ? x : x * x;
}

/// The excess of a monomial over linear: a serendipity cell of second degree allows 2.
int beyond_linear(int exponent) {
  return exponent == 2 ? 2 : 0;
}

class Values {
 public:
  explicit Values(std::span<double> values) : values_(values) {}
  void add(double value) {
    RHORAY_DCHECK(count_ < values_.size());
    values_[count_++] = value;
  }
  std::size_t count() const { return count_; }

 private:
  std::span<double> values_;
  std::size_t count_ = 0;
};

void tetrahedron_basis(const CellPlace& p, std::size_t count, Values& out) {
  const std::array<double, 4> l{1 - p[0] - p[1] - p[2], p[0], p[1], p[2]};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i; j < 4; ++j) out.add(l[i] * l[j]);
  if (count == 10) return;
  for (std::size_t i = 0; i < 4; ++i) out.add(l[(i + 1) % 4] * l[(i + 2) % 4] * l[(i + 3) % 4]);
  if (count == 15) out.add(l[0] * l[1] * l[2] * l[3]);
}

void hexahedron_basis(const CellPlace& p, std::size_t count, Values& out) {
  for (int i = 0; i <= 2; ++i)
    for (int j = 0; j <= 2; ++j)
      for (int k = 0; k <= 2; ++k) {
        if (count < 27 && beyond_linear(i) + beyond_linear(j) > 2) continue;
        if (count == 20 && beyond_linear(i) + beyond_linear(j) + beyond_linear(k) > 2) continue;
        out.add(power(2 * p[0] - 1, i) * power(2 * p[1] - 1, j) * power(2 * p[2] - 1, k));
      }
}

void wedge_basis(const CellPlace& p, std::size_t count, Values& out) {
  const double t = 2 * p[2] - 1, bubble = p[0] * p[1] * (1 - p[0] - p[1]);
  for (int k = 0; k <= (count == 12 ? 1 : 2); ++k) {
    for (int i = 0; i <= 2; ++i)
      for (int j = 0; i + j <= 2; ++j)
        if (count != 15 || i + j + k < 4) out.add(power(p[0], i) * power(p[1], j) * power(t, k));
    if (count == 21) out.add(bubble * power(t, k));
  }
}

void pyramid_basis(const CellPlace& p, std::size_t count, Values& out) {
  const double z = p[2], w = 1 - z;  // at the apex w is 0, and u and v are undefined
  const double u = w > 0 ? p[0] / w : 0, v = w > 0 ? p[1] / w : 0;
  for (int i = 0; i <= 2; ++i)
    for (int j = 0; j <= 2; ++j)
      for (int k = 0; k <= 2 - std::max(i, j); ++k)
        if (count != 13 || i + j < 4) out.add(power(u, i) * power(v, j) * power(w, std::max(i, j)) * power(z, k));
  if (count != 19) return;
  const double a = u * (1 - u) * w * w * z, b = v * (1 - v) * w * w * z;
  for (const double bubble : {a * (1 - v), a * v, b * (1 - u), b * u, a * v * (1 - v)}) out.add(bubble);
}

/// Computes the inverse of a square matrix, row-major (Gauss-Jordan elimination with pivoting).
std::vector<double> inverse_of(std::vector<double> a, std::size_t n) {
  std::vector<double> inverse(n * n, 0);
  for (std::size_t i = 0; i < n; ++i) inverse[i * n + i] = 1;
  for (std::size_t column = 0; column < n; ++column) {
    std::size_t pivot = column;
    for (std::size_t row = column + 1; row < n; ++row)
      if (std::abs(a[row * n + column]) > std::abs(a[pivot * n + column])) pivot = row;
    RHORAY_CHECK(std::abs(a[pivot * n + column]) > 1e-9);  // the nodes determine the functions
    for (std::size_t k = 0; k < n; ++k) {
      std::swap(a[pivot * n + k], a[column * n + k]);
      std::swap(inverse[pivot * n + k], inverse[column * n + k]);
    }
    const double scale = 1 / a[column * n + column];
    for (std::size_t k = 0; k < n; ++k) {
      a[column * n + k] *= scale;
      inverse[column * n + k] *= scale;
    }
    for (std::size_t row = 0; row < n; ++row) {
      const double factor = a[row * n + column];
      if (row == column || factor == 0) continue;
      for (std::size_t k = 0; k < n; ++k) {
        a[row * n + k] -= factor * a[column * n + k];
        inverse[row * n + k] -= factor * inverse[column * n + k];
      }
    }
  }
  return inverse;
}

// Index of a lattice position's node in VTK's Lagrange cells.

std::size_t hexahedron_index(const std::array<int, 3>& at, int n) {
  const auto [i, j, k] = at;
  const auto on_boundary = [&](int x) { return x == 0 || x == n; };
  const int m = n - 1, quarter = i ? (j ? 2 : 1) : (j ? 3 : 0);
  const int boundaries = on_boundary(i) + on_boundary(j) + on_boundary(k);
  int index = 0;
  if (boundaries == 3) {
    index = quarter + (k ? 4 : 0);
  } else if (boundaries == 2) {
    if (!on_boundary(i))
      index = 8 + (i - 1) + (j ? 2 * m : 0) + (k ? 4 * m : 0);
    else if (!on_boundary(j))
      index = 8 + (j - 1) + (i ? m : 3 * m) + (k ? 4 * m : 0);
    else
      index = 8 + 8 * m + (k - 1) + m * quarter;
  } else if (boundaries == 1) {
    const int faces = 8 + 12 * m;
    if (on_boundary(i))
      index = faces + (j - 1) + m * (k - 1) + (i ? m * m : 0);
    else if (on_boundary(j))
      index = faces + 2 * m * m + (i - 1) + m * (k - 1) + (j ? m * m : 0);
    else
      index = faces + 4 * m * m + (i - 1) + m * (j - 1) + (k ? m * m : 0);
  } else {
    index = 8 + 12 * m + 6 * m * m + (i - 1) + m * ((j - 1) + m * (k - 1));
  }
  return static_cast<std::size_t>(index);
}

std::size_t wedge_index(const std::array<int, 3>& at, int n) {
  const auto [i, j, k] = at;
  const int m = n - 1, in_triangle = (m - 1) * m / 2, in_square = m * m;
  const bool on_i = i == 0, on_j = j == 0, on_ij = i + j == n, on_k = k == 0 || k == n;
  const int corner = on_i && on_j ? 0 : on_j && on_ij ? 1 : 2;
  const int row = i + n * (j - 1) - j * (j + 1) / 2;
  const int faces = 6 + 9 * m;
  int index = 0;
  switch (on_i + on_j + on_ij + on_k) {
    case 3:
      index = corner + (k ? 3 : 0);
      break;
    case 2:
      if (!on_k)
        index = 6 + 6 * m + (k - 1) + corner * m;
      else
        index = 6 + (k ? 3 * m : 0) + (on_j ? i - 1 : on_ij ? m + j - 1 : 2 * m + n - j - 1);
      break;
    case 1:
      if (on_k)
        index = faces + (k ? in_triangle : 0) + row;
      else if (on_j)
        index = faces + 2 * in_triangle + (i - 1) + m * (k - 1);
      else if (on_ij)
        index = faces + 2 * in_triangle + in_square + (n - i - 1) + m * (k - 1);
      else
        index = faces + 2 * in_triangle + 2 * in_square + (n - j - 1) + m * (k - 1);
      break;
    default:
      index = faces + 2 * in_triangle + 3 * in_square + row + in_triangle * (k - 1);
  }
  return static_cast<std::size_t>(index);
}

/// Barycentric indices of a triangle's nodes: its rim, corner by corner and edge by edge, then the
/// triangle inside.
std::vector<std::array<int, 3>> triangle_nodes(int order) {
  std::vector<std::array<int, 3>> nodes;
  for (int low = 0, n = order; n >= 0; ++low, n -= 3) {
    if (n == 0) {
      nodes.push_back({low, low, low});
      break;
    }
    for (std::size_t corner : {2, 0, 1}) {
      std::array<int, 3> node{low, low, low};
      node[corner] += n;
      nodes.push_back(node);
    }
    for (std::size_t edge = 0; edge < 3; ++edge)
      for (int step = 1; step < n; ++step) {
        std::array<int, 3> node;
        node[edge] = low + step;
        node[(edge + 1) % 3] = low;
        node[(edge + 2) % 3] = low + n - step;
        nodes.push_back(node);
      }
  }
  return nodes;
}

/// Barycentric indices (of r, s, t, 1-r-s-t) of a tetrahedron's nodes: corners, edges, faces, then
/// the one inside.
std::vector<std::array<int, 4>> tetrahedron_nodes(int order) {
  constexpr std::size_t corners[] = {3, 0, 1, 2};  // the index that is largest there
  constexpr std::size_t edges[][2] = {{3, 0}, {0, 1}, {1, 3}, {3, 2}, {0, 2}, {1, 2}};
  constexpr std::size_t faces[][3] = {{0, 2, 3}, {2, 0, 1}, {2, 1, 3}, {1, 0, 3}};
  std::vector<std::array<int, 4>> nodes;
  for (int low = 0, n = order; n >= 0; ++low, n -= 4) {
    const std::array<int, 4> lowest{low, low, low, low};
    if (n == 0) {
      nodes.push_back(lowest);
      break;
    }
    for (const std::size_t corner : corners) {
      nodes.push_back(lowest);
      nodes.back()[corner] += n;
    }
    for (const auto& [from, to] : edges)
      for (int step = 1; step < n; ++step) {
        nodes.push_back(lowest);
        nodes.back()[from] += n - step;
        nodes.back()[to] += step;
      }
    if (n < 3) break;
    for (const auto& face : faces)
      for (const std::array<int, 3>& inner : triangle_nodes(n - 3)) {
        nodes.push_back(lowest);
        for (std::size_t c = 0; c < 3; ++c) nodes.back()[face[c]] += 1 + inner[c];
      }
  }
  return nodes;
}

std::size_t lattice_size(CellKind corners, int order) {
  const auto n = static_cast<std::size_t>(order);
  if (corners == CellKind::tetrahedron) return (n + 1) * (n + 2) * (n + 3) / 6;
  if (corners == CellKind::wedge) return (n + 1) * (n + 1) * (n + 2) / 2;
  return (n + 1) * (n + 1) * (n + 1);
}

bool is_lagrange(CellKind kind) {
  return kind == CellKind::lagrange_tetrahedron || kind == CellKind::lagrange_hexahedron ||
         kind == CellKind::lagrange_wedge;
}

/// The order of a Lagrange cell; 0 for the two kinds of second degree with nodes at the centres of
/// faces.
int order_of(const KindOfCell& kind, std::size_t node_count) {
  const bool has_middles = (kind.corners == CellKind::tetrahedron && node_count == 15) ||
                           (kind.corners == CellKind::wedge && node_count == 21);
  if (has_middles) return 0;
  for (int order = 1; order <= highest_order; ++order)
    if (lattice_size(kind.corners, order) == node_count) return order;
  throw Error(ErrorCode::unsupported,
              concat("found a ", kind.singular, " of ", node_count, " nodes; expected one order from 1 to ",
                     highest_order, " along all axes"));
}

}  // namespace

bool ShapeFunctions::is_linear(CellKind kind, std::size_t node_count) {
  const KindOfCell& description = description_of(kind);
  return description.corners == kind || frame_of(description.corners).corner_count == node_count;
}

ShapeFunctions::ShapeFunctions(CellKind kind, std::size_t node_count)
    : corners_(description_of(kind).corners), count_(node_count) {
  const KindOfCell& description = description_of(kind);
  if (description.node_count != 0 && description.node_count != node_count)
    throw Error(ErrorCode::invalid, concat("found a ", description.singular, " of ", node_count, " nodes; expected ",
                                           description.node_count));
  if (kind == CellKind::lagrange_pyramid && node_count != 13 && node_count != 14)
    throw Error(ErrorCode::unsupported, concat("found a Lagrange pyramid of ", node_count,
                                               " nodes, which is not defined; expected 5, 13 or 14"));
  const int order = is_lagrange(kind) ? order_of(description, node_count) : 0;
  if (order > 0)
    build_lattice(description.corners, order);
  else {
    node_places_ = places_of_nodes(kind, corners_, count_);
    build_from_basis();
  }
  const bool is_tetrahedron = corners_ == CellKind::tetrahedron;
  is_quadratic_in_tetrahedra_ = is_tetrahedron && node_count == 10;
  const int degree = std::max(order, 2);
  degree_along_lines_ = is_quadratic_in_tetrahedra_ ? 2 : is_tetrahedron ? std::max(degree, 3) : 3 * degree;
}

void ShapeFunctions::build_lattice(CellKind corners, int order) {
  lattice_.order = order;
  const std::size_t count = lattice_size(corners, order);
  lattice_.nodes.resize(count);
  node_places_.resize(count);
  const auto set = [&](std::size_t index, const std::array<int, 6>& indices, const std::array<int, 3>& at) {
    std::transform(indices.begin(), indices.end(), lattice_.nodes[index].begin(),
                   [](int i) { return static_cast<std::uint8_t>(i); });
    for (std::size_t axis = 0; axis < 3; ++axis) node_places_[index][axis] = static_cast<double>(at[axis]) / order;
  };
  if (corners == CellKind::tetrahedron) {
    lattice_.coordinate_count = 4;
    std::size_t index = 0;
    for (const auto& [r, s, t, rest] : tetrahedron_nodes(order)) set(index++, {r, s, t, rest}, {r, s, t});
    return;
  }
  const bool is_wedge = corners == CellKind::wedge;
  lattice_.coordinate_count = is_wedge ? 5 : 6;
  for (int i = 0; i <= order; ++i)
    for (int j = 0; j <= (is_wedge ? order - i : order); ++j)
      for (int k = 0; k <= order; ++k) {
        if (is_wedge)
          set(wedge_index({i, j, k}, order), {i, j, order - i - j, k, order - k}, {i, j, k});
        else
          set(hexahedron_index({i, j, k}, order), {i, order - i, j, order - j, k, order - k}, {i, j, k});
      }
}

void ShapeFunctions::build_from_basis() {
  std::vector<double> values_at_nodes(count_ * count_);
  for (std::size_t node = 0; node < count_; ++node)
    basis_at(node_places_[node], std::span(values_at_nodes).subspan(node * count_, count_));
  const std::vector<double> inverse = inverse_of(std::move(values_at_nodes), count_);
  weights_from_basis_.resize(count_ * count_);
  for (std::size_t row = 0; row < count_; ++row)
    for (std::size_t column = 0; column < count_; ++column)
      weights_from_basis_[row * count_ + column] = inverse[column * count_ + row];
}

void ShapeFunctions::basis_at(const CellPlace& place, std::span<double> values) const {
  Values out(values);
  if (corners_ == CellKind::tetrahedron) tetrahedron_basis(place, count_, out);
  if (corners_ == CellKind::hexahedron) hexahedron_basis(place, count_, out);
  if (corners_ == CellKind::wedge) wedge_basis(place, count_, out);
  if (corners_ == CellKind::pyramid) pyramid_basis(place, count_, out);
  RHORAY_DCHECK(out.count() == count_);
}

void ShapeFunctions::at(const CellPlace& place, std::span<double> weights) const {
  // rounding of functions that are 0 there; a node without data must not count
  constexpr double nothing = 1e-13;
  const auto cleaned = [](double weight) { return std::abs(weight) < nothing ? 0 : weight; };
  if (lattice_.order == 0) {
    std::array<double, most_basis_functions> basis;
    basis_at(place, std::span(basis).first(count_));
    for (std::size_t node = 0; node < count_; ++node) {
      double sum = 0;
      for (std::size_t i = 0; i < count_; ++i) sum += weights_from_basis_[node * count_ + i] * basis[i];
      weights[node] = cleaned(sum);
    }
    return;
  }
  const auto [r, s, t] = place;
  std::array<double, 6> coordinates{r, 1 - r, s, 1 - s, t, 1 - t};
  if (corners_ == CellKind::tetrahedron) coordinates = {r, s, t, 1 - r - s - t, 0, 0};
  if (corners_ == CellKind::wedge) coordinates = {r, s, 1 - r - s, t, 1 - t, 0};
  std::array<std::array<double, highest_order + 1>, 6> silvester;
  for (std::size_t c = 0; c < lattice_.coordinate_count; ++c) {
    silvester[c][0] = 1;
    for (int i = 1; i <= lattice_.order; ++i) {
      const auto index = static_cast<std::size_t>(i);
      silvester[c][index] = silvester[c][index - 1] * (lattice_.order * coordinates[c] - (i - 1)) / i;
    }
  }
  for (std::size_t node = 0; node < lattice_.nodes.size(); ++node) {
    double product = 1;
    for (std::size_t c = 0; c < lattice_.coordinate_count; ++c) product *= silvester[c][lattice_.nodes[node][c]];
    weights[node] = cleaned(product);
  }
}

}  // namespace rhoray::preprocess
