#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <palpate/error.hpp>

namespace palpate::app {

/// Exit codes of the command.
inline constexpr int exit_done = 0;
inline constexpr int exit_failed = 1;     ///< the work failed or was interrupted
inline constexpr int exit_bad_input = 2;  ///< wrong usage, or a scene or mesh that was refused

/// An error in what the user gave: a flag, a scene, a mesh. The command then returns exit_bad_input.
class BadInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  BadInput(std::string source, std::string where, std::string found, std::string expected)
      : std::runtime_error(
            Error(std::move(source), std::move(where), std::move(found), std::move(expected)).what()) {}
};

/// Calls `function` and converts an Error of the library to BadInput. Other exceptions pass through.
template <class Function>
auto as_input(Function&& function) {
  try {
    return std::forward<Function>(function)();
  } catch (const Error& error) {
    throw BadInput(error.what());
  }
}

}  // namespace palpate::app
