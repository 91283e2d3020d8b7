#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "preprocess/mesh/inspect/clean_mesh.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// A scalar at every point or every cell of a clean mesh.
struct ScalarField {
  std::string name;
  std::string unit;
  std::variant<Array<float>, Array<double>> values;
  formats::LabelNames label_names{};
};

/// The number of values that are NaN or infinite.
std::uint64_t no_data_count(const ScalarField& field);

/// Adds a note on a point field without data at `count` points, if there are some.
/// @param consequence  for the adjacent cells: "are not drawn"
void note_no_data(const std::string& field, std::uint64_t count, std::string_view consequence,
                  std::vector<std::string>& notes);

struct ChosenFields {
  std::vector<ScalarField> of_points;
  std::vector<ScalarField> of_cells;
};

/// Returns the scalars that `wanted` names (PackMeshOptions::fields). By default these are the
/// default scalars (components.h) of all fields, of points and of cells, in the source's order.
/// However, fields without variation, ids and masks of programs come last: the first field is the
/// one that pictures show. A note says when it is a magnitude.
///
/// With `cells_to_points` each chosen cell field is there at the points, too. Its value at a point
/// is the mean over the source's cells around it that have data, or NaN where none has. Where all
/// have data, this is the mean that vtkCellDataToPointData computes. Tetrahedra cut from one cell
/// count once. Components and magnitudes are taken before the mean. A note says how the range
/// changes.
///
/// Values are single precision where the source was (derived values, magnitudes and means, are
/// rounded to it), else double. A cell field with the name of a point field gets ".cells" behind
/// its name, with a note.
///
/// Refuses with ErrorCode::usage: an unknown name (the message gives the existing names and the
/// nearest one), a name given twice, an array of several components without a choice. Refuses with
/// ErrorCode::invalid: a mesh without usable fields at points, or a field with too few or too many
/// values.
ChosenFields choose_fields(const NeutralMesh& mesh, const CleanMesh& clean, const std::vector<std::string>& wanted,
                           bool cells_to_points, const std::string& source_name, std::vector<std::string>& notes);

}  // namespace rhoray::preprocess
