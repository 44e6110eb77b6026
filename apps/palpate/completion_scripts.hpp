#pragma once

#include <string>

#include "outline.hpp"

/// Scripts by which shells complete the command: subcommands, flags, words that a flag takes, and files.
namespace palpate::app {

std::string bash_completion(const Outline& command);
std::string zsh_completion(const Outline& command);
std::string fish_completion(const Outline& command);

}  // namespace palpate::app
