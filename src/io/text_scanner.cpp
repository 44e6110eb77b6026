#include "io/text_scanner.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <system_error>

#include <palpate/error.hpp>

namespace palpate::io {
namespace {

constexpr bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
constexpr bool is_space(char c) {
  return is_blank(c) || c == '\n';
}

/// from_chars() takes no leading plus, but files have them.
std::string_view without_plus(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

/// For a number that from_chars() reports as out of range: whether it is too small (and not too large).
bool is_tiny(std::string_view word) {
  const auto exponent = word.find_first_of("eE");
  if (exponent != std::string_view::npos) return word.substr(exponent + 1).starts_with('-');
  return word.starts_with("0.") || word.starts_with("-0.") || word.starts_with('.') || word.starts_with("-.");
}

std::string line_name(std::string_view text, std::size_t position) {
  const auto begin = text.begin();
  return fmt::format("line {}", 1 + std::count(begin, begin + static_cast<std::ptrdiff_t>(position), '\n'));
}

}  // namespace

std::string in_quotes(std::string_view word) {
  constexpr std::size_t longest = 40;
  std::string result = "\"";
  for (const char c : word.substr(0, longest)) {
    if (c >= ' ' && c <= '~') {
      result += c;
    } else {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    }
  }
  return result + (word.size() > longest ? "\"…" : "\"");
}

void require_line_end(const std::string& source, std::string_view text) {
  if (text.empty() || is_space(text.back())) return;
  throw Error(source, line_name(text, text.size()), "the end of the file inside the last line",
              "a line end (without one, the last number may be cut off)");
}

void TextScanner::skip_comment() {
  position_ = std::min(text_.find('\n', position_), text_.size());
}

bool TextScanner::at_line_end() {
  while (position_ < text_.size() && is_blank(text_[position_])) ++position_;
  if (comment_ != '\0' && position_ < text_.size() && text_[position_] == comment_) skip_comment();
  return position_ == text_.size() || text_[position_] == '\n';
}

bool TextScanner::at_end() {
  while (at_line_end() && position_ < text_.size()) ++position_;
  return position_ == text_.size();
}

void TextScanner::skip_line() {
  const auto end = text_.find('\n', position_);
  position_ = end == std::string_view::npos ? text_.size() : end + 1;
}

std::string_view TextScanner::peek() {
  if (at_end()) return {};
  std::size_t end = position_;
  while (end < text_.size() && !is_space(text_[end]) && (comment_ == '\0' || text_[end] != comment_)) ++end;
  return text_.substr(position_, end - position_);
}

std::string_view TextScanner::word(const char* what) {
  const std::string_view next = peek();
  if (next.empty()) fail_end(what);
  position_ += next.size();
  last_ = next;
  return next;
}

void TextScanner::keyword(std::string_view expected) {
  if (peek().empty()) fail_end(std::string(expected));
  if (word("") != expected) fail(std::string(expected));
}

double TextScanner::number(const char* what) {
  const std::string_view digits = without_plus(word(what));
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size() || error == std::errc::invalid_argument) {
    fail(fmt::format("a number ({})", what));
  }
  if (error == std::errc::result_out_of_range) {
    if (!is_tiny(digits)) fail(fmt::format("a finite number ({})", what));
    return digits.starts_with('-') ? -0.0 : 0.0;
  }
  if (!std::isfinite(value)) fail(fmt::format("a finite number ({})", what));
  return value;
}

std::int64_t TextScanner::integer(const char* what) {
  const std::string_view digits = without_plus(word(what));
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size()) {
    fail(fmt::format("an integer ({})", what));
  }
  return value;
}

std::int64_t TextScanner::integer(const char* what, std::int64_t low, std::int64_t high) {
  const std::int64_t value = integer(what);
  if (value < low || value > high) fail(fmt::format("{} from {} to {}", what, low, high));
  return value;
}

Vec3 TextScanner::point() {
  Vec3 result;
  result.x = number("the x of a point");
  result.y = number("the y of a point");
  result.z = number("the z of a point");
  return result;
}

Index TextScanner::count(const char* what, std::size_t bytes_each) {
  const std::int64_t value = integer(what);
  // One byte more than is left, because the last item needs no separator.
  const std::size_t room = (bytes_left() + 1) / bytes_each;
  const auto most =
      std::min<std::int64_t>(static_cast<std::int64_t>(room), std::numeric_limits<Index>::max());
  if (value < 0 || value > most) {
    fail(fmt::format("{} from 0 to {}, as many as the rest of the file can hold", what, most));
  }
  return static_cast<Index>(value);
}

Index TextScanner::point_index(Index first, Index n_points) {
  const std::int64_t number = integer("a point number");
  if (number < first || number - first >= n_points) {
    fail(fmt::format("point number {}", number),
         fmt::format("one from {} to {}", first, static_cast<std::int64_t>(first) + n_points - 1));
  }
  return static_cast<Index>(number - first);
}

void TextScanner::fail(const std::string& expected) const {
  fail(in_quotes(last_), expected);
}

void TextScanner::fail(const std::string& found, const std::string& expected) const {
  const auto position = last_.data() == nullptr ? 0 : static_cast<std::size_t>(last_.data() - text_.data());
  throw Error(source_, line_name(text_, position), found, expected);
}

void TextScanner::fail_end(const std::string& expected) const {
  throw Error(source_, line_name(text_, text_.size()), "the end of the file", expected);
}

}  // namespace palpate::io
