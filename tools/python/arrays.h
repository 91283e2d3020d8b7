#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <rhoray/rhoray.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace rhoray::python {

/// A view of numbers in a numpy array. Refuses objects, masked arrays, booleans, complex and
/// structured elements, and a byte order that is not the machine's (TypeError).
/// @param name  of the argument, for messages
ArrayView view_of(const pybind11::array& array, const std::string& name);

/// A read-only numpy array in memory that `owner` keeps alive.
pybind11::array array_of(const ArrayView& view, const pybind11::object& owner);

template <class T>
pybind11::array array_of(std::span<const T> values, std::vector<std::int64_t> shape, const pybind11::object& owner) {
  std::vector<std::int64_t> strides(shape.size());
  std::int64_t stride = sizeof(T);
  for (std::size_t axis = shape.size(); axis-- > 0; stride *= shape[axis]) strides[axis] = stride;
  return array_of(ArrayView(values.data(), element_type<T>(), shape, strides), owner);
}

pybind11::dtype dtype_of(ElementType type);

/// A numpy array that owns the memory of a vector, as elements of this type.
template <class T>
pybind11::array array_of(std::vector<T>&& values, ElementType type, const std::vector<std::int64_t>& shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  const void* const data = kept->data();
  const pybind11::capsule owner(kept.release(), [](void* all) { delete static_cast<std::vector<T>*>(all); });
  return pybind11::array(dtype_of(type), shape, data, owner);
}

/// A numpy array that owns these numbers.
template <class T>
pybind11::array array_of(std::vector<T>&& values, const std::vector<std::int64_t>& shape) {
  return array_of(std::move(values), element_type<T>(), shape);
}

}  // namespace rhoray::python
