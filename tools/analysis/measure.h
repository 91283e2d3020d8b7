#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace rhoray::tools {

/// Elapsed time.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Resources used so far by this process and by the workers it has waited for.
struct Usage {
  double cpu_s = 0;                     ///< user and system, all threads, workers included
  std::uint64_t peak_bytes = 0;         ///< largest resident set of this process
  std::uint64_t worker_peak_bytes = 0;  ///< largest resident set of any one worker; 0 when there was none
};
Usage usage_so_far();

/// Memory of this process that does not belong to a mapped file: heap, stacks, buffers of
/// libraries.
std::uint64_t anonymous_bytes();

/// The machine of a measurement.
struct Machine {
  std::string processor;           ///< as the system names it
  unsigned core_count = 0;         ///< that this process may run on
  std::uint64_t memory_bytes = 0;  ///< of the whole machine
  std::string system;              ///< kernel and its release
};
Machine this_machine();

/// Median and spread of repeated measurements.
struct Spread {
  double median = 0;
  double smallest = 0;
  double largest = 0;
};
/// @param values  at least one
Spread spread_of(std::vector<double> values);
}  // namespace rhoray::tools
