#pragma once

#include <vtkDataArray.h>

#include "formats/packed_file.h"
#include "preprocess/neutral.h"

namespace rhoray::preprocess {

/// Calls act(numbers, count) with the array's numbers in their own type.
template <class Act>
void with_numbers(vtkDataArray& array, formats::ElementType type, Act&& act) {
  formats::with_element_type(type, [&]<class T>(T) {
    act(static_cast<const T*>(array.GetVoidPointer(0)), static_cast<std::size_t>(array.GetNumberOfValues()));
  });
}

template <class Number>
Array<Number> numbers_of(vtkDataArray& array, formats::ElementType type) {
  Array<Number> result;
  with_numbers(array, type, [&]<class T>(const T* numbers, std::size_t count) {
    result.resize(count);
    for (std::size_t i = 0; i < count; ++i) result[i] = static_cast<Number>(numbers[i]);
  });
  return result;
}

}  // namespace rhoray::preprocess
