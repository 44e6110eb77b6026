#include "command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <exception>
#include <new>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/version.hpp>

#include "exit_codes.hpp"
#include "io/machine.hpp"
#include "messages.hpp"
#include "scene/suggest.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

constexpr const char* examples = R"(Examples:
  palpate run scenes/stacking.json           simulate a scene; results go to results/stacking
  palpate view scenes/stacking.json          look at a scene, and touch it, in the browser
  palpate info liver.msh                     what is in a mesh
  palpate generate stacking --count 5        write a scene to start from

'palpate SUBCOMMAND --help' explains each. Exit codes: 0 done, 1 the work failed, 2 bad usage or input.)";

/// "run", "generate box": how messages name a subcommand.
std::string title(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  if (parent == nullptr) return "command line";
  return parent->get_parent() == nullptr ? app.get_name() : title(*parent) + " " + app.get_name();
}

std::vector<std::string> subcommand_names(CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands({})) names.push_back(sub->get_name());
  return names;
}

std::string nearest_of(const std::string& word, const std::vector<std::string>& known) {
  return expected_name(word, std::vector<std::string_view>(known.begin(), known.end()));
}

/// Throws BadInput where a word that must be a subcommand is missing or is none.
void check_subcommands(CLI::App& app, std::span<const char* const> words) {
  const std::vector<std::string> known = subcommand_names(app);
  if (known.empty()) return;
  if (words.empty()) throw BadInput(title(app), "", "no subcommand", nearest_of("", known) + ", or --help");
  const std::string word = words.front();
  if (word.starts_with('-')) return;
  if (std::ranges::count(known, word) == 0) {
    throw BadInput(title(app), "", "unknown subcommand '" + word + "'", nearest_of(word, known));
  }
  check_subcommands(*app.get_subcommand(word), words.subspan(1));
}

/// The parsed subcommand that is deepest, or the command itself.
CLI::App& innermost(CLI::App& app) {
  const std::vector<CLI::App*> parsed = app.get_subcommands();
  return parsed.empty() ? app : innermost(*parsed.back());
}

std::vector<std::string> flag_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// What is wrong with the arguments, in one line: an unknown flag first, since it is what others follow from.
BadInput usage_error(CLI::App& command, const CLI::ParseError& error) {
  CLI::App& app = innermost(command);
  for (CLI::App* level : {&app, &command}) {
    for (const std::string& word : level->remaining()) {
      if (!word.starts_with('-')) continue;
      const std::string flag = word.substr(0, word.find('='));
      return {title(app), "", "unknown flag '" + flag + "'", nearest_of(flag, flag_names(app))};
    }
  }
  for (const std::string& word : app.remaining())
    return {title(app), "", "'" + word + "'", "no such argument"};
  return BadInput(title(app) + ": " + error.what() + " (see --help)");
}

int work(int argc, const char* const* argv) {
  CLI::App command("Palpate finds and resolves the contacts among soft bodies made of tets.", "palpate");
  command.footer(examples);
  command.require_subcommand(1);
  command.set_version_flag(
      "--version", [] { return "palpate " PALPATE_VERSION " (" + io::describe_machine().commit + ")"; });
  std::vector<Subcommand> subcommands{add_run(command), add_info(command), add_detect(command),
                                      add_view(command)};
  for (Subcommand& sub : add_generate(command)) subcommands.push_back(std::move(sub));

  check_subcommands(command, std::span(argv, static_cast<std::size_t>(argc)).subspan(1));
  try {
    command.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    std::ostringstream text;
    command.exit(asked, text, text);
    print_out(text.str());
    return exit_done;
  } catch (const CLI::ParseError& error) {
    throw usage_error(command, error);
  }
  for (const Subcommand& sub : subcommands) {
    if (sub.app->parsed()) return sub.work();
  }
  return exit_bad_input;  // not reached: a subcommand is required
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  // A file beyond a size limit is to be an error of the write, and not the end of the process.
  static_cast<void>(std::signal(SIGXFSZ, SIG_IGN));
  try {
    return work(argc, argv);
  } catch (const BadInput& error) {
    say_error(error.what());
    return exit_bad_input;
  } catch (const std::bad_alloc&) {
    say_error("out of memory");
  } catch (const std::exception& error) {
    say_error(error.what());
  } catch (...) {
    say_error("unknown exception");
  }
  return exit_failed;
}

}  // namespace palpate::app
