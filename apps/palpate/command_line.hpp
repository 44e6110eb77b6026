#pragma once

namespace palpate::app {

/// The whole command: parses, works, and turns every exception into one line on stderr. Returns the exit
/// code.
int run_command_line(int argc, const char* const* argv);

}  // namespace palpate::app
