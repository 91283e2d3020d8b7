#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "formats/base/parallel.h"
#include "formats/base/stopping.h"
#include "formats/base/text.h"
#include "formats/format_error.h"
#include "formats/packed_file.h"

/// Checks of whole arrays that meshes run when they are opened.
namespace rhoray::formats::details {

// elements; a smaller scan finishes before another thread could start
inline constexpr std::uint64_t scan_piece = 1 << 18;

/// Finds the first bad element. It searches element by element only in a range in which
/// `is_bad(first, last)` is true.
/// @param array   its name
/// @param is_bad  true if a range contains a bad element; written to run at memory speed
template <class IsBad>
std::optional<std::uint64_t> first_bad(std::string_view array, std::uint64_t count, const Watch& watch, IsBad is_bad) {
  constexpr std::uint64_t chunk = 1 << 14;
  ProgressMeter meter(watch.progress, concat("checking ", array, " (elements)"), count);
  std::atomic<std::uint64_t> worst{count};
  for_each_range(count, scan_piece, 0, [&](std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t at = first; at < last; at += chunk) {
      end_if_stopped(watch.stop);
      const std::uint64_t end = std::min(at + chunk, last);
      meter.add(end - at);
      if (!is_bad(at, end)) continue;
      std::uint64_t element = at;
      while (!is_bad(element, element + 1)) ++element;
      std::uint64_t known = worst;
      while (element < known && !worst.compare_exchange_weak(known, element)) {
      }
      return;
    }
  });
  return worst == count ? std::nullopt : std::optional(worst.load());
}

inline void check_below(const PackedFile& file, std::string_view array, std::span<const std::uint32_t> indices,
                        std::uint64_t limit, const Watch& watch) {
  const auto is_bad = [&](std::uint64_t first, std::uint64_t last) {
    std::uint32_t largest = 0;
    for (std::uint64_t i = first; i < last; ++i) largest = std::max(largest, indices[i]);
    return largest >= limit;
  };
  if (const auto bad = first_bad(array, indices.size(), watch, is_bad))
    refuse(file.name(), concat("array '", array, "', element ", *bad), concat(indices[*bad]),
           concat("an index below ", limit));
}

/// Checks that numbers rise and stay below a limit.
inline void check_rising(const PackedFile& file, std::string_view array, std::span<const std::uint64_t> numbers,
                         std::uint64_t limit, const Watch& watch) {
  const auto is_bad = [&](std::uint64_t first, std::uint64_t last) {
    std::uint64_t bad = 0;
    for (std::uint64_t i = first; i < last; ++i)
      bad += numbers[i] >= limit || (i > 0 && numbers[i] <= numbers[i - 1]) ? 1 : 0;
    return bad != 0;
  };
  if (const auto bad = first_bad(array, numbers.size(), watch, is_bad))
    refuse(file.name(), concat("array '", array, "', element ", *bad), concat(numbers[*bad]),
           concat("a number below ", limit, *bad > 0 ? concat(", above ", numbers[*bad - 1]) : ""));
}

template <class T>
void check_finite(const PackedFile& file, std::string_view array, std::span<const T> numbers, const Watch& watch) {
  const auto is_bad = [&](std::uint64_t first, std::uint64_t last) {
    std::uint64_t bad = 0;
    for (std::uint64_t i = first; i < last; ++i)  // written so that a NaN also counts
      bad += std::abs(numbers[i]) <= std::numeric_limits<T>::max() ? 0 : 1;
    return bad != 0;
  };
  if (const auto bad = first_bad(array, numbers.size(), watch, is_bad))
    refuse(file.name(), concat("array '", array, "', element ", *bad), concat(numbers[*bad]), "a finite number");
}

/// Views groups of `size` consecutive numbers as one element each.
template <std::size_t size, class T>
std::span<const std::array<T, size>> grouped(std::span<const T> numbers) {
  static_assert(sizeof(std::array<T, size>) == size * sizeof(T));
  return {reinterpret_cast<const std::array<T, size>*>(numbers.data()), numbers.size() / size};
}

}  // namespace rhoray::formats::details
