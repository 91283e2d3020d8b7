#include "tools/library/arrays.h"

#include <cmath>

#include "formats/base/text.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1::inside {

std::string text_of(std::span<const std::int64_t> shape) {
  std::string text = "[";
  for (const std::int64_t size : shape) text += concat(text.size() > 1 ? ", " : "", size);
  return text + "]";
}

void require_floats(const ArrayView& array, std::string_view name, std::int64_t rows, std::int64_t columns) {
  const std::string expected =
      concat(rows < 0 ? std::string("n") : concat(rows), columns > 0 ? concat(", ", columns) : "");
  if (!array.is_given()) refuse(name, ": not given; expected an array of the shape [", expected, "]");
  const std::span<const std::int64_t> shape = array.shape();
  const std::size_t axes = columns > 0 ? 2 : 1;
  if (shape.size() != axes || (rows >= 0 && shape[0] != rows) || (columns > 0 && shape[1] != columns))
    refuse(name, ": an array of the shape ", text_of(shape), "; expected [", expected, "]");
  if (array.type() != ElementType::F32 && array.type() != ElementType::F64)
    refuse(name, ": elements of the type ", formats::element_name(inside_of(array.type())), "; expected F32 or F64");
}

bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace rhoray::v0_1::inside
