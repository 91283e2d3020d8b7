#pragma once

#include <cstring>
#include <stdexcept>
#include <string>

#include "formats/packed_file.h"
#include "tests/support/memory_file.h"
#include "tests/support/resealed.h"

/// Packed files with valid checksums whose stored ranges and boxes are too narrow.
namespace rhoray::tests {

/// Storage of intervals in an array: `step` lower bounds, then the `step` upper bounds of the same
/// intervals, and so on.
enum class IntervalStep : std::size_t {
  macro_levels = 1,    ///< "macro.1", "range.0.1" over leaf cells: [lo, hi] each
  cluster_ranges = 8,  ///< "range.0.1" over clusters: eight lo, eight hi
  cluster_boxes = 24,  ///< "cluster.boxes.1": eight lo of x, y and z, then the same for hi
};

/// The file with intervals of an array narrowed to their lowest value: the first non-empty one, or
/// all.
inline std::string narrowed(const std::string& file, const std::string& array, IntervalStep pairs, bool all = false) {
  const MemoryFile memory(file);
  const auto packed = formats::PackedFile::from_descriptor(memory.descriptor(), "narrowed.rho");
  const formats::ArrayEntry& entry = packed.entry(array);
  std::string bytes(reinterpret_cast<const char*>(packed.bytes(array).data()), entry.byte_count);
  std::size_t changed = 0;
  formats::with_element_type(entry.type, [&](auto zero) {
    using T = decltype(zero);
    const auto step = static_cast<std::size_t>(pairs);
    const auto place = [&](std::size_t element) { return bytes.data() + element * sizeof(T); };
    for (std::size_t n = 0; n < entry.element_count() / 2 && (all || changed == 0); ++n) {
      const std::size_t at = n / step * 2 * step + n % step;
      T lo, hi;
      std::memcpy(&lo, place(at), sizeof lo);
      std::memcpy(&hi, place(at + step), sizeof hi);
      if (!(lo < hi)) continue;
      std::memcpy(place(at + step), &lo, sizeof lo);
      ++changed;
    }
  });
  if (changed == 0) throw std::runtime_error("nothing to narrow in " + array);
  std::uint64_t text_bytes = 0;
  std::memcpy(&text_bytes, file.data(), 8);
  return with_data_change(file, entry.first_byte - 8 - text_bytes, bytes);
}

}  // namespace rhoray::tests
