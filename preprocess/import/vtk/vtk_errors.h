#pragma once

#include <vtkSmartPointer.h>

class vtkOutputWindow;

namespace rhoray::preprocess {

/// While it lives, notices everything that VTK would print as an error, and passes it on as a
/// library's text (library_text.h). Only one may exist at a time in a process. Querying VTK's
/// objects is not enough: errors of their helpers do not reach them.
class VtkErrors {
 public:
  VtkErrors();
  ~VtkErrors();
  VtkErrors(const VtkErrors&) = delete;
  VtkErrors& operator=(const VtkErrors&) = delete;

  bool any() const { return any_; }

 private:
  class Window;
  bool any_ = false;
  vtkSmartPointer<vtkOutputWindow> before_;
};

}  // namespace rhoray::preprocess
