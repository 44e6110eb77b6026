#pragma once

#include <string>
#include <string_view>

namespace palpate::app {

/// Writes "palpate: error: MESSAGE" to stderr as exactly one line; control characters are written as '?'.
void say_error(std::string_view message);

/// Writes "palpate: warning: MESSAGE" to stderr, in the same way: probably a mistake of the user.
void say_warning(std::string_view message);

/// Writes "palpate: MESSAGE" to stderr: a remark beside the output.
void print_note(std::string_view message);

/// Writes a line with the time of day to stderr, for logs.
void say_progress(std::string_view message);

/// Writes text to stdout and flushes. Throws Error if the system cannot write it (such as a full disk
/// behind '>').
void print_out(std::string_view text);

enum class Colour { red, yellow };

/// The text in a colour where `stream` (its file number) is a terminal that shows colours and NO_COLOR
/// (https://no-color.org) is not set; else as it is.
std::string coloured(std::string_view text, Colour colour, int stream);

}  // namespace palpate::app
