#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

namespace palpate::view {

/// A binary message for the page: the length of the header (uint32), the header (JSON, padded with blanks to
/// 4 bytes), then arrays of numbers of 4 bytes, all little-endian. The header lists the arrays in its
/// "arrays": [name, "f4" | "i4", values].
class Message {
 public:
  /// Begins an array of `count` numbers; returns the memory to write them to, valid until the next call.
  std::span<float> add_floats(std::string_view name, std::size_t count);
  std::span<std::int32_t> add_integers(std::string_view name, std::size_t count);

  /// The message with `header`, to which "arrays" is added.
  [[nodiscard]] std::string finish(nlohmann::ordered_json header) const;

 private:
  template <class Number>
  std::span<Number> add(std::string_view name, std::string_view type, std::size_t count);

  nlohmann::ordered_json arrays_ = nlohmann::ordered_json::array();
  std::string payload_;
};

}  // namespace palpate::view
