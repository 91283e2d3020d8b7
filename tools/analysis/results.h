#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/analysis/study.h"
#include "tools/analysis/table.h"

namespace rhoray::tools {

/// A value of the results, and the meaning of its column.
struct ResultCell {
  std::string name;
  const char* unit;  ///< empty: none
  const char* meaning;
  Json value;
};
const std::vector<ResultCell>& result_columns();  ///< without values

/// Environment, input and progress of a study.
struct StudyContext {
  Json facts;                      ///< machine, compiler, commit, command, seed, ...
  std::string stage;               ///< progress of the study, a sentence
  std::vector<std::string> notes;  ///< what was omitted from the whole
};

/// A row as used in reports.
struct ResultRow {
  const Measured* measured = nullptr;
  double cpu_ms = 0;  ///< median
  /// Error that 99 % of the pixels do not exceed; nothing where no rays were traced.
  std::optional<double> kept{};
  bool is_on_front = false;  ///< no other row is both faster and closer
};

/// The measured rows of a layer.
std::vector<ResultRow> rows_of(const PassResult& result);

/// A layer's rows in the columns above, one for each of PassResult::rows.
std::vector<Json> rows_json(const LayerStudy& layer);
/// All layers' rows in the columns above, including rows that were left out, with the reason.
Table table_of(const std::vector<const LayerStudy*>& layers, const StudyContext& context);

/// Conclusions for scientists, one sentence each.
std::vector<std::string> conclusions_of(const LayerStudy& layer);

/// One sentence on the default method: wrong pixels, and errors in the field's unit. Empty where it
/// was not measured.
std::string verdict_of(const LayerStudy& layer);

inline constexpr const char* results_schema = "rhoray-accuracy 1";
Json results_json(const std::vector<const LayerStudy*>& layers, const StudyContext& context);

std::string error_unit(const LayerStudy& layer);  ///< "cells", or the field's unit

}  // namespace rhoray::tools
