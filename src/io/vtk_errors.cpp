#include "io/vtk_errors.hpp"

#include <string_view>
#include <vtkObject.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>

namespace palpate::io {
namespace {

class Collector : public vtkOutputWindow {
 public:
  vtkTypeMacro(Collector, vtkOutputWindow);
  static Collector* New();

  void DisplayErrorText(const char* text) override {
    if (first.empty()) first = text;
  }
  void DisplayText(const char*) override {}
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayDebugText(const char*) override {}

  std::string first;
};
vtkStandardNewMacro(Collector);

std::mutex& message_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// VTK's text is "ERROR: In FILE, line N\nCLASS (0xADDRESS): MESSAGE\n\n".
std::string message_of(std::string_view text) {
  const auto address = text.find("): ");
  if (address != std::string_view::npos) text.remove_prefix(address + 3);
  std::string line;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\n' || c == '\r' || c == '\t';
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  while (!line.empty() && (line.back() == ' ' || line.back() == '.')) line.pop_back();
  return line;
}

}  // namespace

VtkErrors::VtkErrors()
    : lock_(message_mutex()),
      previous_(vtkOutputWindow::GetInstance()),
      collector_(vtkSmartPointer<Collector>::New()),
      previous_display_(vtkObject::GetGlobalWarningDisplay()) {
  vtkOutputWindow::SetInstance(collector_);
  vtkObject::SetGlobalWarningDisplay(1);  // switched off, VTK would not tell of errors at all
}

VtkErrors::~VtkErrors() {
  vtkObject::SetGlobalWarningDisplay(previous_display_);
  vtkOutputWindow::SetInstance(previous_);
}

std::string VtkErrors::first() const {
  return message_of(static_cast<Collector*>(collector_.Get())->first);
}

}  // namespace palpate::io
