#include "numbers.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <fmt/format.h>

namespace palpate::app {

std::string exact_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string short_text(double value) {
  return fmt::format("{:.4g}", value);
}

std::string counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string shortened(const std::string& name, std::size_t columns) {
  std::vector<std::string> characters;
  for (const char c : name) {
    constexpr unsigned continues = 0x80;  // 10xxxxxx
    constexpr unsigned mask = 0xc0;
    if (characters.empty() || (static_cast<unsigned char>(c) & mask) != continues) characters.emplace_back();
    characters.back() += c;
  }
  if (characters.size() <= columns) return name;
  constexpr std::string_view dots = "...";
  const std::size_t kept = columns - dots.size();
  std::string text;
  for (std::size_t i = 0; i < kept - kept / 2; ++i) text += characters[i];
  text += dots;
  for (std::size_t i = characters.size() - kept / 2; i < characters.size(); ++i) text += characters[i];
  return text;
}

std::string shown_name(const std::string& name) {
  constexpr std::size_t columns = 40;
  return shortened(name, columns);
}

std::string in_quotes(std::string_view text) {
  std::string result(1, '\'');
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      result += c;
    }
  }
  return result.append(1, '\'');
}

std::string shell_word(std::string_view text) {
  const auto is_plain = [](unsigned char c) {
    constexpr unsigned char ascii = 0x80;
    return c >= ascii || std::isalnum(c) != 0 ||
           std::string_view("_-+=:,./@%").find(static_cast<char>(c)) != std::string_view::npos;
  };
  if (!text.empty() && std::ranges::all_of(text, is_plain)) return std::string(text);
  return in_quotes(text);
}

std::string path_word(std::string_view path) {
  return shell_word(path.starts_with('-') ? fmt::format("./{}", path) : std::string(path));
}

std::string quoted_command(std::string_view command) {
  const char quote = command.find('\'') == std::string_view::npos ? '\'' : '"';
  return fmt::format("{0}{1}{0}", quote, command);
}

std::string quoted_command(std::string_view words, std::string_view file) {
  return quoted_command(fmt::format("palpate {} {}", words, path_word(file)));
}

nlohmann::ordered_json to_json(const Vec3& v) {
  return nlohmann::ordered_json::array({v.x, v.y, v.z});
}

std::string utf8_text(const std::string& text) {
  using nlohmann::json;
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

}  // namespace palpate::app
