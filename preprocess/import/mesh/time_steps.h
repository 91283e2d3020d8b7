#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace rhoray::preprocess {

/// Which of a file's time steps a request names (ImportMeshOptions::time): "first", "last", "#N"
/// counted from 0, or a time, of which the nearest is taken. An empty request takes the last. A
/// note says which one was taken whenever that was not the file's only one or not exactly what was
/// asked for.
/// @param times  of the steps, at least one; NaN where a step has none
std::size_t choose_time_step(std::span<const double> times, const std::string& request,
                             const std::filesystem::path& path, std::vector<std::string>& notes);

/// Refuses a request for a time step where there are none.
void refuse_time_step(const std::string& request, const std::filesystem::path& path);

}  // namespace rhoray::preprocess
