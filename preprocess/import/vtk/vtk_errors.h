#pragma once

#include <vtkSmartPointer.h>

#include <filesystem>
#include <string>

class vtkOutputWindow;

namespace rhoray::preprocess {

/// While it lives, collects everything that VTK would print as an error. Only one may exist at a
/// time in a process. Querying VTK's objects is not enough: errors of their helpers do not reach
/// them.
class VtkErrors {
 public:
  VtkErrors();
  ~VtkErrors();
  VtkErrors(const VtkErrors&) = delete;
  VtkErrors& operator=(const VtkErrors&) = delete;

  const std::string& first() const { return first_; }  ///< first error; empty: none

  /// Refuses the file when there was an error.
  void check(const std::filesystem::path& path) const;

 private:
  class Window;
  std::string first_;
  vtkSmartPointer<vtkOutputWindow> before_;
};

}  // namespace rhoray::preprocess
