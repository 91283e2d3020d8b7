#pragma once

#include <span>
#include <string>
#include <vector>

#include "preprocess/repair_surface.h"

namespace rhoray::preprocess::repair {

/// The options that the worker needs, as its command line, and back. Numbers keep every bit.
std::vector<std::string> arguments_of(const RepairOptions& options);
RepairOptions options_from(std::span<const char* const> arguments);

/// The report as one text, for the way back from the worker (it travels as the last note of the
/// surface), and back.
std::string text_of(const RepairReport& report);
RepairReport report_from(const std::string& text);

/// A number for a sentence, with three significant digits.
std::string rounded(double number);

/// What was done, one sentence each.
std::vector<std::string> sentences(const RepairReport& report);

}  // namespace rhoray::preprocess::repair
