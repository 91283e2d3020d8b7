#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/analysis/study.h"
#include "tools/rhoray/report.h"
#include "tools/rhoray/table.h"

namespace rhoray::tools {

/// What a column of the results means.
struct ResultColumn {
  const char* name;
  const char* unit;  ///< empty where there is none
  const char* meaning;
};
const std::vector<ResultColumn>& result_columns();

/// Where, from what and how far a study was made.
struct StudyContext {
  Json facts;                      ///< machine, compiler, commit, command, seed, ...
  std::string stage;               ///< how far the study has come, a sentence
  std::vector<std::string> notes;  ///< what was left out of the whole
};

/// A row as reports look at it.
struct ResultRow {
  const Measured* measured = nullptr;
  double cpu_ms = 0;             ///< median
  std::optional<double> kept{};  ///< error that 99 % of the pixels keep; nothing where rays were not asked
  bool is_on_front = false;      ///< no other row is both faster and closer
};

/// The rows of a layer that were measured.
std::vector<ResultRow> rows_of(const PassResult& result);

/// All layers' rows, in the columns above; rows that were left out too, with the reason.
Table table_of(const std::vector<const LayerStudy*>& layers, const StudyContext& context);

/// What a scientist may conclude, one sentence each.
std::vector<std::string> conclusions_of(const LayerStudy& layer);

inline constexpr const char* results_schema = "rhoray-accuracy 1";
Json results_json(const std::vector<const LayerStudy*>& layers, const StudyContext& context);

/// As `rounded`, but whole numbers below ten million in full: 1170, not 1.17e+03.
std::string short_number(double number, int digits);

std::string error_unit(const LayerStudy& layer);  ///< "cells", or the field's unit

}  // namespace rhoray::tools
