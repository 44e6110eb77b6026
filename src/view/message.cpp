#include "view/message.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace palpate::view {

static_assert(std::endian::native == std::endian::little, "pages read little-endian numbers");

template <class Number>
std::span<Number> Message::add(std::string_view name, std::string_view type, std::size_t count) {
  arrays_.push_back({name, type, count});
  const std::size_t begin = payload_.size();
  payload_.resize(begin + count * sizeof(Number));
  return {reinterpret_cast<Number*>(payload_.data() + begin), count};  // all sizes are multiples of 4
}

std::span<float> Message::add_floats(std::string_view name, std::size_t count) {
  return add<float>(name, "f4", count);
}

std::span<std::int32_t> Message::add_integers(std::string_view name, std::size_t count) {
  return add<std::int32_t>(name, "i4", count);
}

std::string Message::finish(nlohmann::ordered_json header) const {
  header["arrays"] = arrays_;
  std::string text = header.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  text.append((4 - text.size() % 4) % 4, ' ');
  const auto length = static_cast<std::uint32_t>(text.size());
  std::array<char, sizeof(length)> bytes{};
  std::memcpy(bytes.data(), &length, sizeof(length));
  std::string message(bytes.begin(), bytes.end());
  message.reserve(bytes.size() + text.size() + payload_.size());
  return message.append(text).append(payload_);
}

}  // namespace palpate::view
