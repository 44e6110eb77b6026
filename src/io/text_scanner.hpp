#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <palpate/types.hpp>

namespace palpate::io {

/// Splits a text into words and numbers, the same in every locale, and gives the line of each for messages.
///
/// Words are separated by blanks and line ends (LF or CRLF). Every reading function throws Error naming the
/// source and line where the item is missing; `what` names the expected item in messages ("the x of point
/// 3").
class TextScanner {
 public:
  /// \param source   the file's name for messages
  /// \param text     not copied; must outlive the scanner and the words that it returns
  /// \param comment  a character that starts a comment up to the end of the line; '\0' for none
  TextScanner(std::string source, std::string_view text, char comment = '\0')
      : source_(std::move(source)), text_(text), comment_(comment) {}

  [[nodiscard]] const std::string& source() const { return source_; }
  [[nodiscard]] std::string_view text() const { return text_; }
  /// Offset of the next byte to read.
  [[nodiscard]] std::size_t position() const { return position_; }
  void set_position(std::size_t position) { position_ = position; }
  [[nodiscard]] std::size_t bytes_left() const { return text_.size() - position_; }

  /// Skips blanks, line ends and comments; true if nothing is left.
  bool at_end();
  /// Skips blanks and a comment, but no line end; true if nothing is left on the line.
  bool at_line_end();
  /// Moves to after the next line end (or to the end of the text).
  void skip_line();

  /// The next word; `what`: see the class.
  std::string_view word(const char* what);
  /// The next word, without advancing; empty at the end of the text.
  std::string_view peek();
  /// Reads the next word, which must be `expected`.
  void keyword(std::string_view expected);
  /// A finite number. Too small for a double is 0, too large is refused.
  double number(const char* what);
  std::int64_t integer(const char* what);
  /// An integer in [low, high].
  std::int64_t integer(const char* what, std::int64_t low, std::int64_t high);
  /// Three finite numbers.
  Vec3 point();
  /// Reads a count of items of at least `bytes_each` bytes each: refused where the rest of the text cannot
  /// hold them.
  Index count(const char* what, std::size_t bytes_each);
  /// Reads a point number in [first, first + n_points) and subtracts `first`.
  Index point_index(Index first, Index n_points);

  /// Throws Error for the last word: found that word, expected this.
  [[noreturn]] void fail(const std::string& expected) const;
  /// Throws Error at the line of the last word.
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;
  /// Throws Error for a text that ends too early.
  [[noreturn]] void fail_end(const std::string& expected) const;

 private:
  void skip_comment();

  std::string source_;
  std::string_view text_;
  char comment_;
  std::size_t position_ = 0;
  std::string_view last_;  ///< the last word; a view into text_, from which its line is computed when needed
};

/// A word from a file in double quotes, shortened, with unprintable bytes as \xNN, so that a message stays
/// one line.
std::string in_quotes(std::string_view word);

/// Throws Error for a text that ends directly after a word. For formats without an end mark: a file cut
/// inside its last number would otherwise pass as a whole one with another number.
void require_line_end(const std::string& source, std::string_view text);

}  // namespace palpate::io
