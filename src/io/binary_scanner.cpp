#include "io/binary_scanner.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>

#include <palpate/error.hpp>

namespace palpate::io {

template <class Number>
Number BinaryScanner::take(const char* what) {
  last_ = position_;
  if (bytes_left() < sizeof(Number)) {
    fail(fmt::format("{} bytes and the end of the file", bytes_left()),
         fmt::format("{} bytes ({})", sizeof(Number), what));
  }
  std::array<char, sizeof(Number)> raw;
  std::memcpy(raw.data(), bytes_.data() + position_, raw.size());
  if (swapped_) std::reverse(raw.begin(), raw.end());
  position_ += raw.size();
  return std::bit_cast<Number>(raw);
}

std::int64_t BinaryScanner::integer32(const char* what) {
  return take<std::int32_t>(what);
}
std::int64_t BinaryScanner::integer64(const char* what) {
  return take<std::int64_t>(what);
}

double BinaryScanner::number(const char* what) {
  const auto value = take<double>(what);
  if (!std::isfinite(value)) fail(fmt::format("{}", value), fmt::format("a finite number ({})", what));
  return value;
}

Vec3 BinaryScanner::point() {
  Vec3 result;
  result.x = number("the x of a point");
  result.y = number("the y of a point");
  result.z = number("the z of a point");
  return result;
}

Index BinaryScanner::count(const char* what, std::size_t bytes_each) {
  const std::int64_t value = integer64(what);
  const auto room = static_cast<std::int64_t>(bytes_left() / bytes_each);
  const auto most = std::min<std::int64_t>(room, std::numeric_limits<Index>::max());
  if (value < 0 || value > most) {
    fail(fmt::format("{}", value),
         fmt::format("{} from 0 to {}, as many as the rest of the file can hold", what, most));
  }
  return static_cast<Index>(value);
}

void BinaryScanner::fail(const std::string& found, const std::string& expected) const {
  throw Error(source_, fmt::format("byte {}", last_), found, expected);
}

}  // namespace palpate::io
