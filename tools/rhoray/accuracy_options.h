#pragma once

#include <string>
#include <vector>

#include "formats/base/json.h"
#include "tools/analysis/accuracy.h"
#include "tools/rhoray/option_values.h"

namespace rhoray::tools {

std::vector<Option> goal_options(Goal& goal);               ///< --max-error, --budget-ms
std::vector<Option> self_check_options(SelfCheckOptions&);  ///< --verify, --verify-limit, --verify-seed

// Refuse numbers that are not above 0, and a limit without a check (ErrorCode::usage).
void check(const Goal& goal);
void check(const SelfCheckOptions& options);

/// Refuses scenes whose pictures cannot be checked (ErrorCode::usage).
void require_checkable(const render::ResolvedScene& resolved);

std::string text_of(const SelfCheck& check);
Json json_of(const SelfCheck& check);

}  // namespace rhoray::tools
