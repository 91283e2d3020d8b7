#include "tools/python/module.h"

#include <pybind11/pybind11.h>
#include <rhoray/rhoray.h>

namespace rhoray::python {

namespace py = pybind11;

namespace {

/// A message, which may hold a path that is not UTF-8.
py::object text_of(const std::string& message) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(message.data(), static_cast<Py_ssize_t>(message.size()), "replace"));
}

/// Raises the exception of the package that belongs to the code.
void raise(const Error& error) {
  const py::object make = py::module_::import("rhoray._errors").attr("error_of");
  const py::object exception = make(static_cast<int>(error.code()), text_of(error.what()), text_of(error.hint()));
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(exception.ptr())), exception.ptr());
}

}  // namespace

}  // namespace rhoray::python

PYBIND11_MODULE(_core, module) {
  module.doc() = "The compiled part of rhoray. Its names may change at any time; use the package.";
  module.attr("version") = rhoray::library_version();
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const rhoray::Error& error) {
      rhoray::python::raise(error);
    }
  });
  rhoray::python::define_datasets(module);
  rhoray::python::define_rendering(module);
  rhoray::python::define_rays(module);
}
