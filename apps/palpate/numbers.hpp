#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/types.hpp>

#include "scene/scene.hpp"

/// Numbers, units and text as the command writes them.
namespace palpate::app {

/// The shortest text that reads back as the same number: for files.
std::string exact_text(double value);

/// Four significant digits: for people.
std::string short_text(double value);

/// A count with its noun: "1 tet", "5 tets".
std::string counted(std::size_t count, std::string_view noun);

/// A name in at most `columns` columns (>= 4): a longer one loses its middle, "mandible ...left". A character
/// of UTF-8 counts as a column and stays whole.
std::string shortened(const std::string& name, std::size_t columns);

/// A name for messages and tables, at most 40 columns. Files and JSON contain the whole name.
std::string shown_name(const std::string& name);

/// The text in single quotes, for a shell.
std::string in_quotes(std::string_view text);

/// The text as one word of a shell: in single quotes if it has other characters than letters, digits and
/// those of plain paths.
std::string shell_word(std::string_view text);

/// A path as one word of a command, for a shell: "./-a.json" for "-a.json", which would be a flag.
std::string path_word(std::string_view path);

/// A command for the user to copy, in quotes that it does not contain: 'palpate view liver.json', or "palpate
/// view 'my liver.json'".
std::string quoted_command(std::string_view command);
/// The command line of "palpate" with these words and a file.
std::string quoted_command(std::string_view words, std::string_view file);

nlohmann::ordered_json to_json(const Vec3& v);

/// Valid UTF-8 for JSON: other bytes are replaced (file names may contain any).
std::string utf8_text(const std::string& text);

}  // namespace palpate::app
