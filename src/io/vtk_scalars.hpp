#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace palpate::io {

/// A type of number in VTK files.
struct ScalarType {
  enum class Kind { integer, natural, real };
  Kind kind = Kind::real;
  std::size_t bytes = 0;
};

/// The type of that name: as in XML files ("Float32", "UInt8") or as in legacy files ("float",
/// "unsigned_char"); nullptr if there is none, or it is not a number of whole bytes ("bit", "string").
const ScalarType* scalar_type(std::string_view name);

/// Decodes numbers; `bytes` must be a multiple of their size. Unsigned numbers above int64 become -1, which
/// is refused as index or count.
std::vector<double> decode_reals(std::string_view bytes, const ScalarType& type, bool swapped);
std::vector<std::int64_t> decode_integers(std::string_view bytes, const ScalarType& type, bool swapped);

}  // namespace palpate::io
