#pragma once

#include <mutex>
#include <string>
#include <vtkSmartPointer.h>

class vtkOutputWindow;

namespace palpate::io {

/// While it lives, collects what VTK would print as errors instead of printing it, and drops VTK's warnings.
///
/// VTK has one place for messages in a process: objects of this class wait for each other, and messages of
/// other threads that use VTK at the same time are collected too.
class VtkErrors {
 public:
  VtkErrors();
  ~VtkErrors();
  VtkErrors(const VtkErrors&) = delete;
  VtkErrors& operator=(const VtkErrors&) = delete;

  /// The first error in one line, without VTK's source file and addresses; empty if there was none.
  [[nodiscard]] std::string first() const;

 private:
  std::scoped_lock<std::mutex> lock_;
  vtkSmartPointer<vtkOutputWindow> previous_;
  vtkSmartPointer<vtkOutputWindow> collector_;
  int previous_display_;
};

}  // namespace palpate::io
