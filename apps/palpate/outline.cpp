#include "outline.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace palpate::app {
namespace {

/// Splits alternatives such as "a|b|N".
std::vector<std::string> alternatives(const std::string& value) {
  std::vector<std::string> parts(1);
  for (const char c : value) {
    if (c == '|') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

/// The alternatives that are literal words: placeholders are in capitals.
std::vector<std::string> literal_words(const std::string& value) {
  std::vector<std::string> words = alternatives(value);
  std::erase_if(words, [](const std::string& word) {
    return word.empty() ||
           !std::ranges::all_of(word, [](unsigned char c) { return std::islower(c) != 0 || c == '-'; });
  });
  return words;
}

ValueKind kind_of(const std::string& value, const std::vector<std::string>& words) {
  if (value.empty()) return ValueKind::none;
  if (!words.empty()) return ValueKind::word;
  const std::vector<std::string> parts = alternatives(value);
  const auto has = [&](std::string_view name) { return std::ranges::count(parts, name) > 0; };
  if (parts.size() == 1 && has("SCENE")) return ValueKind::scene;
  if (parts.size() == 1 && has("MESH")) return ValueKind::mesh;
  const bool only_these = std::ranges::all_of(
      parts, [](const std::string& part) { return part == "SCENE" || part == "MESH" || part == "DIR"; });
  if (only_these && has("SCENE") && has("MESH")) return ValueKind::scene_or_mesh;
  if (has("FILE") || has("SCENE") || has("MESH") || has("INPUT")) return ValueKind::file;
  return has("DIR") || has("FOLDER") ? ValueKind::folder : ValueKind::other;
}

OutlineOption option_of(const CLI::Option& option) {
  OutlineOption result;
  result.text = option.get_description();
  result.argument = option.get_positional();
  result.required = option.get_required();
  result.repeated = result.argument && option.get_items_expected_max() > 1;
  if (result.argument) {
    result.names = {option.get_name(true)};
    const bool typed = !option.get_type_name().empty();
    result.value = typed ? option.get_type_name() : result.names.front();
  } else {
    for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
    if (option.get_items_expected_max() > 0) result.value = option.get_type_name();
  }
  result.words = literal_words(result.value);
  result.kind = kind_of(result.value, result.words);
  return result;
}

Outline outline_at(const CLI::App& app, std::vector<std::string> path) {
  path.push_back(app.get_name());
  Outline outline{.path = path,
                  .text = app.get_description(),
                  .footer = app.get_footer(),
                  .options = {},
                  .subcommands = {}};
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty())
      outline.options.push_back(option_of(*option));  // hidden flags have no group
  }
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    outline.subcommands.push_back(outline_at(*sub, path));
  return outline;
}

}  // namespace

Outline outline_of(const CLI::App& command) {
  return outline_at(command, {});
}

std::string title_of(const Outline& outline, const std::string& separator) {
  std::string title;
  for (const std::string& word : outline.path) title += (title.empty() ? "" : separator) + word;
  return title;
}

std::vector<const Outline*> all_of(const Outline& outline) {
  std::vector<const Outline*> all{&outline};
  for (const Outline& sub : outline.subcommands) {
    const auto below = all_of(sub);
    all.insert(all.end(), below.begin(), below.end());
  }
  return all;
}

}  // namespace palpate::app
