#include "scene/json_text.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

namespace palpate {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::size_t longest_excerpt = 60;

std::string shortened(std::string text) {
  if (text.size() > longest_excerpt) text = text.substr(0, longest_excerpt) + "...";
  return text;
}

/// "line L, column C" of a byte of the text; both count from 1.
std::string place_of(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t last_break = before.rfind('\n');
  const std::size_t column = last_break == std::string_view::npos ? byte + 1 : byte - last_break;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

/// First byte of the token that ends before byte `end`. nlohmann's token is exact for strings and numbers.
/// Before other tokens it may contain older text, so only the letters at its end are used.
std::size_t token_begin(std::string_view text, std::size_t end, const std::string& token, bool is_word) {
  end = std::min(end, text.size());
  std::size_t begin = end > 0 ? end - 1 : 0;
  const bool is_exact =
      !token.empty() && token.find_first_of("[{") != 0 && text.substr(0, end).ends_with(token) &&
      (json::accept(token) || token.find_first_not_of("+-.eE0123456789") == std::string::npos);
  if (is_exact) return end - token.size();
  while (is_word && begin > 0 && std::isalnum(static_cast<unsigned char>(text[begin - 1])) != 0) --begin;
  return begin;
}

/// Splits nlohmann's message "[...] ... - FOUND; last read: '...'; expected EXPECTED" into found and
/// expected.
std::pair<std::string, std::string> found_and_expected(std::string message) {
  std::string expected = "JSON";
  if (const auto at = message.rfind("; expected "); at != std::string::npos) {
    expected = message.substr(at + 11);
    message.resize(at);
  }
  if (const auto at = message.find(" - "); at != std::string::npos) {
    message.erase(0, at + 3);
  } else if (const auto bracket = message.find("] "); bracket != std::string::npos) {
    message.erase(0, bracket + 2);
  }
  if (message.starts_with("unexpected ")) message.erase(0, 11);
  return {shortened(std::move(message)), std::move(expected)};
}

/// Builds the document from the parser's events. So a repeated key is found before the second value replaces
/// the first, and errors have a position.
class Builder {
 public:
  Builder(std::string_view text, const std::string& source) : text_(text), source_(source) {}
  json take() { return std::move(root_); }

  bool null() { return scalar(nullptr); }
  bool boolean(bool value) { return scalar(value); }
  bool number_integer(json::number_integer_t value) { return scalar(value); }
  bool number_unsigned(json::number_unsigned_t value) { return scalar(value); }
  bool number_float(json::number_float_t value, const std::string&) { return scalar(value); }
  bool string(std::string& value) { return scalar(std::move(value)); }
  bool binary(json::binary_t&) { return false; }  // JSON text has no binary values
  bool start_object(std::size_t) { return open(json::object()); }
  bool start_array(std::size_t) { return open(json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }

  bool key(std::string& name) {
    if (open_.back()->contains(name)) {
      throw Error(source_, key_path(path(), name), "the key twice in one object", "it once");
    }
    keys_.back() = name;
    return true;
  }

  bool parse_error(std::size_t position, const std::string& last_token, const json::exception& problem) {
    auto [found, expected] = found_and_expected(problem.what());
    if (problem.id == 406) {
      found = shortened(last_token);
      expected = "a number that a double can hold";
    }
    const bool is_word = found.starts_with("invalid literal");
    if (is_word) found = "invalid literal";  // the rest of nlohmann's message may contain older text
    throw Error(source_, place_of(text_, token_begin(text_, position, last_token, is_word)), found, expected);
  }

 private:
  json* add(json value) {
    if (open_.empty()) return &(root_ = std::move(value));
    json& parent = *open_.back();
    if (parent.is_array()) return &parent.emplace_back(std::move(value));
    return &(parent[keys_.back()] = std::move(value));
  }
  bool scalar(json value) {
    add(std::move(value));
    return true;
  }
  bool open(json value) {
    // Only the last element of a container can be open, so these pointers stay valid while they are used.
    open_.push_back(add(std::move(value)));
    keys_.emplace_back();
    return true;
  }
  bool close() {
    open_.pop_back();
    keys_.pop_back();
    return true;
  }
  /// Path of the innermost open object.
  [[nodiscard]] std::string path() const {
    std::string path;
    for (std::size_t level = 0; level + 1 < open_.size(); ++level) {
      const json& container = *open_[level];
      path = container.is_array() ? element_path(path, container.size() - 1) : key_path(path, keys_[level]);
    }
    return path;
  }

  std::string_view text_;
  const std::string& source_;
  json root_;
  std::vector<json*> open_;
  std::vector<std::string> keys_;
};

std::string dump(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

std::string on_one_line(const ordered_json& value) {
  if (!value.is_structured()) return dump(value);
  std::string line = value.is_object() ? "{" : "[";
  for (auto item = value.begin(); item != value.end(); ++item) {
    if (item != value.begin()) line += ", ";
    if (value.is_object()) line += dump(item.key()) + ": ";
    line += on_one_line(*item);
  }
  return line + (value.is_object() ? "}" : "]");
}

void append(std::string& text, const ordered_json& value, std::size_t indent, std::size_t used) {
  constexpr std::size_t width = 109;  // leaves room for a comma
  const std::string line = on_one_line(value);
  if (!value.is_structured() || value.empty() || (indent > 0 && used + line.size() <= width)) {
    text += line;
    return;
  }
  const std::string margin(indent + 2, ' ');
  text += value.is_object() ? "{" : "[";
  for (auto item = value.begin(); item != value.end(); ++item) {
    const std::string key = value.is_object() ? dump(item.key()) + ": " : "";
    text += (item == value.begin() ? "\n" : ",\n") + margin + key;
    append(text, *item, indent + 2, margin.size() + key.size());
  }
  text += "\n" + std::string(indent, ' ') + (value.is_object() ? "}" : "]");
}

}  // namespace

json parse_json(std::string_view text, const std::string& source) {
  if (const auto end = text.find('\0'); end != std::string_view::npos)  // the parser would stop at a NUL
    throw Error(source, place_of(text, end), "a NUL byte", "text");
  Builder builder(text, source);
  constexpr bool strict = true;
  constexpr bool ignore_comments = true;
  json::sax_parse(text.begin(), text.end(), &builder, json::input_format_t::json, strict, ignore_comments);
  return builder.take();
}

std::string format_json(const ordered_json& value) {
  std::string text;
  append(text, value, 0, 0);
  return text + "\n";
}

std::string key_path(const std::string& path, std::string_view key) {
  const auto plain = [](char c) {
    return c == '_' || c == '-' || c == '$' || std::isalnum(static_cast<unsigned char>(c)) != 0;
  };
  const bool is_name = !key.empty() && std::all_of(key.begin(), key.end(), plain);
  const std::string name = is_name ? std::string(key) : shortened(dump(std::string(key)));
  return path.empty() ? name : path + "." + name;
}

std::string element_path(const std::string& path, std::size_t index) {
  return path + "[" + std::to_string(index) + "]";
}

std::string describe_json(const json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  return shortened(value.dump(-1, ' ', false, json::error_handler_t::replace));
}

}  // namespace palpate
