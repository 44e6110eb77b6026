#pragma once

#include <string>

#include <palpate/error.hpp>

#include "number_text.hpp"

namespace palpate::anatomy {

/// Throws Error naming the function if a length is out of range.
struct MillimetreCheck {
  const char* function;

  void operator()(const char* what, double value, double least, double most) const {
    if (value >= least && value <= most) return;
    throw Error(function, what, number_text(value), number_text(least) + " to " + number_text(most) + " mm");
  }
};

}  // namespace palpate::anatomy
