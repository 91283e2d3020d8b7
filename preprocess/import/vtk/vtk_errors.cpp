#include "preprocess/import/vtk/vtk_errors.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>

#include <algorithm>

#include "formats/base/error.h"

namespace rhoray::preprocess {

class VtkErrors::Window : public vtkOutputWindow {
 public:
  static Window* New();
  vtkTypeMacro(Window, vtkOutputWindow);

  void DisplayErrorText(const char* text) override { keep(text); }
  void DisplayText(const char*) override {}
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}

  void keep_in(std::string* first) { first_ = first; }

 private:
  /// Converts "ERROR: In FILE, line N\nCLASS (ADDRESS): message" to "message", in one line.
  void keep(std::string text) {
    if (first_ == nullptr || !first_->empty()) return;
    if (const std::size_t begin = text.find("): "); begin != std::string::npos) text.erase(0, begin + 3);
    std::replace(text.begin(), text.end(), '\n', ' ');
    while (text.ends_with(' ')) text.pop_back();
    *first_ = text.empty() ? "no reason given" : text;
  }

  std::string* first_ = nullptr;
};
vtkStandardNewMacro(VtkErrors::Window);

VtkErrors::VtkErrors() : before_(vtkOutputWindow::GetInstance()) {
  // otherwise VTK prints each error a second time
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  const auto window = vtkSmartPointer<Window>::New();
  window->keep_in(&first_);
  vtkOutputWindow::SetInstance(window);
}

VtkErrors::~VtkErrors() {
  vtkOutputWindow::SetInstance(before_);
}

void VtkErrors::check(const std::filesystem::path& path) const {
  if (!first_.empty()) throw Error(ErrorCode::invalid, concat(path.string(), ": VTK cannot read it: ", first_));
}

}  // namespace rhoray::preprocess
