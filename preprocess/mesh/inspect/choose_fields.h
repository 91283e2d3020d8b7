#pragma once

#include <string>
#include <variant>
#include <vector>

#include "preprocess/mesh/inspect/clean_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A scalar at every point of a clean mesh.
struct PointField {
  std::string name;
  std::string unit;
  std::variant<Array<float>, Array<double>> values;
};

/// Returns the scalars that `wanted` names (PackMeshOptions::fields). By default these are all
/// scalar point fields and the magnitudes of vectors, and with `cells_to_points` those of cell
/// fields too. Components are counted from 0; x, y, z stand for 0, 1, 2 of vectors with two or
/// three components.
///
/// A cell field's value at a point is the mean over the cells around it, weighted by their volumes.
/// Where these are all flat, it is the plain mean; where none has data, it is NaN. Components and
/// magnitudes are taken before the mean. The mean never leaves the range of the values that it is
/// made from.
///
/// Values are single precision where the source was (derived values, magnitudes and means, are
/// rounded to it), else double. A point field has priority over a cell field of the same name,
/// which is left out with a note.
///
/// Refuses with ErrorCode::usage: an unknown name (the message gives the existing names and the
/// nearest one), a name given twice, a vector without a component. Refuses with ErrorCode::invalid:
/// a mesh without usable fields, or a field with too few or too many values.
std::vector<PointField> choose_fields(const NeutralMesh& mesh, const CleanMesh& clean,
                                      const std::vector<std::string>& wanted, bool cells_to_points,
                                      const std::string& source_name, std::vector<std::string>& notes);

}  // namespace rhoray::preprocess
