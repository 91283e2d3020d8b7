#pragma once

#include <vtkSmartPointer.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

class vtkOutputWindow;

namespace rhoray::preprocess {

/// While it lives, everything that VTK would print as an error is kept here instead. One at a time
/// in a process. Asking the readers themselves is not enough: GetErrorCode() is 0 for missing and
/// for truncated files, and errors of their helpers (parser, decompressor) do not pass through
/// them.
class VtkErrors {
 public:
  VtkErrors();
  ~VtkErrors();
  VtkErrors(const VtkErrors&) = delete;
  VtkErrors& operator=(const VtkErrors&) = delete;

  const std::string& first() const { return first_; }  ///< empty while there was none

  /// Refuses the file when there was an error.
  void check(const std::filesystem::path& path) const;

 private:
  class Window;
  std::string first_;
  vtkSmartPointer<vtkOutputWindow> before_;
};

/// What the pieces of a VTK XML file say that they hold, summed.
struct VtkXmlCounts {
  std::uint64_t points = 0, cells = 0;
};

/// Refuses a VTK XML file whose root says another kind than `kind`, or no VTKFile at all; one that
/// names larger counts in its attributes than so short a file can hold; and one of a structured
/// kind whose pieces do not cover its whole extent once.
VtkXmlCounts check_vtk_xml(const std::filesystem::path& path, std::string_view kind);

}  // namespace rhoray::preprocess
