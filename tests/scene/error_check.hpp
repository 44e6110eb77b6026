#pragma once

#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>

/// Runs `action`, which must throw palpate::Error, and returns its message ("no error" if it does not).
template <class Action>
std::string message_of(Action&& action) {
  try {
    action();
  } catch (const palpate::Error& error) {
    return error.what();
  }
  return "no error";
}
