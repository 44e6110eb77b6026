#include "completion_scripts.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string_view>
#include <vector>

#include <palpate/io/mesh_reader.hpp>

#include "numbers.hpp"

namespace palpate::app {
namespace {

/// The first clause of a description. It is short enough to be shown next to a flag.
std::string brief(const std::string& text) {
  return text.substr(0, text.find(';'));
}

std::vector<std::string> sub_names(const Outline& outline) {
  std::vector<std::string> names;
  names.reserve(outline.subcommands.size());
  for (const Outline& sub : outline.subcommands) names.push_back(sub.path.back());
  return names;
}

std::vector<std::string> flag_names(const Outline& outline) {
  std::vector<std::string> names;
  for (const OutlineOption& option : outline.options) {
    if (!option.argument) names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

/// Endings of the names of scenes and meshes.
std::vector<std::string> scene_and_mesh_extensions() {
  std::vector<std::string> all{".json"};
  for (const std::string_view extension : io::mesh_extensions()) all.emplace_back(extension);
  return all;
}

// The script for bash.

/// The bash call that completes a value; one with an empty list where there is nothing to offer.
std::string bash_offer(const OutlineOption& option) {
  switch (option.kind) {
    case ValueKind::word:
      return fmt::format("_palpate_words {}", in_quotes(fmt::format("{}", fmt::join(option.words, " "))));
    case ValueKind::file:
      return "_palpate_files f";
    case ValueKind::scene:
      return "_palpate_files f '*.json'";
    case ValueKind::mesh:
      return fmt::format("_palpate_files f '*{}'", fmt::join(io::mesh_extensions(), "' '*"));
    case ValueKind::scene_or_mesh:  // folders are offered with every pattern
      return fmt::format("_palpate_files f '*{}'", fmt::join(scene_and_mesh_extensions(), "' '*"));
    case ValueKind::folder:
      return "_palpate_files d";
    case ValueKind::none:
    case ValueKind::other:
      break;
  }
  return "";
}

constexpr const char* bash_head = R"(# bash completion of palpate; made by 'palpate completion bash'.

# Offers the words of $1 that begin with what is typed.
_palpate_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "$cur"); }

# Offers files (f) or folders (d); with patterns the files that match one, and folders to look into.
_palpate_files() {
  local kind="$1" pattern
  shift
  compopt -o filenames 2>/dev/null
  if (($#)); then
    mapfile -t COMPREPLY < <(for pattern; do compgen -f -X "!$pattern" -- "$cur"; done; compgen -d -- "$cur")
  else
    mapfile -t COMPREPLY < <(compgen -"$kind" -- "$cur")
  fi
}

_palpate() {
  local cur="${COMP_WORDS[COMP_CWORD]}" prev="${COMP_WORDS[COMP_CWORD - 1]}" at=palpate i
  COMPREPLY=()
  # "--flag=value" is three words to bash.
  if [[ $cur == '=' ]]; then
    cur=""
  elif [[ $prev == '=' ]]; then
    prev="${COMP_WORDS[COMP_CWORD - 2]}"
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$at ${COMP_WORDS[i]}" in
)";

}  // namespace

std::string bash_completion(const Outline& command) {
  const std::vector<const Outline*> all = all_of(command);
  std::string text = bash_head;
  std::vector<std::string> known;
  for (const Outline* outline : all) {
    if (outline->path.size() > 1) known.push_back(in_quotes(title_of(*outline)));
  }
  text +=
      fmt::format("      {}) at+=\" ${{COMP_WORDS[i]}}\" ;;\n    esac\n  done\n", fmt::join(known, " | "));
  text += "  case \"$at $prev\" in\n";
  for (const Outline* outline : all) {
    for (const OutlineOption& option : outline->options) {
      if (option.argument || option.kind == ValueKind::none) continue;
      std::vector<std::string> patterns;
      patterns.reserve(option.names.size());
      for (const std::string& name : option.names)
        patterns.push_back(in_quotes(title_of(*outline).append(1, ' ').append(name)));
      const std::string offer = bash_offer(option);
      text +=
          fmt::format("    {}) {}return ;;\n", fmt::join(patterns, " | "), offer.empty() ? "" : offer + "; ");
    }
  }
  text += "  esac\n  case \"$at\" in\n";
  for (const Outline* outline : all) {
    const auto argument =
        std::ranges::find_if(outline->options, [](const OutlineOption& option) { return option.argument; });
    std::string otherwise =
        fmt::format("_palpate_words {}", in_quotes(fmt::format("{}", fmt::join(sub_names(*outline), " "))));
    if (argument != outline->options.end()) otherwise = bash_offer(*argument);
    if (otherwise.empty()) otherwise = ":";
    text += fmt::format("    {}) if [[ $cur == -* ]]; then _palpate_words {}; else {}; fi ;;\n",
                        in_quotes(title_of(*outline)),
                        in_quotes(fmt::format("{}", fmt::join(flag_names(*outline), " "))), otherwise);
  }
  return text + "  esac\n}\ncomplete -F _palpate palpate\n";
}

// The script for zsh.

namespace {

/// Escapes text for zsh's _arguments, where ':' and brackets have a meaning.
std::string zsh_text(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == ':' || c == '[' || c == ']' || c == '\\') result += '\\';
    result += c;
  }
  return result;
}

std::string zsh_action(const OutlineOption& option) {
  switch (option.kind) {
    case ValueKind::word:
      return fmt::format("({})", fmt::join(option.words, " "));
    case ValueKind::file:
      return "_files";
    case ValueKind::scene:
      return "_files -g \"*.json\"";
    case ValueKind::mesh:
      return fmt::format("_files -g \"*({})\"", fmt::join(io::mesh_extensions(), "|"));
    case ValueKind::scene_or_mesh:
      return fmt::format("_files -g \"*({})\"", fmt::join(scene_and_mesh_extensions(), "|"));
    case ValueKind::folder:
      return "_files -/";
    case ValueKind::none:
    case ValueKind::other:
      break;
  }
  return " ";
}

std::string zsh_function(const Outline& outline) {
  std::string text = fmt::format("_{}() {{\n", title_of(outline, "_"));
  if (!outline.subcommands.empty())
    text += "  local curcontext=\"$curcontext\" state line\n  typeset -A opt_args\n";
  text += "  _arguments -C";
  for (const OutlineOption& option : outline.options) {
    const std::string value = option.kind == ValueKind::none
                                  ? ""
                                  : fmt::format(":{}:{}", zsh_text(option.value), zsh_action(option));
    if (option.argument) {
      text += " \\\n    " + in_quotes((option.repeated ? "*" : "1") + value);
    } else {
      for (const std::string& name : option.names)
        text += " \\\n    " + in_quotes(name + "[" + zsh_text(brief(option.text)) + "]" + value);
    }
  }
  if (outline.subcommands.empty()) return text + "\n}\n";
  text +=
      " \\\n    '1: :->subcommand' \\\n    '*:: :->rest'\n  case $state in\n    subcommand)\n      local -a "
      "names=(\n";
  for (const Outline& sub : outline.subcommands)
    text += "        " + in_quotes(sub.path.back() + ":" + zsh_text(sub.text)) + "\n";
  text += "      )\n      _describe subcommand names ;;\n    rest)\n      case $words[1] in\n";
  for (const Outline& sub : outline.subcommands)
    text += fmt::format("        {}) _{} ;;\n", sub.path.back(), title_of(sub, "_"));
  return text + "      esac ;;\n  esac\n}\n";
}

}  // namespace

std::string zsh_completion(const Outline& command) {
  std::string text = "#compdef palpate\n# zsh completion of palpate; made by 'palpate completion zsh'.\n";
  for (const Outline* outline : all_of(command)) text += "\n" + zsh_function(*outline);
  return text +
         "\nif [[ $funcstack[1] == _palpate ]]; then _palpate \"$@\"; else compdef _palpate palpate; fi\n";
}

// The script for fish.

namespace {

constexpr const char* fish_head = R"(# fish completion of palpate; made by 'palpate completion fish'.

# Whether the words before the cursor name this subcommand.
function __palpate_at
    set -l words (commandline -opc)
    set -l path palpate
    for word in $words[2..-1]
        if contains -- "$path $word" $__palpate_known
            set path "$path $word"
        end
    end
    test "$path" = "$argv"
end

complete -c palpate -f
)";

std::string fish_value(const OutlineOption& option) {
  switch (option.kind) {
    case ValueKind::none:
      return "";
    case ValueKind::word:
      return " -x -a " + in_quotes(fmt::format("{}", fmt::join(option.words, " ")));
    case ValueKind::file:
      return " -r -F";
    case ValueKind::scene:
      return " -x -k -a '(__fish_complete_suffix .json)'";
    case ValueKind::mesh:  // (fish offers files of other suffixes, too, after those of the first)
      return fmt::format(" -x -a \"(__fish_complete_suffix {} | string match -r '.*(?:/|{})\\$')\"",
                         io::mesh_extensions().front(), fmt::join(io::mesh_extensions(), "|"));
    case ValueKind::scene_or_mesh:
      return fmt::format(" -x -a \"(__fish_complete_suffix .json | string match -r '.*(?:/|{})\\$')\"",
                         fmt::join(scene_and_mesh_extensions(), "|"));
    case ValueKind::folder:
      return " -x -a '(__fish_complete_directories)'";
    case ValueKind::other:
      break;
  }
  return " -x";
}

std::string fish_option(const std::string& head, const OutlineOption& option) {
  if (option.argument) {
    return option.kind == ValueKind::other ? "" : head + fish_value(option) + "\n";
  }
  std::string line = head;
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  return line + fish_value(option) + " -d " + in_quotes(brief(option.text)) + "\n";
}

}  // namespace

std::string fish_completion(const Outline& command) {
  const std::vector<const Outline*> all = all_of(command);
  std::string text = fish_head;
  text += "set -g __palpate_known";
  for (const Outline* outline : all) {
    if (outline->path.size() > 1) text += " " + in_quotes(title_of(*outline));
  }
  text += "\n";
  for (const Outline* outline : all) {
    const std::string head = fmt::format("complete -c palpate -n \"__palpate_at {}\"", title_of(*outline));
    for (const Outline& sub : outline->subcommands)
      text += head + " -a " + sub.path.back() + " -d " + in_quotes(sub.text) + "\n";
    for (const OutlineOption& option : outline->options) text += fish_option(head, option);
  }
  return text;
}

}  // namespace palpate::app
