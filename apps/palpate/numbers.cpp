#include "numbers.hpp"

#include <array>
#include <charconv>
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

nlohmann::ordered_json to_json(const Vec3& v) {
  return nlohmann::ordered_json::array({v.x, v.y, v.z});
}

std::string utf8_text(const std::string& text) {
  using nlohmann::json;
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

}  // namespace palpate::app
