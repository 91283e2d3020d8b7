#include "preprocess/grid/bricks/convert.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "formats/base/error.h"
#include "formats/base/parallel.h"

namespace rhoray::preprocess {
namespace {

/// True when the number lies within the integer type; false for NaN.
template <class Integer, class Real>
bool in_range_of(Real value) {
  // the largest integer + 1, exactly
  const Real above = std::ldexp(Real{1}, std::numeric_limits<Integer>::digits);
  return value >= static_cast<Real>(std::numeric_limits<Integer>::lowest()) && value < above;
}

template <class To, class From>
std::optional<To> same_number(From value) {
  if constexpr (std::is_integral_v<From> && std::is_integral_v<To>) {
    if (!std::in_range<To>(value)) return std::nullopt;
    return static_cast<To>(value);
  } else if constexpr (std::is_integral_v<To>) {
    // NaN fails the first
    if (!in_range_of<To>(value) || std::trunc(value) != value) return std::nullopt;
    return static_cast<To>(value);
  } else if constexpr (std::is_integral_v<From>) {
    const To converted = static_cast<To>(value);
    if (!in_range_of<From>(converted) || static_cast<From>(converted) != value) return std::nullopt;
    return converted;
  } else {
    if (std::isnan(value)) return std::numeric_limits<To>::quiet_NaN();
    if (std::isfinite(value) && std::abs(value) > static_cast<double>(std::numeric_limits<To>::max()))
      return std::nullopt;
    const To converted = static_cast<To>(value);
    if (static_cast<From>(converted) != value) return std::nullopt;
    return converted;
  }
}

constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

/// Converts all samples and returns the index of the first that changes, or `none`.
template <class To, class From>
std::size_t convert(std::span<const From> from, To* to) {
  return parallel_reduce(
      from.size(), 1 << 16, none,
      [&](const IndexRange& part) {
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
          const std::optional<To> converted = same_number<To>(from[i]);
          if (!converted) return i;
          to[i] = *converted;
        }
        return none;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

template <class From>
[[noreturn]] void refuse_sample(const NeutralVolume& volume, std::size_t at, From value, formats::ElementType type,
                                const std::string& source_name) {
  const auto nx = static_cast<std::size_t>(volume.sample_count.x), ny = static_cast<std::size_t>(volume.sample_count.y);
  throw Error(ErrorCode::invalid,
              concat(source_name, ", sample (", at % nx, ", ", at / nx % ny, ", ", at / nx / ny, "): found ", value,
                     "; expected a number that ", formats::element_name(type), " holds exactly"),
              "choose a type that holds every value, or keep the source's own");
}

}  // namespace

void convert_samples(NeutralVolume& volume, formats::ElementType type, const std::string& source_name) {
  if (volume.type == type) return;
  const std::size_t count = volume.samples.size() / formats::element_bytes(volume.type);
  Array<std::byte> converted(count * formats::element_bytes(type));
  formats::with_element_type(volume.type, [&]<class From>(From) {
    formats::with_element_type(type, [&]<class To>(To) {
      const std::span from(reinterpret_cast<const From*>(volume.samples.data()), count);
      const std::size_t lost = convert<To>(from, reinterpret_cast<To*>(converted.data()));
      if (lost != none) refuse_sample(volume, lost, from[lost], type, source_name);
    });
  });
  volume.type = type;
  volume.owned_samples = std::move(converted);
  volume.mapping.reset();
  volume.samples = volume.owned_samples;
}

void align_samples(NeutralVolume& volume) {
  if (std::bit_cast<std::uintptr_t>(volume.samples.data()) % formats::element_bytes(volume.type) == 0) return;
  Array<std::byte> copy(volume.samples.begin(), volume.samples.end());
  volume.owned_samples = std::move(copy);
  volume.mapping.reset();
  volume.samples = volume.owned_samples;
}

}  // namespace rhoray::preprocess
