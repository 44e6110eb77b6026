#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/vtu_structure.hpp"

namespace palpate::io {

/// Reads the numbers of DataArrays. Every function throws Error if the file does not hold exactly `count`
/// numbers for the array; in ASCII it names the line. Allocates no more than a fixed multiple of the file's
/// size.
class VtuArrays {
 public:
  /// \param text  the whole file, not copied
  VtuArrays(const std::string& source, std::string_view text, const VtuStructure& structure)
      : source_(source), text_(text), structure_(structure) {}

  /// Finite numbers.
  [[nodiscard]] std::vector<double> reals(const VtuArray& array, std::int64_t count) const;
  /// Numbers; in binary data they may be NaN or infinite.
  [[nodiscard]] std::vector<double> reals_or_nan(const VtuArray& array, std::int64_t count) const;
  [[nodiscard]] std::vector<std::int64_t> integers(const VtuArray& array, std::int64_t count) const;

 private:
  [[nodiscard]] std::string bytes(const VtuArray& array, std::int64_t count) const;

  std::string source_;
  std::string_view text_;
  const VtuStructure& structure_;
};

}  // namespace palpate::io
