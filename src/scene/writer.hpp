#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "scene/fields.hpp"
#include "scene/values.hpp"

namespace palpate::scene_format {

/// Visitor of fields.hpp that turns an object into JSON. With `defaults` (the JSON of a default object) it
/// leaves out what equals them.
class Writer {
 public:
  explicit Writer(std::string path, const nlohmann::ordered_json* defaults = nullptr)
      : path_(std::move(path)), defaults_(defaults) {}
  nlohmann::ordered_json take() { return std::move(object_); }

  template <class T>
  void field(std::string_view key, const T& value, const Limits& = any) {
    put(key, encode(key_path(path_, key), value));
  }
  template <class Known>
  void unit(std::string_view key, const std::string& value, const Known&) {
    field(key, value);
  }
  template <class T>
  void required(std::string_view key, T& value, const Limits& = any) {
    object_[std::string(key)] = encode_any(key_path(path_, key), value);
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
    auto json = encode_any(key_path(path_, key), value);
    if (!json.empty()) put(key, std::move(json));
  }
  /// An empty list says what an absent one says.
  template <class T>
  void list(std::string_view key, std::vector<T>& values) {
    if (values.empty()) return;
    T element;
    const auto defaults = encode_any({}, element);
    auto array = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < values.size(); ++i) {
      array.push_back(encode_any(element_path(key_path(path_, key), i), values[i], &defaults));
    }
    put(key, std::move(array));
  }
  template <class... Types>
  void one_of(std::variant<Types...>& value, const std::array<std::string_view, sizeof...(Types)>& keys) {
    std::visit([&](auto& alternative) { required(keys[value.index()], alternative); }, value);
  }
  [[nodiscard]] static bool given(std::string_view) { return false; }
  static void rule(bool, std::string_view, std::string_view, std::string_view) {}  // the reader's task
  static void set_units(const Units&) {}

 private:
  void put(std::string_view key, nlohmann::ordered_json json) {
    const std::string name(key);
    const bool is_default = defaults_ != nullptr && defaults_->contains(name) && (*defaults_)[name] == json;
    if (!is_default) object_[name] = std::move(json);
  }
  template <class T>
  static nlohmann::ordered_json encode_any(const std::string& path, T& value,
                                           const nlohmann::ordered_json* defaults = nullptr) {
    if constexpr (requires { encode(path, value); }) {
      return encode(path, value);
    } else {
      Writer writer(path, defaults);
      describe(writer, value);
      return writer.take();
    }
  }

  std::string path_;
  const nlohmann::ordered_json* defaults_;
  nlohmann::ordered_json object_ = nlohmann::ordered_json::object();
};

}  // namespace palpate::scene_format
