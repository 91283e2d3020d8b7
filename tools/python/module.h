#pragma once

#include <pybind11/pybind11.h>

/// The parts of the module, each in a source of its own.
namespace rhoray::python {

void define_datasets(pybind11::module_& module);   ///< packing.cpp
void define_rendering(pybind11::module_& module);  ///< rendering.cpp
void define_rays(pybind11::module_& module);       ///< rays.cpp

}  // namespace rhoray::python
