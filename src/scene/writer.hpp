#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "scene/fields.hpp"
#include "scene/values.hpp"

namespace palpate::scene_format {

/// Visitor of fields.hpp that writes an object as JSON. With `defaults` (the JSON of a default object) it
/// leaves out equal values; if `brief`, also in nested objects, except for values that users change first.
class Writer {
 public:
  explicit Writer(std::string path, const nlohmann::ordered_json* defaults = nullptr, bool brief = false)
      : path_(std::move(path)), defaults_(defaults), brief_(brief) {}
  nlohmann::ordered_json take() { return std::move(object_); }

  template <class T>
  void field(std::string_view key, const T& value, const Limits& = any) {
    // An empty text means the same as a missing key. The reader refuses it.
    if constexpr (std::is_same_v<T, std::string>) {
      if (value.empty()) return;
    }
    put(key, encode(key_path(path_, key), value));
  }
  template <class Known>
  void unit(std::string_view key, const std::string& value, const Known&) {
    field(key, value);
  }
  template <class T>
  void required(std::string_view key, T& value, const Limits& = any) {
    object_[std::string(key)] = encode_new(key_path(path_, key), value);
  }
  template <class T>
  void optional(std::string_view key, std::optional<T>& value, const Limits& = any) {
    if (value) required(key, *value);
  }
  static void ignored(std::string_view) {}
  template <class Enum>
  void choice(std::string_view key, Enum value, std::span<const std::string_view> names) {
    put(key, names[static_cast<std::size_t>(value)]);
  }
  /// A name that sets defaults: writes the values that result from it, not the name.
  template <class Enum>
  static void preset(std::string_view, const std::optional<Enum>&, std::span<const std::string_view>) {}
  template <class Enum>
  void words_or_number(std::string_view key, const std::variant<Enum, double>& value,
                       std::span<const std::string_view> names, const Limits&) {
    if (const double* number = std::get_if<double>(&value)) return field(key, *number);
    choice(key, std::get<Enum>(value), names);
  }
  template <class Number>
  void word_or_number(std::string_view key, const std::optional<Number>& value, std::string_view word,
                      const Limits&) {
    if (value) return field(key, *value);
    put(key, word);
  }
  void scale(std::string_view key, const Vec3& value, const Limits&) {
    if (value.x == value.y && value.x == value.z) return field(key, value.x);
    field(key, value);
  }
  template <class T>
  void object(std::string_view key, T& value) {
    const std::string name(key);
    if (brief_ && defaults_ != nullptr && defaults_->contains(name) && !changes_first(key)) {
      auto json = encode_any(key_path(path_, key), value, &(*defaults_)[name], true);
      if (!json.empty()) object_[name] = std::move(json);
      return;
    }
    auto json = encode_any(key_path(path_, key), value);
    if (!json.empty()) put(key, std::move(json));
  }
  /// An empty list means the same as a missing one.
  template <class T>
  void list(std::string_view key, std::vector<T>& values) {
    if (values.empty()) return;
    T element;
    const auto defaults = encode_any({}, element);
    auto array = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < values.size(); ++i) {
      array.push_back(encode_any(element_path(key_path(path_, key), i), values[i], &defaults, brief_));
    }
    put(key, std::move(array));
  }
  template <class... Types>
  void one_of(std::variant<Types...>& value, const std::array<std::string_view, sizeof...(Types)>& keys) {
    std::visit([&](auto& alternative) { required(keys[value.index()], alternative); }, value);
  }
  [[nodiscard]] static bool given(std::string_view) { return false; }
  /// The reader checks rules; here the required value is written.
  void rule(bool holds, std::string_view key, std::string_view, std::string_view) {
    const std::string name(key);
    if (!holds && left_out_.contains(name)) object_[name] = left_out_[name];
  }
  static void set_units(const Units&) {}

 private:
  void put(std::string_view key, nlohmann::ordered_json json) {
    const std::string name(key);
    const bool is_default = defaults_ != nullptr && defaults_->contains(name) && (*defaults_)[name] == json;
    const bool leave_out = is_default && !(brief_ && changes_first(key));
    (leave_out ? left_out_ : object_)[name] = std::move(json);
  }
  /// Whether users usually change this key first.
  static bool changes_first(std::string_view key) {
    constexpr std::array<std::string_view, 8> keys{"units",    "time_step",     "duration",      "gravity",
                                                   "friction", "young_modulus", "poisson_ratio", "density"};
    return std::ranges::count(keys, key) > 0;
  }
  /// In a brief text, an object without defaults of its own has the defaults of its type.
  template <class T>
  nlohmann::ordered_json encode_new(const std::string& path, T& value) {
    if constexpr (std::is_default_constructible_v<T> && !requires { encode(path, value); }) {
      if (brief_) {
        T standard{};
        const auto defaults = encode_any(path, standard);
        return encode_any(path, value, &defaults, true);
      }
    }
    return encode_any(path, value);
  }
  template <class T>
  static nlohmann::ordered_json encode_any(const std::string& path, T& value,
                                           const nlohmann::ordered_json* defaults = nullptr,
                                           bool brief = false) {
    if constexpr (requires { encode(path, value); }) {
      return encode(path, value);
    } else {
      Writer writer(path, defaults, brief);
      describe(writer, value);
      return writer.take();
    }
  }

  std::string path_;
  const nlohmann::ordered_json* defaults_;
  bool brief_;
  nlohmann::ordered_json left_out_ = nlohmann::ordered_json::object();
  nlohmann::ordered_json object_ = nlohmann::ordered_json::object();
};

}  // namespace palpate::scene_format
