#include "command_line.hpp"

#include <CLI/CLI.hpp>
#include <csignal>
#include <fmt/format.h>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/version.hpp>

#include "companion_program.hpp"
#include "exit_codes.hpp"
#include "io/machine.hpp"
#include "subcommands.hpp"
#include "usage.hpp"

namespace palpate::app {
namespace {

constexpr const char* examples = R"(Examples:
  palpate run scenes/stacking.json           simulate a scene; results go to results/stacking
  palpate view scenes/stacking.json          look at a scene, and touch it, in the browser
  palpate info liver.msh                     what is in a mesh
  palpate generate stacking --count 5        write a scene to start from
  palpate mesh organs.seg.nrrd               bodies and a scene from a segmentation

'palpate SUBCOMMAND --help' explains each. Exit codes: 0 done, 1 the work failed, 2 bad usage or input.)";

int work(int argc, const char* const* argv) {
  CLI::App command("Palpate finds and resolves the contacts among soft bodies made of tets.", "palpate");
  command.footer(examples);
  command.require_subcommand(1);
  command.set_version_flag(
      "--version", [] { return "palpate " PALPATE_VERSION " (" + io::describe_machine().commit + ")"; });
  std::vector<Subcommand> subcommands{add_run(command), add_info(command), add_detect(command),
                                      add_view(command)};
  for (const auto& add : {add_generate, add_bench}) {
    for (Subcommand& sub : add(command)) subcommands.push_back(std::move(sub));
  }
  command.add_subcommand(std::string(mesh_companion.words),
                         "tet meshes and a scene from a label map or surfaces");

  const std::span words(argv, static_cast<std::size_t>(argc));
  check_subcommands(command, words.subspan(1));
  if (words[1] == mesh_companion.words) return run_companion(mesh_companion, words.subspan(2));
  for (const Companion& companion : {peers_companion, speed_companion, step_companion}) {
    if (words.size() > 2 && fmt::format("{} {}", words[1], words[2]) == companion.words)
      return run_companion(companion, words.subspan(3));
  }
  if (parse_or_explain(command, argc, argv)) return exit_done;
  for (const Subcommand& sub : subcommands) {
    if (sub.app->parsed()) return sub.work();
  }
  return exit_bad_input;  // not reached: a subcommand is required
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  // A file beyond a size limit is to be an error of the write, and not the end of the process.
  static_cast<void>(std::signal(SIGXFSZ, SIG_IGN));
  return as_exit_code([&] { return work(argc, argv); });
}

}  // namespace palpate::app
