#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "completion_scripts.hpp"
#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "manual_page.hpp"
#include "messages.hpp"
#include "option_values.hpp"
#include "outline.hpp"
#include "subcommands.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* completion_examples = R"(Examples:
  palpate completion bash > ~/.local/share/bash-completion/completions/palpate
  palpate completion zsh > ~/.zfunc/_palpate            with fpath+=~/.zfunc before compinit in ~/.zshrc
  palpate completion fish > ~/.config/fish/completions/palpate.fish
  source <(palpate completion bash)                     for this shell alone)";

constexpr const char* manual_examples = R"(Examples:
  palpate manual | man -l -                             read it
  palpate manual generate box | man -l -                that of a subcommand
  palpate manual --out ~/.local/share/man/man1          a page for each subcommand, palpate-run.1 and so on)";

struct ManualOptions {
  std::optional<fs::path> out;
  std::vector<std::string> subcommand;  ///< the words of the subcommand, such as "generate" and "box"
};

int write_manual(const CLI::App& command, const ManualOptions& options) {
  const Outline whole = outline_of(command);
  if (options.out) {
    io::create_folder(*options.out);
    for (const Outline* outline : all_of(whole))
      io::write_atomically(*options.out / (title_of(*outline, "-") + ".1"), manual_page(*outline, whole));
    return exit_done;
  }
  const Outline* wanted = &whole;
  for (const std::string& word : options.subcommand) {
    const auto& below = wanted->subcommands;
    const auto sub = std::ranges::find_if(below, [&](const Outline& one) { return one.path.back() == word; });
    if (sub == below.end()) {
      throw BadInput("manual", "", "'" + word + "'",
                     "a subcommand of " + title_of(*wanted, " ") + ", or none");
    }
    wanted = &*sub;
  }
  print_out(manual_page(*wanted, whole));
  return exit_done;
}

}  // namespace

Subcommand add_completion(CLI::App& command) {
  CLI::App* app = command.add_subcommand("completion", "print the completion script of a shell");
  app->footer(completion_examples);
  constexpr static std::array<std::string_view, 3> shells{"bash", "zsh", "fish"};
  auto shell = std::make_shared<std::size_t>(0);
  app->add_option_function<std::string>(
         "SHELL", [shell](const std::string& text) { *shell = parse_choice("completion", text, shells); },
         "bash, zsh or fish")
      ->type_name("bash|zsh|fish")
      ->required();
  return {app, [&command, shell] {
            constexpr std::array scripts{bash_completion, zsh_completion, fish_completion};
            print_out(scripts[*shell](outline_of(command)));
            return exit_done;
          }};
}

Subcommand add_manual(CLI::App& command) {
  CLI::App* app = command.add_subcommand("manual", "print the manual pages, for man(1)");
  app->footer(manual_examples);
  auto options = std::make_shared<ManualOptions>();
  app->add_option("SUBCOMMAND", options->subcommand, "subcommand of the page; default: the whole command");
  add_value(*app, "--out", "DIR", "folder to write all pages to, instead of printing one",
            [options](const std::string&, const std::string& text) { options->out = text; });
  return {app, [&command, options] { return write_manual(command, *options); }};
}

}  // namespace palpate::app
