#pragma once

#include <array>
#include <type_traits>

#include "formats/base/checks.h"
#include "formats/base/interval.h"
#include "formats/file_description.h"
#include "formats/macro_levels.h"

namespace rhoray::formats {

/// True for the types of numbers that a double holds exactly: all but integers of 64 bits.
template <class T>
inline constexpr bool is_exact_as_double = std::is_floating_point_v<T> || sizeof(T) < 8;

/// Calls act(T{}) for the type T that an ElementType stands for; it must be exact as a double.
template <class Act>
RHORAY_INLINE decltype(auto) with_exact_type(ElementType type, Act&& act) {
  return with_element_type(type, [&]<class T>(T) -> decltype(auto) {
    using Exact = std::conditional_t<is_exact_as_double<T>, T, double>;
    RHORAY_DCHECK(is_exact_as_double<T>);
    return act(Exact{});
  });
}

/// The smallest and largest value of every macrocell (MacroLevelsView), for values of any type that
/// is exact as a double. The arrays must outlive this.
class MacroRanges {
 public:
  /// The ranges of one level: [z, y, x, 2], lo before hi, in the type of the values.
  struct Level {
    const void* ranges = nullptr;
    Index3 count{0, 0, 0};
  };

  MacroRanges() = default;
  template <class T>
  MacroRanges(const MacroLevelsView<T>& levels) : shape_(levels.shape), type_(element_type_of<T>()) {
    for (int level = levels.first_level; level <= shape_.level_count; ++level)
      levels_[static_cast<std::size_t>(level)] = {
          levels.ranges[static_cast<std::size_t>(level - levels.first_level)].data(), shape_.count(level)};
  }

  const MacroShape& shape() const { return shape_; }
  ElementType type() const { return type_; }
  const Level& level(int level) const { return levels_[static_cast<std::size_t>(level)]; }

  /// Empty where no cell has data.
  Interval<double> range(int level, const Index3& cell) const {
    const Level& at = levels_[static_cast<std::size_t>(level)];
    const std::int64_t place = 2 * ((cell.z * at.count.y + cell.y) * at.count.x + cell.x);
    return with_exact_type(type_, [&]<class T>(T) -> Interval<double> {
      const T* range = static_cast<const T*>(at.ranges) + place;
      if (range[0] > range[1]) return {};
      return {static_cast<double>(range[0]), static_cast<double>(range[1])};
    });
  }

 private:
  MacroShape shape_;
  ElementType type_ = ElementType::F32;
  std::array<Level, MacroShape::largest_level_count + 1> levels_;
};

}  // namespace rhoray::formats
