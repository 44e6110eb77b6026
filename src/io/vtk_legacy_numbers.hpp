#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_scanner.hpp"
#include "io/vtk_scalars.hpp"

namespace palpate::io {

/// Arrays of numbers in a VTK legacy file, which are ASCII or binary (big-endian). Every function throws
/// Error naming the line or byte where numbers are missing.
class LegacyNumbers {
 public:
  /// \param scanner  at the position of the numbers; must outlive this
  explicit LegacyNumbers(TextScanner& scanner) : scanner_(scanner) {}

  [[nodiscard]] bool binary() const { return binary_; }
  void set_binary(bool binary) { binary_ = binary; }
  /// The least size in this file of a number with this size in binary files.
  [[nodiscard]] std::size_t least_bytes(std::size_t binary_bytes) const { return binary_ ? binary_bytes : 2; }

  /// Reads the name of a number type.
  const ScalarType& read_type();
  /// The bytes of a binary array, which begin after this line.
  std::string_view read_bytes(std::size_t count, std::size_t bytes_each);
  /// Numbers of a binary array may be NaN or infinite.
  std::vector<double> reals(std::size_t count, const ScalarType& type, const char* what);
  std::vector<std::int64_t> integers(std::size_t count, const ScalarType& type, const char* what);
  void skip(std::size_t count, const ScalarType& type);
  /// Skips lines up to an empty one, if the next word is METADATA.
  void skip_metadata();

 private:
  TextScanner& scanner_;
  bool binary_ = false;
};

/// A word in upper case: keywords may be written in either case.
std::string upper_case(std::string_view word);

}  // namespace palpate::io
