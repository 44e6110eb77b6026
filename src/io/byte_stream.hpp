#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace palpate::io {

/// Reads bytes in parts from a text that has them raw or in base64.
///
/// Base64 may be padded in the middle, since VTK pads its header and its data separately; blanks between are
/// skipped.
class ByteStream {
 public:
  ByteStream(std::string_view text, bool is_base64) : text_(text), is_base64_(is_base64) {}

  /// The next n bytes; fewer where the text, or what is valid base64 in it, ends. Allocates no more than it
  /// returns.
  std::string take(std::size_t n);

 private:
  bool decode_group();

  std::string_view text_;
  bool is_base64_;
  std::string decoded_;  ///< bytes of the last group that were not returned yet
};

}  // namespace palpate::io
