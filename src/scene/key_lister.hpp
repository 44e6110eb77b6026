#pragma once

#include <array>
#include <map>
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

/// Visitor of fields.hpp that lists every key: "bodies[].material.density" with its default, null where there
/// is none.
class KeyLister {
 public:
  using Keys = std::map<std::string, nlohmann::ordered_json>;
  KeyLister(std::string path, Keys& keys) : path_(std::move(path)), keys_(keys) {}

  template <class T>
  void field(std::string_view key, T& value, const Limits& = any) {
    add(key, encode({}, value));
  }
  template <class Known>
  void unit(std::string_view key, std::string& value, const Known&) {
    field(key, value);
  }
  template <class T>
  void required(std::string_view key, T& value, const Limits& = any) {
    add(key, nullptr);
    if constexpr (!requires { encode({}, value); }) list_object(key_path(path_, key), value);
  }
  template <class T>
  void optional(std::string_view key, std::optional<T>&, const Limits& = any) {
    T value{};
    required(key, value);
  }
  void ignored(std::string_view key) { add(key, nullptr); }
  template <class Enum>
  void choice(std::string_view key, Enum value, std::span<const std::string_view> names) {
    add(key, names[static_cast<std::size_t>(value)]);
  }
  template <class Enum>
  void preset(std::string_view key, const std::optional<Enum>&, std::span<const std::string_view>) {
    add(key, nullptr);
  }
  template <class Enum>
  void words_or_number(std::string_view key, const std::variant<Enum, double>& value,
                       std::span<const std::string_view> names, const Limits&) {
    choice(key, std::get<Enum>(value), names);
  }
  template <class Number>
  void word_or_number(std::string_view key, const std::optional<Number>&, std::string_view word,
                      const Limits&) {
    add(key, word);
  }
  void scale(std::string_view key, const Vec3& value, const Limits&) { add(key, value.x); }
  template <class T>
  void object(std::string_view key, T& value) {
    required(key, value);
  }
  template <class T>
  void list(std::string_view key, std::vector<T>&) {
    T element{};
    add(key, nullptr);
    list_object(key_path(path_, key) + "[]", element);
  }
  template <class... Types>
  void one_of(std::variant<Types...>&, const std::array<std::string_view, sizeof...(Types)>& keys) {
    std::size_t i = 0;
    (list_alternative<Types>(keys[i++]), ...);
  }
  [[nodiscard]] static bool given(std::string_view) { return false; }
  static void rule(bool, std::string_view, std::string_view, std::string_view) {}
  static void set_units(const Units&) {}

 private:
  void add(std::string_view key, nlohmann::ordered_json value) {
    keys_[key_path(path_, key)] = std::move(value);
  }
  template <class T>
  void list_object(std::string path, T& value) {
    KeyLister lister(std::move(path), keys_);
    describe(lister, value);
  }
  template <class T>
  void list_alternative(std::string_view key) {
    T value{};
    required(key, value);
  }

  std::string path_;
  Keys& keys_;
};

/// Every key of a scene; the test compares it with docs/scene.schema.json.
KeyLister::Keys list_scene_keys();

}  // namespace palpate::scene_format
