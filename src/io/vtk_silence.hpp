#pragma once

#include <mutex>

namespace palpate::io {

/// While it lives, VTK prints nothing: errors are seen from what its functions return.
///
/// VTK has one switch for a process, so objects of this class wait for each other; messages of other threads
/// that use VTK at the same time are dropped too. (An observer or another output window would not do: VTK 9.1
/// also writes each error to its logger, which prints it.)
class VtkSilence {
 public:
  VtkSilence();
  ~VtkSilence();
  VtkSilence(const VtkSilence&) = delete;
  VtkSilence& operator=(const VtkSilence&) = delete;

 private:
  std::scoped_lock<std::mutex> lock_;
  int previous_;
};

}  // namespace palpate::io
