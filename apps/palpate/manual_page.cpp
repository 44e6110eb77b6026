#include "manual_page.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <string_view>
#include <vector>

#include <palpate/version.hpp>

namespace palpate::app {
namespace {

/// Escapes text for man(7): backslashes, minus signs, and lines that would begin like a request.
std::string escaped(std::string_view text) {
  std::string result;
  bool at_start = true;
  for (const char c : text) {
    if (at_start && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
    at_start = c == '\n';
  }
  return result;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text) {
    if (c == '\n') {
      lines.emplace_back();
    } else {
      lines.back() += c;
    }
  }
  return lines;
}

std::string capitals(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string synopsis(const Outline& outline) {
  std::string text = "\\fB" + escaped(title_of(outline)) + "\\fR";
  const auto is_flag = [](const OutlineOption& option) { return !option.argument; };
  if (std::ranges::any_of(outline.options, is_flag)) text += " [\\fIOPTIONS\\fR]";
  for (const OutlineOption& option : outline.options) {
    if (!option.argument) continue;
    const std::string name = "\\fI" + escaped(option.value) + "\\fR" + (option.repeated ? " ..." : "");
    text += option.required ? " " + name : " [" + name + "]";
  }
  if (!outline.subcommands.empty()) text += " \\fISUBCOMMAND\\fR";
  return text + "\n";
}

/// Arguments or flags, each with its description.
std::string described(const Outline& outline, bool arguments) {
  std::string text;
  for (const OutlineOption& option : outline.options) {
    if (option.argument != arguments) continue;
    std::string head;
    for (const std::string& name : option.names)
      head += (head.empty() ? "\\fB" : ", \\fB") + escaped(name) + "\\fR";
    if (!option.argument && !option.value.empty()) head += " \\fI" + escaped(option.value) + "\\fR";
    text += ".TP\n" + head + "\n" + escaped(option.text) + "\n";
  }
  if (text.empty()) return text;
  return (arguments ? ".SH ARGUMENTS\n" : ".SH OPTIONS\n") + text;
}

/// The footer of --help: indented lines stay as they are, all others are paragraphs.
std::string footer(const std::string& text) {
  std::string page;
  bool shows_code = false;
  const auto end_code = [&] {
    if (shows_code) page += ".EE\n";
    shows_code = false;
  };
  for (const std::string& line : lines_of(text)) {
    if (line == "Examples:") {
      page += ".SH EXAMPLES\n";
    } else if (line.starts_with("  ")) {
      if (!shows_code) page += ".EX\n";
      shows_code = true;
      page += escaped(line) + "\n";
    } else if (line.empty()) {
      end_code();
      page += ".PP\n";
    } else {
      end_code();
      page += escaped(line) + "\n";
    }
  }
  end_code();
  return page;
}

std::string subcommands(const Outline& outline) {
  std::string text;
  for (const Outline& sub : outline.subcommands)
    text += ".TP\n\\fB" + escaped(sub.path.back()) + "\\fR\n" + escaped(sub.text) + "\n";
  return text.empty() ? text : ".SH SUBCOMMANDS\n" + text;
}

/// The names of all other pages of the command.
std::string see_also(const Outline& outline, const Outline& whole) {
  std::string text;
  for (const Outline* other : all_of(whole)) {
    if (other->path == outline.path) continue;
    if (!text.empty()) text += " ,\n";
    text += ".BR " + escaped(title_of(*other, "-")) + " (1)";
  }
  return text.empty() ? text : ".SH SEE ALSO\n" + text + "\n";
}

}  // namespace

std::string manual_page(const Outline& outline, const Outline& whole) {
  const std::string name = title_of(outline, "-");
  std::string page =
      fmt::format(".TH {} 1 \"\" \"palpate {}\" \"Palpate\"\n", capitals(escaped(name)), PALPATE_VERSION);
  page += ".SH NAME\n" + escaped(name) + " \\- " + escaped(outline.text) + "\n";
  page += ".SH SYNOPSIS\n" + synopsis(outline);
  page +=
      subcommands(outline) + described(outline, true) + described(outline, false) + footer(outline.footer);
  page +=
      ".SH EXIT STATUS\n0: done. 1: the work failed or was interrupted; what is done is kept. 2: bad usage "
      "or input.\n";
  page += ".SH ENVIRONMENT\n.TP\n\\fBNO_COLOR\\fR\nno colours on a terminal\n";
  return page + see_also(outline, whole);
}

}  // namespace palpate::app
