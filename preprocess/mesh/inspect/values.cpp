#include <cmath>
#include <cstring>
#include <set>
#include <type_traits>

#include "formats/base/floating_point.h"
#include "formats/base/text.h"
#include "preprocess/mesh/inspect/finding.h"

namespace rhoray::preprocess {
namespace inspect {
namespace {

Finding values_without_data(const NeutralField& field, const std::string& owner) {
  const auto components = static_cast<std::size_t>(field.component_count);
  Tally tally;
  for (std::size_t i = 0; i < field.values.size(); i += components) {
    bool is_finite = true;
    for (std::size_t c = 0; c < components; ++c) is_finite = is_finite && std::isfinite(field.values[i + c]);
    if (!is_finite) tally.add(i / components);
  }
  return std::move(tally).finding(concat("values of '", field.name, "' that are not finite"), owner,
                                  "cells that touch them have no data and are not drawn");
}

}  // namespace

void values(const NeutralMesh& mesh, Findings& findings) {
  for (const NeutralField& field : mesh.point_fields) findings.push_back(values_without_data(field, "point"));
  for (const NeutralField& field : mesh.cell_fields) findings.push_back(values_without_data(field, "cell"));
}

}  // namespace inspect

namespace {

/// Few different whole numbers, none of them rare, are probably labels rather than a measured
/// field.
constexpr std::size_t most_labels = 64;

template <class T>
std::vector<Finding> look_at(const NeutralVolume& volume) {
  inspect::Tally not_finite;
  std::set<T> distinct;
  bool is_constant = true;
  T first{};
  for (std::size_t i = 0; i * sizeof(T) < volume.samples.size(); ++i) {
    T value;
    std::memcpy(&value, volume.samples.data() + i * sizeof(T), sizeof(T));
    if (i == 0) first = value;
    if constexpr (std::is_floating_point_v<T>)
      if (!std::isfinite(value)) {
        not_finite.add(i);
        continue;
      }
    is_constant = is_constant && value == first;
    if (std::is_integral_v<T> && distinct.size() <= most_labels) distinct.insert(value);
  }
  Finding constant{.name = "equal samples", .thing = "sample", .packing = "kept: no isovalue has a surface"};
  if (is_constant && !volume.samples.empty()) constant.count = volume.samples.size() / sizeof(T);
  Finding labels{.name = "different whole numbers, which look like labels",
                 .thing = "label",
                 .packing = "kept: values between two labels have no meaning; use isovalues at halves"};
  if (distinct.size() > 1 && distinct.size() <= most_labels) labels.count = distinct.size();
  return {std::move(not_finite)
              .finding("samples that are not finite", "sample", "cells that touch them have no data and are not drawn"),
          constant, labels};
}

}  // namespace

std::vector<Finding> inspect_volume(const NeutralVolume& volume) {
  const DefaultFloatingPoint default_floating_point;
  return formats::with_element_type(volume.type, [&]<class T>(T) { return look_at<T>(volume); });
}

}  // namespace rhoray::preprocess
