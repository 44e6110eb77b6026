#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "scene/field_list.hpp"
#include "scene/json_text.hpp"
#include "scene/limits.hpp"
#include "scene/scene.hpp"

/// Conversion of the values of a scene file: decode() reads a value from JSON or throws Error with its key
/// path, encode() is its inverse.
namespace palpate::scene_format {

/// Data common to all readers of one scene.
struct Context {
  const std::string& source;
  Units units{};  ///< of the scene, once they are read
};

[[noreturn]] void fail(const Context& context, const std::string& path, const std::string& found,
                       const std::string& expected);

void decode(const Context& context, const std::string& path, const nlohmann::json& json, double& value,
            const Limits& limits);
void decode(const Context& context, const std::string& path, const nlohmann::json& json, int& value,
            const Limits& limits);
void decode(const Context& context, const std::string& path, const nlohmann::json& json, bool& value,
            const Limits& limits);
void decode(const Context& context, const std::string& path, const nlohmann::json& json, std::string& value,
            const Limits& limits);
/// Three numbers [x, y, z]; the limits apply to each.
void decode(const Context& context, const std::string& path, const nlohmann::json& json, Vec3& value,
            const Limits& limits);
void decode(const Context& context, const std::string& path, const nlohmann::json& json, MeshFile& value,
            const Limits& limits);
/// An array of names. Whether bodies have these names is checked when all bodies are known.
void decode(const Context& context, const std::string& path, const nlohmann::json& json, BodyNames& value,
            const Limits& limits);
/// An array of names of fields; each must be one of field_infos().
void decode(const Context& context, const std::string& path, const nlohmann::json& json, FieldNames& value,
            const Limits& limits);
/// An array of numbers, which may be empty.
void decode(const Context& context, const std::string& path, const nlohmann::json& json,
            std::vector<double>& value, const Limits& limits);
void decode(const Context& context, const std::string& path, const nlohmann::json& json,
            PointSelection& value, const Limits& limits);
void decode(const Context& context, const std::string& path, const nlohmann::json& json, TetSelection& value,
            const Limits& limits);
void decode(const Context& context, const std::string& path, const nlohmann::json& json,
            LabelSelection& value, const Limits& limits);
/// One of `names`; the value is its index.
std::size_t decode_choice(const Context& context, const std::string& path, const nlohmann::json& json,
                          std::span<const std::string_view> names);

template <class T, std::size_t N>
void decode(const Context& context, const std::string& path, const nlohmann::json& json,
            std::array<T, N>& value, const Limits& limits) {
  if (!json.is_array() || json.size() != N) {
    fail(context, path, describe_json(json), "an array of " + std::to_string(N) + " numbers");
  }
  for (std::size_t i = 0; i < N; ++i) decode(context, element_path(path, i), json[i], value[i], limits);
}

/// Encodes a value. Throws Error naming `path` if a number is NaN or infinite.
nlohmann::ordered_json encode(const std::string& path, double value);
nlohmann::ordered_json encode(const std::string& path, int value);
nlohmann::ordered_json encode(const std::string& path, bool value);
nlohmann::ordered_json encode(const std::string& path, const std::string& value);
nlohmann::ordered_json encode(const std::string& path, const Vec3& value);
nlohmann::ordered_json encode(const std::string& path, const MeshFile& value);
nlohmann::ordered_json encode(const std::string& path, const BodyNames& value);
nlohmann::ordered_json encode(const std::string& path, const FieldNames& value);
nlohmann::ordered_json encode(const std::string& path, const std::vector<double>& value);
nlohmann::ordered_json encode(const std::string& path, const PointSelection& value);
nlohmann::ordered_json encode(const std::string& path, const TetSelection& value);
nlohmann::ordered_json encode(const std::string& path, const LabelSelection& value);

template <class T, std::size_t N>
nlohmann::ordered_json encode(const std::string& path, const std::array<T, N>& value) {
  auto json = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < N; ++i) json.push_back(encode(element_path(path, i), value[i]));
  return json;
}

}  // namespace palpate::scene_format
