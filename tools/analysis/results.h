#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/analysis/study.h"
#include "tools/analysis/table.h"

namespace rhoray::tools {

/// Meaning of a column of the results.
struct ResultColumn {
  const char* name;
  const char* unit;  ///< empty: none
  const char* meaning;
};
const std::vector<ResultColumn>& result_columns();

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

/// All layers' rows in the columns above, including rows that were left out, with the reason.
Table table_of(const std::vector<const LayerStudy*>& layers, const StudyContext& context);

/// Conclusions for scientists, one sentence each.
std::vector<std::string> conclusions_of(const LayerStudy& layer);

inline constexpr const char* results_schema = "rhoray-accuracy 1";
Json results_json(const std::vector<const LayerStudy*>& layers, const StudyContext& context);

/// Like `rounded`, but whole numbers below ten million in full: 1170, not 1.17e+03.
std::string short_number(double number, int digits);

std::string error_unit(const LayerStudy& layer);  ///< "cells", or the field's unit

}  // namespace rhoray::tools
