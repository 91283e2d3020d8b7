#include "tools/analysis/cpu_meter.h"

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>

namespace rhoray::tools {

namespace {

/// A descriptor, or a negative number where the system or the machine offers no such counter.
int open_counter(std::uint64_t what) {
  perf_event_attr attributes{};
  attributes.size = sizeof attributes;
  attributes.type = PERF_TYPE_HARDWARE;
  attributes.config = what;
  attributes.inherit = 1;
  attributes.exclude_kernel = 1;
  attributes.exclude_hv = 1;
  return static_cast<int>(::syscall(SYS_perf_event_open, &attributes, 0, -1, -1, PERF_FLAG_FD_CLOEXEC));
}

std::uint64_t count_of(int descriptor) {
  std::uint64_t count = 0;
  if (descriptor < 0 || ::read(descriptor, &count, sizeof count) != sizeof count) return 0;
  return count;
}

double cpu_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

CpuMeter::CpuMeter()
    : cycles_(open_counter(PERF_COUNT_HW_CPU_CYCLES)), instructions_(open_counter(PERF_COUNT_HW_INSTRUCTIONS)) {}

CpuMeter::~CpuMeter() {
  for (const int descriptor : {cycles_, instructions_})
    if (descriptor >= 0) ::close(descriptor);
}

CpuMeter::Reading CpuMeter::read() const {
  return {cpu_seconds(), count_of(cycles_), count_of(instructions_)};
}

Cost CpuMeter::difference(const Reading& before, const Reading& after) const {
  Cost cost{.cpu_s = after.cpu_s - before.cpu_s, .cycles = {}, .instructions = {}};
  if (counts_cycles()) cost.cycles = static_cast<double>(after.cycles - before.cycles);
  if (counts_instructions()) cost.instructions = static_cast<double>(after.instructions - before.instructions);
  return cost;
}

double core_frequency_hz() {
  // A multiplication that waits for the one before takes three cycles on the x86-64 processors of
  // many years; additions would not do, since some processors fold several into one.
  constexpr int chains = 8, steps = 40'000, multiplications_per_step = 10, cycles_per_multiplication = 3;
  double fastest = 0;
  // The fastest of several, since whatever comes in between only takes time.
  for (int chain = 0; chain < chains; ++chain) {
    std::uint64_t product = 3;
    const double start = cpu_seconds();
    for (int step = 0; step < steps; ++step)
      asm volatile(
          "imul %0, %0\n imul %0, %0\n imul %0, %0\n imul %0, %0\n imul %0, %0\n"
          "imul %0, %0\n imul %0, %0\n imul %0, %0\n imul %0, %0\n imul %0, %0\n"
          : "+r"(product));
    const double taken = cpu_seconds() - start;
    constexpr double cycles = double{steps} * multiplications_per_step * cycles_per_multiplication;
    if (taken > 0) fastest = std::max(fastest, cycles / taken);
  }
  return fastest;
}

}  // namespace rhoray::tools
