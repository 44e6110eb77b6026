#pragma once

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "scene/fields.hpp"
#include "scene/suggest.hpp"
#include "scene/values.hpp"

namespace palpate::scene_format {

/// Visitor of fields.hpp that fills an object from JSON. It records which keys were read. finish() then
/// refuses all other keys.
class Reader {
 public:
  Reader(Context& context, std::string path, const nlohmann::json& object)
      : context_(context), path_(std::move(path)), object_(object) {
    if (!object.is_object()) fail(context, path_, describe_json(object), "an object");
  }

  /// An optional value; the default stays if it is absent.
  template <class T>
  void field(std::string_view key, T& value, const Limits& limits = any) {
    if (const auto* json = find(key)) return decode_any(key_path(path_, key), *json, value, limits);
    // Doubles and vectors have dimensions. In SI the bits of a default do not change.
    if constexpr (requires { scale_default(value, Units{}, limits.dimension); })
      scale_default(value, context_.units, limits.dimension);
  }
  template <class T>
  void required(std::string_view key, T& value, const Limits& limits = any) {
    const auto* json = find(key);
    if (json == nullptr) fail(context_, key_path(path_, key), "nothing", "a value");
    decode_any(key_path(path_, key), *json, value, limits);
  }
  template <class T>
  void optional(std::string_view key, std::optional<T>& value, const Limits& limits = any) {
    if (const auto* json = find(key)) decode_any(key_path(path_, key), *json, value.emplace(), limits);
  }
  /// A key for other programs, which is ignored.
  void ignored(std::string_view key) {
    std::string text;
    if (const auto* json = find(key)) decode(context_, key_path(path_, key), *json, text, any);
  }
  /// One of a list of names; its index is the value of the enumeration.
  template <class Enum>
  void choice(std::string_view key, Enum& value, std::span<const std::string_view> names) {
    const auto* json = find(key);
    if (json != nullptr)
      value = static_cast<Enum>(decode_choice(context_, key_path(path_, key), *json, names));
  }
  /// One of a list of names; the name sets defaults of other keys.
  template <class Enum>
  void preset(std::string_view key, std::optional<Enum>& value, std::span<const std::string_view> names) {
    if (find(key) != nullptr) choice(key, value.emplace(), names);
  }
  /// One of a list of names, or a number.
  template <class Enum>
  void words_or_number(std::string_view key, std::variant<Enum, double>& value,
                       std::span<const std::string_view> names, const Limits& limits) {
    const auto* json = find(key);
    if (json == nullptr) return;
    if (!json->is_string()) {
      decode(context_, key_path(path_, key), *json, value.template emplace<double>(), limits);
      return;
    }
    const auto name = std::find(names.begin(), names.end(), json->template get_ref<const std::string&>());
    if (name == names.end()) {
      std::string expected;
      for (const std::string_view known : names) expected.append(1, '\'').append(known).append("', ");
      fail(context_, key_path(path_, key), describe_json(*json),
           expected + "or " + expected_within(limits, "a number"));
    }
    value = static_cast<Enum>(name - names.begin());
  }
  /// A number, or the word that stands for "none".
  template <class Number>
  void word_or_number(std::string_view key, std::optional<Number>& value, std::string_view word,
                      const Limits& limits) {
    const auto* json = find(key);
    if (json == nullptr) return;
    if (*json == word) return value.reset();
    if (json->is_string()) {
      fail(context_, key_path(path_, key), describe_json(*json),
           "'" + std::string(word) + "' or " +
               expected_within(limits, std::is_integral_v<Number> ? "an integer" : "a number"));
    }
    decode(context_, key_path(path_, key), *json, value.emplace(), limits);
  }
  /// Three numbers, or one for all three.
  void scale(std::string_view key, Vec3& value, const Limits& limits) {
    const auto* json = find(key);
    if (json == nullptr || !json->is_number()) return field(key, value, limits);
    decode(context_, key_path(path_, key), *json, value.x, limits);
    value.y = value.z = value.x;
  }
  /// An object; if it is absent, its own required keys decide whether that is an error.
  template <class T>
  void object(std::string_view key, T& value) {
    static const auto empty = nlohmann::json::object();
    const auto* json = find(key);
    read_object(key_path(path_, key), json == nullptr ? empty : *json, value);
  }
  /// An array of objects.
  template <class T>
  void list(std::string_view key, std::vector<T>& values) {
    const auto* json = find(key);
    if (json == nullptr) return;
    const std::string path = key_path(path_, key);
    if (!json->is_array()) fail(context_, path, describe_json(*json), "an array");
    values.resize(json->size());
    for (std::size_t i = 0; i < json->size(); ++i) read_object(element_path(path, i), (*json)[i], values[i]);
  }
  /// Exactly one of the keys; they are in the order of the variant's types.
  template <class... Types>
  void one_of(std::variant<Types...>& value, const std::array<std::string_view, sizeof...(Types)>& keys) {
    std::vector<std::string_view> there;
    std::copy_if(keys.begin(), keys.end(), std::back_inserter(there), [&](auto key) { return given(key); });
    if (there.size() != 1) refuse_alternatives(there, keys);
    read_alternative<0>(value, keys, there.front());
  }

  [[nodiscard]] bool given(std::string_view key) const { return object_.contains(key); }
  /// A rule between the values of an object. If the key is missing, finish() reports the error, since an
  /// unknown key may be a misspelling of it.
  void rule(bool holds, std::string_view key, const std::string& found, const std::string& expected) {
    if (holds || broken_) return;
    if (object_.contains(key)) fail(context_, key_path(path_, key), found, expected);
    broken_ = BrokenRule{key_path(path_, key), found, expected};
  }
  void set_units(const Units& units) { context_.units = units; }
  /// One of a list of units. finish() reports all wrong ones together.
  template <std::size_t n>
  void unit(std::string_view key, std::string& value, const std::array<UnitName, n>& known) {
    field(key, value);
    std::vector<std::string_view> names;
    names.reserve(n);
    for (const UnitName& unit : known) names.push_back(unit.name);
    if (std::ranges::count(names, value) == 0)
      wrong_units_.push_back({key_path(path_, key), "'" + value + "'", expected_name(value, names)});
  }

  /// Throws Error for unknown keys, then for broken rules.
  void finish() const {
    for (const auto& item : object_.items()) {
      if (std::find(known_.begin(), known_.end(), item.key()) == known_.end()) {
        fail(context_, key_path(path_, item.key()), "unknown key", expected_name(item.key(), known_));
      }
    }
    if (!wrong_units_.empty()) refuse_units();
    if (broken_) fail(context_, broken_->path, broken_->found, broken_->expected);
  }

 private:
  const nlohmann::json* find(std::string_view key) {
    known_.push_back(key);
    const auto item = object_.find(key);
    return item == object_.end() ? nullptr : &*item;
  }
  template <class T>
  void read_object(std::string path, const nlohmann::json& json, T& value) {
    Reader reader(context_, std::move(path), json);
    describe(reader, value);
    reader.finish();
  }
  static void scale_default(double& value, const Units& units, const Dimension& dimension) {
    value = from_si(value, units, dimension);
  }
  static void scale_default(Vec3& value, const Units& units, const Dimension& dimension) {
    for (double* component : {&value.x, &value.y, &value.z}) scale_default(*component, units, dimension);
  }
  template <class T>
  void decode_any(const std::string& path, const nlohmann::json& json, T& value, const Limits& limits) {
    if constexpr (requires { decode(context_, path, json, value, limits); }) {
      decode(context_, path, json, value, limits);
    } else {
      read_object(path, json, value);
    }
  }
  template <std::size_t I, class Variant, class Keys>
  void read_alternative(Variant& value, const Keys& keys, std::string_view there) {
    if constexpr (I < std::variant_size_v<Variant>) {
      if (keys[I] == there) required(keys[I], value.template emplace<I>());
      if (keys[I] != there) known_.push_back(keys[I]);
      read_alternative<I + 1>(value, keys, there);
    }
  }
  /// If an alternative is misspelt, reports that instead of the missing key.
  [[noreturn]] void refuse_alternatives(const std::vector<std::string_view>& there,
                                        std::span<const std::string_view> keys) const;
  /// Reports all wrong units in one error.
  [[noreturn]] void refuse_units() const;

  Context& context_;
  std::string path_;
  const nlohmann::json& object_;
  std::vector<std::string_view> known_;
  struct BrokenRule {
    std::string path;
    std::string found;
    std::string expected;
  };
  std::optional<BrokenRule> broken_;  ///< the first broken rule
  std::vector<BrokenRule> wrong_units_;
};

}  // namespace palpate::scene_format
