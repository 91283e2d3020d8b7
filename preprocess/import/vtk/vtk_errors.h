#pragma once

#include <vtkSmartPointer.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

class vtkOutputWindow;

namespace rhoray::preprocess {

/// While it lives, collects everything that VTK would print as an error. Only one may exist at a
/// time in a process. Querying the readers is not enough: GetErrorCode() is 0 for missing and
/// truncated files, and errors of their helpers (parser, decompressor) do not reach them.
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

/// Counts that the pieces of a VTK XML file declare, summed.
struct VtkXmlCounts {
  std::uint64_t points = 0, cells = 0;
};

/// Refuses a VTK XML file whose root has another kind than `kind`, or no VTKFile element. Refuses
/// counts in attributes that a file this short cannot hold. Refuses a structured kind whose pieces
/// do not cover the whole extent exactly once.
VtkXmlCounts check_vtk_xml(const std::filesystem::path& path, std::string_view kind);

}  // namespace rhoray::preprocess
