#include "preprocess/export/lost_facts.h"

#include "formats/base/text.h"

namespace rhoray::preprocess {
namespace {

/// Adds the notes on one format.
struct LostFacts {
  const StoredFacts& stored;
  std::vector<std::string>& notes;

  void add(const std::string& fact) const {
    notes.push_back(concat("the ", stored.extension, " file does not store ", fact));
  }

  void check_lengths(const std::string& unit) const {
    if (!unit.empty() && !stored.length_unit) add(concat("the unit ", unit, " of lengths"));
  }

  void check_space(formats::Space space) const {
    if (space != formats::Space::unknown && !stored.space)
      add(concat("the space ", formats::space_word(space), " of its coordinates"));
  }

  void check_field(const formats::FieldSummary& field) const {
    if (!field.unit.empty() && !stored.field_unit) add(concat("the unit ", field.unit, " of field '", field.name, "'"));
    if (!field.label_names.empty() && !stored.label_names)
      add(concat("the names of the labels of field '", field.name, "'"));
  }
};

}  // namespace

void note_lost_facts(const OpenedGrid& opened, const std::string& field, const StoredFacts& stored,
                     std::vector<std::string>& notes) {
  const formats::GridDescription& grid = opened.description();
  const LostFacts lost{stored, notes};
  lost.check_lengths(grid.length_unit);
  lost.check_space(grid.space);
  if (!stored.fields) return;
  if (stored.several_fields && field.empty()) {
    for (const formats::FieldSummary& each : grid.fields) lost.check_field(each);
    return;
  }
  lost.check_field(opened.summary());
  if (field.empty() && grid.fields.size() > 1)
    notes.push_back(concat("a ", stored.extension, " file holds one field, and '", opened.summary().name,
                           "' is written; choose another with --field"));
}

void note_lost_facts(const formats::TetMeshDescription& mesh, const StoredFacts& stored,
                     std::vector<std::string>& notes) {
  const LostFacts lost{stored, notes};
  lost.check_lengths(mesh.length_unit);
  if (!stored.fields) return;
  for (const auto* fields : {&mesh.fields, &mesh.cell_fields})
    for (const formats::FieldSummary& each : *fields) lost.check_field(each);
}

}  // namespace rhoray::preprocess
