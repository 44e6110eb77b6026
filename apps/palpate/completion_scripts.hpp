#pragma once

#include <string>

#include "outline.hpp"

/// Completion scripts of shells: subcommands, flags, words that are values of a flag, and files.
namespace palpate::app {

std::string bash_completion(const Outline& command);
std::string zsh_completion(const Outline& command);
std::string fish_completion(const Outline& command);

}  // namespace palpate::app
