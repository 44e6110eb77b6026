#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <palpate/error.hpp>

namespace palpate::app {

/// What the command returns to the shell.
inline constexpr int exit_done = 0;
inline constexpr int exit_failed = 1;     ///< the work failed or was interrupted
inline constexpr int exit_bad_input = 2;  ///< wrong usage, or a scene or mesh that was refused

/// Something that the user gave and has to change: a flag, a scene, a mesh. Ends in exit_bad_input.
class BadInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  BadInput(std::string source, std::string where, std::string found, std::string expected)
      : std::runtime_error(
            Error(std::move(source), std::move(where), std::move(found), std::move(expected)).what()) {}
};

/// Calls `function`; an Error of the library then blames the input. All else passes through.
template <class Function>
auto as_input(Function&& function) {
  try {
    return std::forward<Function>(function)();
  } catch (const Error& error) {
    throw BadInput(error.what());
  }
}

}  // namespace palpate::app
