#include "command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
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
#include "mesh_options.hpp"
#include "subcommands.hpp"
#include "usage.hpp"

namespace palpate::app {
namespace {

constexpr const char* command_examples = R"(Examples:
  palpate run scenes/stacking.json           simulate a scene; results go to results/stacking
  palpate view scenes/stacking.json          show a scene in the browser, where its bodies can be pulled
  palpate view liver.msh                     show a mesh that an instrument presses
  palpate new liver.msh                      write a scene that contains a mesh
  palpate info liver.msh                     statistics of a mesh
  palpate generate stacking --count 5        write a scene to start from
  palpate mesh organs.seg.nrrd               bodies and a scene from a segmentation

'palpate help SUBCOMMAND' explains a subcommand. Exit codes: 0 done, 1 the work failed, 2 bad usage or input.)";

/// Changes "palpate help generate box" to "palpate generate box --help".
std::vector<const char*> without_help_word(std::span<const char* const> words) {
  std::vector<const char*> result(words.begin(), words.end());
  if (words.size() < 2 || std::string_view(words[1]) != "help") return result;
  result.erase(result.begin() + 1);
  result.push_back("--help");
  return result;
}

bool asks_for_help(std::span<const char* const> words) {
  return std::ranges::any_of(words, [](std::string_view word) { return word == "--help" || word == "-h"; });
}

/// Throws BadInput if a word follows "help" and a subcommand that has no subcommands. check_subcommands()
/// reports wrong names.
void check_help_words(const CLI::App& command, std::span<const char* const> words) {
  const CLI::App* above = &command;
  for (const std::string_view word : words) {
    const auto below = above->get_subcommands([](const CLI::App*) { return true; });
    if (below.empty()) {
      throw BadInput("help", "", fmt::format("'{}'", word),
                     fmt::format("no word after '{}', which has no subcommands", above->get_name()));
    }
    const auto found =
        std::ranges::find_if(below, [&](const CLI::App* sub) { return sub->get_name() == word; });
    if (found == below.end()) return;
    above = *found;
  }
}

/// Adds `help` and the subcommands that are separate programs, so that help and completion list them.
void add_words(CLI::App& command, MeshOptions& mesh_options) {
  CLI::App* const mesh = command.add_subcommand(std::string(mesh_companion.words),
                                                "make tet meshes and a scene from a label map or surfaces");
  add_mesh_options(*mesh, mesh_options);
  CLI::App* const help = command.add_subcommand("help", "explain a subcommand");
  std::string names;
  for (const CLI::App* sub : command.get_subcommands({}))
    names += (names.empty() ? "" : "|") + sub->get_name();
  help->add_option("SUBCOMMAND")->description("subcommand; default: the whole command")->type_name(names);
  help->footer("Examples:\n  palpate help run\n  palpate help generate box");
}

/// \param help_words  number of words after "help", which without_help_word() has removed
int work(std::span<const char* const> words, std::size_t help_words) {
  CLI::App command("Palpate finds and resolves the contacts among soft bodies made of tets.", "palpate");
  command.footer(command_examples);
  command.require_subcommand(1);
  command.set_version_flag(
      "-V,--version", [] { return "palpate " PALPATE_VERSION " (" + io::describe_machine().commit + ")"; });
  std::vector<Subcommand> subcommands{add_new(command), add_view(command), add_run(command),
                                      add_info(command), add_detect(command)};
  for (const auto& add : {add_generate, add_bench}) {
    for (Subcommand& sub : add(command)) subcommands.push_back(std::move(sub));
  }
  MeshOptions mesh_options;
  for (const auto& add : {add_completion, add_manual}) subcommands.push_back(add(command));
  add_words(command, mesh_options);

  check_subcommands(command, words.subspan(1));
  check_help_words(command, words.subspan(1, help_words));
  if (words[1] == mesh_companion.words && !asks_for_help(words))
    return run_companion(mesh_companion, words.subspan(2));
  for (const Companion& companion : {peers_companion, speed_companion, step_companion}) {
    if (words.size() > 2 && fmt::format("{} {}", words[1], words[2]) == companion.words)
      return run_companion(companion, words.subspan(3));
  }
  if (parse_or_explain(command, static_cast<int>(words.size()), words.data())) return exit_done;
  for (const Subcommand& sub : subcommands) {
    if (sub.app->parsed()) return sub.work();
  }
  return exit_bad_input;  // not reached: a subcommand is required
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  // A write beyond the file size limit must fail with an error and not end the process.
  static_cast<void>(std::signal(SIGXFSZ, SIG_IGN));
  const std::span<const char* const> given(argv, static_cast<std::size_t>(argc));
  const auto words = without_help_word(given);
  const bool help = given.size() > 1 && std::string_view(given[1]) == "help" && !asks_for_help(given);
  return as_exit_code([&] { return work(words, help ? given.size() - 2 : 0); });
}

}  // namespace palpate::app
