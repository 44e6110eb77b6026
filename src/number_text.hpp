#pragma once

#include <array>
#include <charconv>
#include <string>

namespace palpate {

/// A number for an error message: the shortest text that reads back as the same value.
inline std::string number_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

/// A number to three digits, for messages in which the exact value does not matter.
inline std::string short_number_text(double value) {
  std::array<char, 32> text{};
  constexpr int digits = 3;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits).ptr;
  return {text.data(), end};
}

}  // namespace palpate
