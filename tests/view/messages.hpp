#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::test {

/// A binary message, read as docs/viewer-server.md describes it.
struct Read {
  nlohmann::json header;
  std::map<std::string, std::vector<float>> floats;
  std::map<std::string, std::vector<std::int32_t>> integers;
};

inline Read read_message(std::string_view bytes) {
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data(), 4);
  Read read;
  read.header = nlohmann::json::parse(bytes.substr(4, length));
  std::size_t at = 4 + length;
  const auto take = [&](auto& values, std::size_t count) {
    values.resize(count);
    std::memcpy(values.data(), bytes.substr(at, 4 * count).data(), 4 * count);
    at += 4 * count;
  };
  for (const auto& array : read.header.at("arrays")) {
    const std::string name = array.at(0);
    if (array.at(1) == "f4") {
      take(read.floats[name], array.at(2));
    } else {
      take(read.integers[name], array.at(2));
    }
  }
  if (at != bytes.size()) throw std::length_error("bytes behind the arrays");
  return read;
}

}  // namespace palpate::test
