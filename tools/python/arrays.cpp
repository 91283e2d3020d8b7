#include "tools/python/arrays.h"

namespace rhoray::python {

namespace py = pybind11;

namespace {

std::string text_of(const py::dtype& type) {
  return py::str(static_cast<const py::object&>(type)).cast<std::string>();
}

ElementType type_of(const py::dtype& type, const std::string& name) {
  const char order = type.byteorder();
  if (order == '>')
    throw py::type_error(name + ": big-endian elements (" + text_of(type) +
                         "); use a.astype(a.dtype.newbyteorder('=')) for such an array a");
  const auto size = static_cast<int>(type.itemsize());
  const char kind = type.kind();
  if (kind == 'f' && size == 4) return ElementType::F32;
  if (kind == 'f' && size == 8) return ElementType::F64;
  if ((kind == 'u' || kind == 'i') && (size == 1 || size == 2 || size == 4 || size == 8)) {
    const int pair = size == 1 ? 0 : size == 2 ? 2 : size == 4 ? 4 : 6;
    return static_cast<ElementType>(pair + (kind == 'i' ? 1 : 0));
  }
  throw py::type_error(name + ": elements of the type " + text_of(type) +
                       "; expected integers of 8 to 64 bits, float32 or float64");
}

}  // namespace

py::dtype dtype_of(ElementType type) {
  constexpr const char* formats[] = {"u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"};
  return py::dtype(formats[static_cast<std::size_t>(type)]);
}

ArrayView view_of(const py::array& array, const std::string& name) {
  if (py::hasattr(array, "mask"))
    throw py::type_error(name + ": a masked array; use .filled(numpy.nan): NaN means that there is no data");
  const ElementType type = type_of(array.dtype(), name);
  const auto axes = static_cast<std::size_t>(array.ndim());
  return {array.data(), type, std::span<const std::int64_t>(array.shape(), axes),
          std::span<const std::int64_t>(array.strides(), axes)};
}

py::array array_of(const ArrayView& view, const py::object& owner) {
  const std::vector<std::int64_t> shape(view.shape().begin(), view.shape().end());
  const std::vector<std::int64_t> strides(view.strides_bytes().begin(), view.strides_bytes().end());
  py::array array(dtype_of(view.type()), shape, strides, view.first(), owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

}  // namespace rhoray::python
