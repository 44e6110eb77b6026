#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <span>

/// Parsing of arguments and handling of errors, for the command and its helpers.
namespace palpate::app {

/// Throws BadInput if a required subcommand is missing or unknown.
void check_subcommands(CLI::App& app, std::span<const char* const> words);

/// Parses the arguments. Returns true where help or the version was asked for; it is then on stdout. Throws
/// BadInput in one line for wrong usage.
bool parse_or_explain(CLI::App& command, int argc, const char* const* argv);

/// Calls `work` and turns every exception into one line on stderr. Returns the exit code. Standard streams
/// that are closed lead to /dev/null from then on.
int as_exit_code(const std::function<int()>& work);

}  // namespace palpate::app
