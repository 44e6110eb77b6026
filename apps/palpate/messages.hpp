#pragma once

#include <string_view>

namespace palpate::app {

/// Writes "palpate: error: MESSAGE" to stderr as exactly one line; control characters are written as '?'.
void say_error(std::string_view message);

/// Writes "palpate: MESSAGE" to stderr: what is worth knowing beside the output.
void say_note(std::string_view message);

/// Writes a line with the time of day to stderr, for logs.
void say_progress(std::string_view message);

/// Writes text to stdout and flushes. Throws Error where the system does not take it (a full disk behind
/// '>').
void print_out(std::string_view text);

}  // namespace palpate::app
