#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// The command as data. Shell completion and manual pages are made of the same text as --help.
namespace palpate::app {

/// The kind of value of a flag or argument.
enum class ValueKind { none, word, file, scene, mesh, scene_or_mesh, folder, other };

/// A flag, or an argument.
struct OutlineOption {
  std::vector<std::string> names;  ///< such as "-h", "--help"; an argument has one name, such as "SCENE"
  bool argument = false;
  bool required = false;
  bool repeated = false;  ///< an argument that may be given several times
  std::string value;      ///< its value as --help shows it, such as "N"; empty for a switch
  ValueKind kind = ValueKind::none;
  std::vector<std::string> words;  ///< allowed words
  std::string text;
};

/// A command or subcommand.
struct Outline {
  std::vector<std::string> path;  ///< such as "palpate", "generate", "box"
  std::string text;
  std::string footer;
  std::vector<OutlineOption> options;
  std::vector<Outline> subcommands;
};

/// The outline of a command with all its subcommands.
Outline outline_of(const CLI::App& command);

/// The name of a command with those above it: "palpate generate box". Other separators give names of files
/// and functions.
std::string title_of(const Outline& outline, const std::string& separator = " ");

/// The outline and all below it; a command comes before its subcommands.
std::vector<const Outline*> all_of(const Outline& outline);

}  // namespace palpate::app
