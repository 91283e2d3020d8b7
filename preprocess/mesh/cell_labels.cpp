#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "formats/mesh_boundary.h"
#include "preprocess/labels.h"

namespace rhoray::preprocess {

namespace {

using formats::TetMesh;

/// A set of labels: bit i is the i-th.
using LabelBits = std::uint32_t;
static_assert(most_labels <= std::numeric_limits<LabelBits>::digits);

bool is_label(double value) {
  return value == std::floor(value) && value >= std::numeric_limits<int>::min() &&
         value <= std::numeric_limits<int>::max();
}

/// All values, ascending; none if one is no label or there are too many.
template <class T>
std::vector<int> values_of(std::span<const T> cells) {
  std::vector<int> values;
  for (const T cell : cells) {
    if (!is_label(static_cast<double>(cell))) return {};
    const int value = static_cast<int>(cell);
    const auto place = std::lower_bound(values.begin(), values.end(), value);
    if (place != values.end() && *place == value) continue;
    if (values.size() == most_labels) return {};
    values.insert(place, value);
  }
  return values;
}

/// Which labels share a point with which, and which labels have a face on the boundary.
struct Contacts {
  std::array<LabelBits, most_labels> touched{};
  LabelBits outermost = 0;
};

template <class T>
Contacts contacts_of(const TetMesh& mesh, std::span<const T> cells, const std::vector<int>& values) {
  const auto bit_of = [&](std::uint64_t cell) {
    const auto place = std::lower_bound(values.begin(), values.end(), static_cast<int>(cells[cell]));
    return LabelBits{1} << (place - values.begin());
  };
  std::vector<LabelBits> at_point(mesh.description().point_count);
  for (std::uint64_t cell = 0; cell < cells.size(); ++cell)
    for (const std::uint32_t point : mesh.cell(cell)) at_point[point] |= bit_of(cell);
  Contacts contacts;
  for (const LabelBits labels : at_point)
    for (LabelBits rest = labels; rest != 0 && std::popcount(labels) > 1; rest &= rest - 1)
      contacts.touched[static_cast<std::size_t>(std::countr_zero(rest))] |= labels;
  for (const std::uint64_t number : formats::boundary_faces(mesh))
    contacts.outermost |= bit_of(formats::face_of_number(number).cell);
  return contacts;
}

LabelBits touched_by(LabelBits labels, const Contacts& contacts) {
  LabelBits touched = 0;
  for (LabelBits rest = labels; rest != 0; rest &= rest - 1)
    touched |= contacts.touched[static_cast<std::size_t>(std::countr_zero(rest))];
  return touched;
}

/// The labels by their depth, the outermost first.
std::vector<LabelBits> layers_of(const Contacts& contacts) {
  std::vector<LabelBits> layers;
  LabelBits known = 0;
  for (LabelBits next = contacts.outermost; next != 0; next = touched_by(layers.back(), contacts) & ~known) {
    layers.push_back(next);
    known |= next;
  }
  return layers;
}

template <class T>
std::optional<std::vector<CellLabel>> labels_of(const TetMesh& mesh, std::span<const T> cells) {
  const std::vector<int> values = values_of(cells);
  if (values.size() < 2) return std::nullopt;
  std::vector<CellLabel> labels;
  for (const int value : values) labels.push_back({value});
  const Contacts contacts = contacts_of(mesh, cells, values);
  const std::vector<LabelBits> layers = layers_of(contacts);
  for (std::size_t depth = layers.size(); depth-- > 1;)
    for (std::size_t outer = 0; outer < labels.size(); ++outer) {
      if ((layers[depth - 1] >> outer & 1) == 0) continue;
      for (std::size_t inner = 0; inner < labels.size(); ++inner)
        if ((layers[depth] & contacts.touched[outer]) >> inner & 1)
          labels[outer].hidden_count = std::max(labels[outer].hidden_count, labels[inner].hidden_count + 1);
    }
  return labels;
}

}  // namespace

std::optional<std::vector<CellLabel>> find_labels(const TetMesh& mesh, std::size_t cell_field) {
  return mesh.description().cell_fields[cell_field].type == formats::ElementType::F32
             ? labels_of(mesh, mesh.cell_values<float>(cell_field))
             : labels_of(mesh, mesh.cell_values<double>(cell_field));
}

}  // namespace rhoray::preprocess
