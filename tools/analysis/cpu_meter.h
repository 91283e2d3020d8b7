#pragma once

#include <cstdint>
#include <optional>

namespace rhoray::tools {

/// The cost of some work: CPU time of all threads of this process, and the processor's counters in
/// user mode.
struct Cost {
  double cpu_s = 0;
  std::optional<double> cycles;        ///< core cycles; nothing where the system offers no such counter
  std::optional<double> instructions;  ///< retired; nothing where the system offers no such counter
};

/// Measures work of the calling thread, and of threads that start while it is measured.
class CpuMeter {
 public:
  CpuMeter();
  CpuMeter(const CpuMeter&) = delete;
  CpuMeter& operator=(const CpuMeter&) = delete;
  ~CpuMeter();

  bool counts_cycles() const { return cycles_ >= 0; }
  bool counts_instructions() const { return instructions_ >= 0; }

  template <class Act>
  Cost measure(Act&& act) {
    const Reading before = read();
    act();
    return difference(before, read());
  }

 private:
  struct Reading {
    double cpu_s;
    std::uint64_t cycles, instructions;
  };
  Reading read() const;
  Cost difference(const Reading& before, const Reading& after) const;

  int cycles_, instructions_;  ///< descriptors; negative where there is no counter
};

/// Core cycles per second of CPU time, now: from a chain of
/// multiplications that take three cycles each. Takes a few milliseconds.
double core_frequency_hz();

}  // namespace rhoray::tools
