#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace rhoray::preprocess {

/// The time step that a request selects (ImportMeshOptions::time): "first", "last", "#N" counted
/// from 0, or a time, which selects the nearest step. An empty request selects the last step. A
/// note names the selected step unless it is the file's only one or exactly the requested one.
/// @param times  of the steps, at least one; NaN for a step without a time
std::size_t choose_time_step(std::span<const double> times, const std::string& request,
                             const std::filesystem::path& path, std::vector<std::string>& notes);

/// Refuses a request for a time step in a file without time steps.
void refuse_time_step(const std::string& request, const std::filesystem::path& path);

}  // namespace rhoray::preprocess
