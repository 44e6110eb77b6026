#pragma once

#include <string>

#include <palpate/error.hpp>

namespace palpate::python {

/// Records that a thread is inside an object without holding Python's lock. Read and changed only with the
/// lock.
class Busy {
 public:
  /// Marks the object as in use during its lifetime. Throws Error if it already is.
  class Use {
   public:
    Use(Busy& busy, const char* what) : busy_(busy) {
      busy.check(what);
      busy_.used_ = true;
    }
    ~Use() { busy_.used_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    Busy& busy_;
  };
  /// Throws Error if another thread is inside.
  void check(const char* what) const {
    if (used_) throw Error(what, "", "a call while another thread is inside", "one thread at a time");
  }

 private:
  bool used_ = false;
};

}  // namespace palpate::python
