#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <palpate/types.hpp>

namespace palpate::io {

/// Reads numbers from bytes of either byte order; like TextScanner, for binary parts of a file.
///
/// Every function throws Error naming the source and byte where the bytes end too early or the number is not
/// allowed.
class BinaryScanner {
 public:
  /// \param bytes    the whole file, not copied
  /// \param swapped  whether the file's byte order is not this machine's
  BinaryScanner(std::string source, std::string_view bytes, std::size_t position, bool swapped)
      : source_(std::move(source)), bytes_(bytes), position_(position), swapped_(swapped) {}

  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t bytes_left() const { return bytes_.size() - position_; }

  /// The next 32-bit or 64-bit signed integer; `what` names the expected item in messages.
  std::int64_t integer32(const char* what);
  std::int64_t integer64(const char* what);
  /// A finite float64.
  double number(const char* what);
  /// Three finite float64.
  Vec3 point();
  /// A 64-bit count of items of at least `bytes_each` bytes: refused where the rest of the file cannot hold
  /// them.
  Index count(const char* what, std::size_t bytes_each);

  /// Throws Error that names the first byte of the last number read.
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;

 private:
  template <class Number>
  Number take(const char* what);

  std::string source_;
  std::string_view bytes_;
  std::size_t position_;
  std::size_t last_ = 0;
  bool swapped_;
};

}  // namespace palpate::io
