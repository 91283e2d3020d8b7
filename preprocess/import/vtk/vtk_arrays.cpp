#include "preprocess/import/vtk/vtk_arrays.h"

#include <vtkDataArray.h>

namespace rhoray::preprocess {

std::optional<formats::ElementType> element_type_of_vtk(const vtkDataArray& array) {
  using formats::ElementType;
  auto& asked = const_cast<vtkDataArray&>(array);  // VTK's getters are not const
  const int bytes = asked.GetDataTypeSize();
  switch (asked.GetDataType()) {
    case VTK_FLOAT:
      return ElementType::F32;
    case VTK_DOUBLE:
      return ElementType::F64;
    case VTK_CHAR:
    case VTK_SIGNED_CHAR:
      return ElementType::I8;
    case VTK_UNSIGNED_CHAR:
      return ElementType::U8;
    case VTK_SHORT:
      return ElementType::I16;
    case VTK_UNSIGNED_SHORT:
      return ElementType::U16;
    case VTK_INT:
      return ElementType::I32;
    case VTK_UNSIGNED_INT:
      return ElementType::U32;
    case VTK_LONG:
    case VTK_LONG_LONG:
    case VTK_ID_TYPE:
      return bytes == 8 ? ElementType::I64 : ElementType::I32;
    case VTK_UNSIGNED_LONG:
    case VTK_UNSIGNED_LONG_LONG:
      return bytes == 8 ? ElementType::U64 : ElementType::U32;
    default:
      return std::nullopt;
  }
}

}  // namespace rhoray::preprocess
