#include "tools/analysis/measure.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "formats/base/checks.h"
#include "formats/base/error.h"
#include "formats/base/text.h"

namespace rhoray::tools {

namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

std::string processor_name() {
  std::ifstream lines("/proc/cpuinfo");
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("model name"))
      if (const std::size_t at = line.find(": "); at != std::string::npos) return line.substr(at + 2);
  return "unknown";
}

}  // namespace

Usage usage_so_far() {
  rusage own{}, workers{};
  RHORAY_CHECK(::getrusage(RUSAGE_SELF, &own) == 0 && ::getrusage(RUSAGE_CHILDREN, &workers) == 0);
  const auto peak = [](const rusage& usage) { return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024; };
  return {
      .cpu_s = seconds(own.ru_utime) + seconds(own.ru_stime) + seconds(workers.ru_utime) + seconds(workers.ru_stime),
      .peak_bytes = peak(own),
      .worker_peak_bytes = peak(workers)};
}

std::uint64_t anonymous_bytes() {
  constexpr std::string_view name = "RssAnon:";
  std::ifstream lines("/proc/self/status");
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(name)) return std::stoull(line.substr(name.size())) * 1024;  // in kB
  throw Error(ErrorCode::unsupported, "/proc/self/status: no line 'RssAnon'; this system does not report memory use");
}

Machine this_machine() {
  Machine machine;
  machine.processor = processor_name();
  cpu_set_t cores;
  if (::sched_getaffinity(0, sizeof cores, &cores) == 0) machine.core_count = static_cast<unsigned>(CPU_COUNT(&cores));
  const long pages = ::sysconf(_SC_PHYS_PAGES), page_bytes = ::sysconf(_SC_PAGESIZE);
  if (pages > 0 && page_bytes > 0)
    machine.memory_bytes = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
  utsname system{};
  if (::uname(&system) == 0) machine.system = concat(system.sysname, " ", system.release);
  return machine;
}

Spread spread_of(std::vector<double> values) {
  RHORAY_CHECK(!values.empty());
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  const double median = values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
  return {median, values.front(), values.back()};
}
}  // namespace rhoray::tools
