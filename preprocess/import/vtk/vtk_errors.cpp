#include "preprocess/import/vtk/vtk_errors.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>

#include "formats/base/library_text.h"

namespace rhoray::preprocess {

class VtkErrors::Window : public vtkOutputWindow {
 public:
  static Window* New();
  vtkTypeMacro(Window, vtkOutputWindow);

  void DisplayErrorText(const char* text) override {
    note_library_text(text);
    if (any_ != nullptr) *any_ = true;
  }
  void DisplayText(const char*) override {}
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}

  void notice_in(bool* any) { any_ = any; }

 private:
  bool* any_ = nullptr;
};
vtkStandardNewMacro(VtkErrors::Window);

VtkErrors::VtkErrors() : before_(vtkOutputWindow::GetInstance()) {
  // otherwise VTK prints each error a second time
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  const auto window = vtkSmartPointer<Window>::New();
  window->notice_in(&any_);
  vtkOutputWindow::SetInstance(window);
}

VtkErrors::~VtkErrors() {
  vtkOutputWindow::SetInstance(before_);
}

}  // namespace rhoray::preprocess
