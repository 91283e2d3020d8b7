#pragma once

#include <string>
#include <vector>

#include "formats/base/json.h"
#include "render/accuracy.h"
#include "tools/rhoray/cli/options.h"

namespace rhoray::tools {

std::vector<Option> goal_options(render::Goal& goal);               ///< --max-error, --budget-ms
std::vector<Option> self_check_options(render::SelfCheckOptions&);  ///< --verify, --verify-limit, --verify-seed

// Refuse numbers that are not above 0, and a limit without a check (ErrorCode::usage).
void require_valid(const render::Goal& goal);
void require_valid(const render::SelfCheckOptions& options);

/// Refuses scenes whose pictures cannot be checked (ErrorCode::usage).
void require_checkable(const render::ResolvedScene& resolved);

std::string text_of(const render::SelfCheck& check);
Json json_of(const render::SelfCheck& check);

}  // namespace rhoray::tools
