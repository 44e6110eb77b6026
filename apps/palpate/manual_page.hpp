#pragma once

#include <string>

#include "outline.hpp"

namespace palpate::app {

/// The manual page (section 1) of a command or subcommand, in the language of man(7); `whole` is the command
/// that it belongs to. It contains no date: the same build gives the same page.
std::string manual_page(const Outline& outline, const Outline& whole);

}  // namespace palpate::app
