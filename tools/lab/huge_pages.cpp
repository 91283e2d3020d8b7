#include "tools/lab/huge_pages.h"

#include <sys/mman.h>

#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>

#include "formats/base/error.h"

namespace rhoray::study {

namespace {

constexpr std::size_t huge_page = std::size_t{2} << 20;

struct Range {
  std::uintptr_t begin = 0, end = 0;

  std::size_t size() const { return end - begin; }
};

/// Reads "7f00-7fff ...", the format in which lines of mappings begin in /proc/self/maps and smaps.
bool read_range(const std::string& line, Range& out) {
  const char* const last = line.data() + line.size();
  const auto [dash, error] = std::from_chars(line.data(), last, out.begin, 16);
  if (error != std::errc{} || dash == last || *dash != '-') return false;
  return std::from_chars(dash + 1, last, out.end, 16).ec == std::errc{};
}

Range mapping_around(std::uintptr_t address) {
  std::ifstream lines("/proc/self/maps");
  Range range;
  for (std::string line; std::getline(lines, line);)
    if (read_range(line, range) && range.begin <= address && address < range.end) return range;
  throw Error(ErrorCode::internal, "huge pages: the bytes are in no mapping");
}

std::size_t huge_bytes_in(const Range& wanted) {
  std::ifstream lines("/proc/self/smaps");
  Range range;
  std::size_t kibibytes = 0;
  bool is_within = false;
  for (std::string line; std::getline(lines, line);) {
    if (read_range(line, range)) is_within = range.begin >= wanted.begin && range.end <= wanted.end;
    if (is_within && line.starts_with("AnonHugePages:")) kibibytes += std::stoul(line.substr(14));
  }
  return kibibytes * 1024;
}

}  // namespace

std::size_t move_to_huge_pages(std::span<const std::byte> bytes) {
  const Range range = mapping_around(reinterpret_cast<std::uintptr_t>(bytes.data()));
  // The copy's first address has the same offset in a huge page as its final address, so that whole
  // pages move.
  void* const spare = ::mmap(nullptr, range.size() + huge_page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (spare == MAP_FAILED) throw Error(ErrorCode::resource, "huge pages: no addresses left");
  const auto first = reinterpret_cast<std::uintptr_t>(spare);
  const std::uintptr_t start = first + (range.begin - first) % huge_page;
  void* const copy = reinterpret_cast<void*>(start);
  void* const place = reinterpret_cast<void*>(range.begin);
  if (::mprotect(copy, range.size(), PROT_READ | PROT_WRITE) != 0 || ::madvise(copy, range.size(), MADV_HUGEPAGE) != 0)
    throw Error(ErrorCode::resource, "huge pages: the system does not offer them");
  std::memcpy(copy, place, range.size());
  if (::mprotect(copy, range.size(), PROT_READ) != 0 ||
      ::mremap(copy, range.size(), range.size(), MREMAP_MAYMOVE | MREMAP_FIXED, place) == MAP_FAILED)
    throw Error(ErrorCode::resource, "huge pages: the copy could not be put in place");
  if (start > first) ::munmap(spare, start - first);
  ::munmap(reinterpret_cast<void*>(start + range.size()), first + huge_page - start);
  return huge_bytes_in(range);
}

}  // namespace rhoray::study
