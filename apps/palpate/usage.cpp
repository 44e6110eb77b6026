#include "usage.hpp"

#include <algorithm>
#include <exception>
#include <fcntl.h>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

#include "exit_codes.hpp"
#include "messages.hpp"
#include "scene/suggest.hpp"

namespace palpate::app {
namespace {

/// The name of a subcommand in messages: "run", "generate box"; "mesh" is a program of its own.
std::string title(const CLI::App& app) {
  constexpr std::string_view own_program = "palpate ";
  const CLI::App* parent = app.get_parent();
  if (parent == nullptr) {
    return app.get_name().starts_with(own_program) ? app.get_name().substr(own_program.size())
                                                   : "command line";
  }
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

/// Opens /dev/null for standard streams that the caller has closed (">&-"). Otherwise the first file that is
/// opened would get their number, and printed text would be written into it.
void open_closed_streams() {
  int opened = 0;
  do {
    opened = ::open("/dev/null", O_RDWR);  // uses the lowest free number
  } while (opened >= 0 && opened <= STDERR_FILENO);
  if (opened >= 0) ::close(opened);
}

/// The innermost parsed subcommand, or the command itself.
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

/// The message on a flag with too few values: the text of CLI11 begins with the flag.
BadInput too_few_values(const CLI::App& app, const std::string& text) {
  const std::string flag = text.substr(0, text.find(':'));
  const CLI::Option* option = app.get_option_no_throw(flag);
  if (option == nullptr) return BadInput(title(app) + ": " + text + " (see --help)");
  return {flag, "", option->get_type_size() == 1 ? "no value" : "too few values", option->get_type_name()};
}

/// The message on wrong arguments, in one line. An unknown flag comes first, since it often causes the
/// others.
BadInput usage_error(CLI::App& command, const CLI::ParseError& error) {
  CLI::App& app = innermost(command);
  for (CLI::App* level : {&app, &command}) {
    for (const std::string& word : level->remaining()) {
      if (!word.starts_with('-')) continue;
      const std::string flag = word.substr(0, word.find('='));
      const std::vector<std::string> known = flag_names(app);
      if (level != &app && std::ranges::count(known, flag) > 0)
        return {title(app), "", "'" + flag + "' before the subcommand", "'" + flag + "' behind it"};
      return {title(app), "", "unknown flag '" + flag + "'", nearest_of(flag, known)};
    }
  }
  for (const std::string& word : app.remaining())
    return {title(app), "", "'" + word + "'", "no further argument"};
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) return too_few_values(app, error.what());
  return BadInput(title(app) + ": " + error.what() + " (see --help)");
}

}  // namespace

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

bool parse_or_explain(CLI::App& command, int argc, const char* const* argv) {
  try {
    command.parse(argc, argv);
    return false;
  } catch (const CLI::Success& asked) {  // --help, --version
    std::ostringstream text;
    command.exit(asked, text, text);
    print_out(text.str());
    return true;
  } catch (const CLI::ParseError& error) {
    throw usage_error(command, error);
  }
}

int as_exit_code(const std::function<int()>& work) {
  open_closed_streams();
  try {
    return work();
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
