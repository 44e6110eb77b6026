#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <span>

/// What the command and its helpers do about their arguments and about what goes wrong.
namespace palpate::app {

/// Throws BadInput where a word that must be a subcommand is missing or is none.
void check_subcommands(CLI::App& app, std::span<const char* const> words);

/// Parses the arguments. True where help or the version was asked for, and written to stdout. Throws BadInput
/// in one line for wrong usage.
bool parse_or_explain(CLI::App& command, int argc, const char* const* argv);

/// Calls `work` and turns every exception into one line on stderr. Returns the exit code. Standard streams
/// that are closed lead to /dev/null from then on.
int as_exit_code(const std::function<int()>& work);

}  // namespace palpate::app
