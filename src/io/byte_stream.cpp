#include "io/byte_stream.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace palpate::io {
namespace {

constexpr std::uint32_t not_a_digit = 64;

constexpr auto digit_values = [] {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<std::uint8_t, 256> values{};
  values.fill(not_a_digit);
  for (std::size_t i = 0; i < digits.size(); ++i) {
    values[static_cast<unsigned char>(digits[i])] = static_cast<std::uint8_t>(i);
  }
  return values;
}();

constexpr bool is_between_digits(char c) {
  return c == ' ' || c == '\n' || c == '\r' || c == '\t';
}

}  // namespace

/// Decodes the next four digits; returns false and reads nothing where there are none.
bool ByteStream::decode_group() {
  std::uint32_t bits = 0;
  std::size_t digits = 0;
  std::size_t padding = 0;
  std::size_t position = 0;
  for (; digits + padding < 4 && position < text_.size(); ++position) {
    const char c = text_[position];
    if (is_between_digits(c)) continue;
    const std::uint32_t value = digit_values[static_cast<unsigned char>(c)];
    const bool pads = c == '=' && digits >= 2;
    if (!pads && (value == not_a_digit || padding > 0)) return false;
    bits = bits << 6U | (pads ? 0U : value);
    ++(pads ? padding : digits);
  }
  if (digits + padding < 4) return false;
  text_.remove_prefix(position);
  for (std::size_t i = 0; i + 1 < digits; ++i) decoded_ += static_cast<char>(bits >> (16U - 8U * i) & 0xFFU);
  return true;
}

std::string ByteStream::take(std::size_t n) {
  if (!is_base64_) {
    std::string result(text_.substr(0, n));
    text_.remove_prefix(result.size());
    return result;
  }
  std::string result;
  result.reserve(std::min(n, text_.size() / 4 * 3 + decoded_.size()));
  while (result.size() < n && (!decoded_.empty() || decode_group())) {
    const std::size_t part = std::min(n - result.size(), decoded_.size());
    result.append(decoded_, 0, part);
    decoded_.erase(0, part);
  }
  return result;
}

}  // namespace palpate::io
