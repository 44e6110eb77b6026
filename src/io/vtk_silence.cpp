#include "io/vtk_silence.hpp"

#include <vtkObject.h>

namespace palpate::io {
namespace {

std::mutex& switch_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

VtkSilence::VtkSilence() : lock_(switch_mutex()), previous_(vtkObject::GetGlobalWarningDisplay()) {
  vtkObject::SetGlobalWarningDisplay(0);
}

VtkSilence::~VtkSilence() {
  vtkObject::SetGlobalWarningDisplay(previous_);
}

}  // namespace palpate::io
