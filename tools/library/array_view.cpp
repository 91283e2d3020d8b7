#include "rhoray/array_view.h"

#include <limits>

#include "formats/base/text.h"
#include "formats/file_description.h"
#include "tools/library/arrays.h"
#include "tools/library/guarded.h"

namespace rhoray::v0_1 {

namespace {

constexpr std::int64_t most_bytes = std::numeric_limits<std::int64_t>::max();

/// The bytes between the first and the last element of an axis; nothing if they exceed most_bytes.
bool add_extent(std::int64_t size, std::int64_t stride, std::int64_t& total) {
  if (stride == std::numeric_limits<std::int64_t>::min()) return false;  // its negation overflows
  std::int64_t extent = 0;
  return !__builtin_mul_overflow(size - 1, stride < 0 ? -stride : stride, &extent) &&
         !__builtin_add_overflow(total, extent, &total);
}

[[noreturn]] void refuse_size(std::span<const std::int64_t> shape) {
  inside::refuse("an array of the shape ", inside::text_of(shape), "; expected at most ", most_bytes, " bytes");
}

void check_shape(std::span<const std::int64_t> shape) {
  if (shape.size() > ArrayView::most_axes)
    inside::refuse("an array of ", shape.size(), " axes; expected at most ", ArrayView::most_axes);
  for (const std::int64_t size : shape)
    if (size < 0) inside::refuse("an array of the shape ", inside::text_of(shape), "; expected sizes from 0 up");
}

}  // namespace

ArrayView::ArrayView(const void* first, ElementType type, std::span<const std::int64_t> shape,
                     std::span<const std::int64_t> strides_bytes)
    : first_(first), type_(type), is_given_(true), axis_count_(shape.size()) {
  inside::require_enumerator("ElementType", type, ElementType::F64);
  check_shape(shape);
  if (strides_bytes.size() != shape.size())
    inside::refuse("an array of ", shape.size(), " axes and ", strides_bytes.size(), " strides; expected as many");
  const auto element_bytes = static_cast<std::int64_t>(formats::element_bytes(inside::inside_of(type)));
  std::int64_t elements = 1, extent = element_bytes, copied_bytes = 0;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    shape_[axis] = shape[axis], strides_[axis] = strides_bytes[axis];
    if (__builtin_mul_overflow(elements, shape[axis], &elements) ||
        (shape[axis] > 0 && !add_extent(shape[axis], strides_bytes[axis], extent)))
      refuse_size(shape);
  }
  if (__builtin_mul_overflow(elements, element_bytes, &copied_bytes)) refuse_size(shape);
  if (first == nullptr && elements > 0) inside::refuse("an array of ", elements, " elements at a null pointer");
}

ArrayView::ArrayView(const void* first, ElementType type, std::size_t count, std::span<const std::int64_t> shape)
    : first_(first), type_(type), is_given_(true), axis_count_(shape.size()) {
  check_shape(shape);
  if (shape.empty()) {
    axis_count_ = 1;
    shape_[0] = static_cast<std::int64_t>(count);
  }
  std::int64_t elements = 1;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    shape_[axis] = shape[axis];
    if (__builtin_mul_overflow(elements, shape[axis], &elements)) elements = -1;
    if (elements < 0) break;
  }
  if (!shape.empty() && elements != static_cast<std::int64_t>(count))
    inside::refuse("an array of ", count, " elements with the shape ", inside::text_of(shape),
                   "; expected sizes whose product is their number");
  if (first == nullptr && count > 0) inside::refuse("an array of ", count, " elements at a null pointer");
  auto stride = static_cast<std::int64_t>(formats::element_bytes(inside::inside_of(type)));
  for (std::size_t axis = axis_count_; axis-- > 0;) {
    strides_[axis] = stride;
    if (count > 0) stride *= shape_[axis];  // without elements, the product may not fit
  }
}

std::int64_t ArrayView::count() const {
  if (!is_given_) return 0;
  std::int64_t elements = 1;
  for (const std::int64_t size : shape()) elements *= size;
  return elements;
}

}  // namespace rhoray::v0_1
