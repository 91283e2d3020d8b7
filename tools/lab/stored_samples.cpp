#include "tools/lab/stored_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "formats/base/checks.h"
#include "formats/base/parallel.h"

namespace rhoray::study {

namespace {

using formats::ElementType;

// Packed files hold no half: its values are stored in single precision.
constexpr Storage all_storages[] = {{"double", 64, ElementType::F64, false}, {"float", 32, ElementType::F32, false},
                                    {"half", 16, ElementType::F32, false},   {"16 bits", 16, ElementType::U16, true},
                                    {"12 bits", 12, ElementType::U16, true}, {"10 bits", 10, ElementType::U16, true},
                                    {"8 bits", 8, ElementType::U8, true}};

bool is_floating(ElementType type) {
  return type == ElementType::F32 || type == ElementType::F64;
}

/// Whether every value of a type is one of the storage's.
bool holds_all(const Storage& storage, ElementType type) {
  const int bits = 8 * static_cast<int>(formats::element_bytes(type));
  if (is_floating(type)) return !storage.is_whole && storage.bits >= bits;
  return storage.is_whole ? storage.bits >= bits : storage.bits > bits;
}

}  // namespace

double rounded_to_half(double value) {
  int exponent = 0;
  std::frexp(value, &exponent);
  // 11 significant bits. Below the smallest normal number, 2^-14, the steps remain those of that
  // number.
  const int step_exponent = std::max(exponent, -13) - 11;
  const double nearest = std::ldexp(std::nearbyint(std::ldexp(value, -step_exponent)), step_exponent);
  constexpr double largest = 65504;
  return std::abs(nearest) <= largest ? nearest : std::copysign(std::numeric_limits<double>::infinity(), value);
}

std::span<const Storage> storages() {
  return all_storages;
}

std::optional<StoredSamples> stored_as(const Storage& storage, const preprocess::NeutralVolume& grid,
                                       const Interval<double>& range) {
  if (holds_all(storage, grid.type)) return std::nullopt;
  RHORAY_CHECK(range.hi > range.lo);
  StoredSamples stored;
  if (storage.is_whole) stored.scale = (std::exp2(storage.bits) - 1) / (range.hi - range.lo), stored.offset = range.lo;
  preprocess::NeutralVolume& out = stored.volume;
  out.sample_count = grid.sample_count;
  out.type = storage.type;
  out.field_name = grid.field_name;
  out.world_from_grid = grid.world_from_grid;
  const auto count = static_cast<std::size_t>(volume(grid.sample_count));
  const bool is_half = !storage.is_whole && storage.bits == 16;
  formats::with_element_type(grid.type, [&]<class From>(From) {
    formats::with_element_type(storage.type, [&]<class To>(To) {
      out.owned_samples.resize(count * sizeof(To));
      const From* const from = reinterpret_cast<const From*>(grid.samples.data());
      To* const to = reinterpret_cast<To*>(out.owned_samples.data());
      parallel_for(count, 1 << 14, [&](const IndexRange& part) {
        for (std::size_t s = part.begin(); s < part.end(); ++s) {
          const double value = static_cast<double>(from[s]);
          if constexpr (std::is_floating_point_v<To>)
            to[s] = static_cast<To>(is_half ? rounded_to_half(value) : value);
          else
            to[s] = static_cast<To>(std::lround(stored.own(value)));
        }
      });
    });
  });
  out.samples = out.owned_samples;
  return stored;
}

}  // namespace rhoray::study
