#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <vector>

namespace palpate::app {

/// A subcommand: its flags, and its work after they are parsed. `work` returns the exit code; it throws
/// BadInput for errors in the input, and any other exception where the work failed.
struct Subcommand {
  CLI::App* app;
  std::function<int()> work;
};

/// Each of these adds its subcommand to the command.
Subcommand add_run(CLI::App& command);
Subcommand add_info(CLI::App& command);
Subcommand add_detect(CLI::App& command);
Subcommand add_view(CLI::App& command);
Subcommand add_new(CLI::App& command);
/// Completes the flags of the whole command, which must outlive this.
Subcommand add_completion(CLI::App& command);
Subcommand add_manual(CLI::App& command);
/// `generate` has a subcommand for each kind of output.
std::vector<Subcommand> add_generate(CLI::App& command);
/// `bench` has a subcommand for each report.
std::vector<Subcommand> add_bench(CLI::App& command);

}  // namespace palpate::app
