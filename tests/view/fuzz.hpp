#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace palpate::test {

/// Messages that are nearly right: commands with bytes changed, cut, doubled and swapped, and plain noise.
class Fuzz {
 public:
  explicit Fuzz(std::uint64_t seed) : random_(seed) {}

  std::string message() {
    if (below(20) == 0) return noise(below(200));
    std::string text(commands_[below(commands_.size())]);
    for (std::size_t times = 1 + below(4); times > 0; --times) damage(text);
    return text;
  }
  std::size_t below(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_);
  }

 private:
  static constexpr std::array<std::string_view, 12> commands_{
      R"({"play": {"on": true}})",
      R"({"step": {}})",
      R"({"speed": {"speed": 0.5}})",
      R"({"pull": {"vertex": 3, "target": [0.1, 0.2, 0.3], "strength": 1}})",
      R"({"move_pull": {"target": [1e-3, 2, -3]}})",
      R"({"let_go": {}})",
      R"({"drive_motion": {"motion": 0, "offset": [0, 0, 0.1], "time": 0.5}})",
      R"({"resume_motion": {"motion": 0}})",
      R"({"seek": {"frame": 2}})",
      R"({"look": {"contacts": true, "cells": true}})",
      R"({"shown": {"frame": 17}})",
      R"({"change": {"gravity": [0, 0, -9.81], "contact": {"friction": 0.5, "structure": "hash"}}})"};
  static constexpr std::array<std::string_view, 8> bits_{"{",     "}",  "[[[[",    "null",
                                                         "1e309", "\"", "\\u0000", ","};

  std::string noise(std::size_t length) {
    std::string text(length, ' ');
    for (char& c : text) c = static_cast<char>(below(256));
    return text;
  }
  void damage(std::string& text) {
    if (text.empty()) return;
    const std::size_t at = below(text.size());
    switch (below(6)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.resize(at);
        break;
      case 2:
        text.erase(at, 1);
        break;
      case 3:
        text.insert(at, bits_[below(bits_.size())]);
        break;
      case 4:
        text.insert(at, text.substr(at, 10));
        break;
      default:
        text[at] = static_cast<char>('0' + below(10));
    }
  }

  std::mt19937_64 random_;
};

}  // namespace palpate::test
