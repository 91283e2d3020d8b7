#pragma once

#include <array>
#include <type_traits>

#include "formats/base/checks.h"
#include "formats/base/interval.h"
#include "formats/file_description.h"
#include "formats/macro_levels.h"

namespace rhoray::render {

/// True for the types of values that can be rendered. Each of their values is exact as a double.
template <class T>
inline constexpr bool is_rendered = std::is_floating_point_v<T> || sizeof(T) < 8;

/// Calls act(T{}) for the type T in which values are stored, one of those that can be rendered.
template <class Act>
RHORAY_INLINE decltype(auto) with_value_type(formats::ElementType type, Act&& act) {
  return formats::with_element_type(type, [&]<class T>(T) -> decltype(auto) {
    using Rendered = std::conditional_t<is_rendered<T>, T, double>;
    RHORAY_DCHECK(is_rendered<T>);
    return act(Rendered{});
  });
}

/// The smallest and largest value of every macrocell (formats::MacroLevelsView), for values of any
/// type. The arrays must outlive this.
class MacroRanges {
 public:
  /// The ranges of one level: [z, y, x, 2], lo before hi, in the type of the values.
  struct Level {
    const void* ranges = nullptr;
    Index3 count{0, 0, 0};
  };

  MacroRanges() = default;
  template <class T>
  MacroRanges(const formats::MacroLevelsView<T>& levels) : shape_(levels.shape), type_(formats::element_type_of<T>()) {
    for (int level = levels.first_level; level <= shape_.level_count; ++level)
      levels_[static_cast<std::size_t>(level)] = {
          levels.ranges[static_cast<std::size_t>(level - levels.first_level)].data(), shape_.count(level)};
  }

  const formats::MacroShape& shape() const { return shape_; }
  formats::ElementType type() const { return type_; }
  const Level& level(int level) const { return levels_[static_cast<std::size_t>(level)]; }

  /// Empty where no cell has data.
  Interval<double> range(int level, const Index3& cell) const {
    const Level& at = levels_[static_cast<std::size_t>(level)];
    const std::int64_t place = 2 * ((cell.z * at.count.y + cell.y) * at.count.x + cell.x);
    return with_value_type(type_, [&]<class T>(T) -> Interval<double> {
      const T* range = static_cast<const T*>(at.ranges) + place;
      if (range[0] > range[1]) return {};
      return {static_cast<double>(range[0]), static_cast<double>(range[1])};
    });
  }

 private:
  formats::MacroShape shape_;
  formats::ElementType type_ = formats::ElementType::F32;
  std::array<Level, formats::MacroShape::largest_level_count + 1> levels_;
};

}  // namespace rhoray::render
