#include "scene/values.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <numeric>

#include <palpate/error.hpp>

#include "scene/suggest.hpp"

namespace palpate::scene_format {

using nlohmann::ordered_json;

std::string expected_within(const Limits& limits, const std::string& noun) {
  const bool has_low = std::isfinite(limits.low);
  const bool has_high = std::isfinite(limits.high);
  if (has_low && has_high) {
    return fmt::format("{} in {}{}, {}{}", noun, limits.low_open ? "(" : "[", limits.low, limits.high,
                       limits.high_open ? ")" : "]");
  }
  if (has_low) return fmt::format("{} {} {}", noun, limits.low_open ? ">" : ">=", limits.low);
  if (has_high) return fmt::format("{} {} {}", noun, limits.high_open ? "<" : "<=", limits.high);
  return noun;
}

void fail(const Context& context, const std::string& path, const std::string& found,
          const std::string& expected) {
  throw Error(context.source, path, found, expected);
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, double& value,
            const Limits& limits) {
  const bool allowed = json.is_number() && limits.allow(json.get<double>());
  if (!allowed) fail(context, path, describe_json(json), expected_within(limits, "a number"));
  value = json.get<double>();
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, int& value,
            const Limits& limits) {
  Limits allowed = limits;
  if (json.is_number()) {  // for a number that is too large, the error names the bound
    constexpr double lowest = std::numeric_limits<int>::min();
    constexpr double highest = std::numeric_limits<int>::max();
    const double found = json.get<double>();
    if (found > highest) allowed.high = std::min(limits.high, highest);
    if (found < lowest) allowed.low = std::max(limits.low, lowest);
  }
  if (!json.is_number_integer() || !allowed.allow(json.get<double>()))
    fail(context, path, describe_json(json), expected_within(allowed, "an integer"));
  value = json.get<int>();
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, bool& value,
            const Limits&) {
  if (!json.is_boolean()) fail(context, path, describe_json(json), "true or false");
  value = json.get<bool>();
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, std::string& value,
            const Limits&) {
  if (!json.is_string() || json.get_ref<const std::string&>().empty()) {
    fail(context, path, describe_json(json), "a text that is not empty");
  }
  value = json.get<std::string>();
  if (value.find('\0') != std::string::npos) fail(context, path, "a NUL character in it", "a text without");
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, Vec3& value,
            const Limits& limits) {
  std::array<double, 3> numbers{};
  decode(context, path, json, numbers, limits);
  value = {numbers[0], numbers[1], numbers[2]};
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, MeshFile& value,
            const Limits& limits) {
  decode(context, path, json, value.path, limits);
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, BodyNames& value,
            const Limits& limits) {
  if (!json.is_array()) fail(context, path, describe_json(json), "an array of names of bodies");
  value.names.resize(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    decode(context, element_path(path, i), json[i], value.names[i], limits);
  }
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, FieldNames& value,
            const Limits& limits) {
  if (!json.is_array()) fail(context, path, describe_json(json), "an array of names of fields");
  value.names.resize(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string here = element_path(path, i);
    decode(context, here, json[i], value.names[i], limits);
    if (find_field(value.names[i]) == nullptr)
      fail(context, here, describe_json(json[i]), expected_name(value.names[i], field_names()));
  }
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json,
            std::vector<double>& value, const Limits& limits) {
  if (!json.is_array()) fail(context, path, describe_json(json), "an array of numbers");
  value.resize(json.size());
  for (std::size_t i = 0; i < json.size(); ++i)
    decode(context, element_path(path, i), json[i], value[i], limits);
}

namespace {

void decode_indices(const Context& context, const std::string& path, const nlohmann::json& json,
                    const char* what, std::vector<Index>& indices) {
  if (!json.is_array() || json.empty()) {
    fail(context, path, describe_json(json), fmt::format("an array of one or more {} indices", what));
  }
  indices.resize(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    decode(context, element_path(path, i), json[i], indices[i], at_least(0));
  }
}

/// A run of indices in a scene: {"first": 0, "count": 10}.
void decode_run(const Context& context, const std::string& path, const nlohmann::json& json,
                std::vector<Index>& indices) {
  constexpr double most = 1e8;  // limits the memory that one line of a scene can allocate
  if (json.size() != 2 || !json.contains("first") || !json.contains("count"))
    fail(context, path, describe_json(json), "tet indices, or an object with first and count");
  int first = 0;
  int count = 0;
  decode(context, path + ".first", json["first"], first, within(0, most));
  decode(context, path + ".count", json["count"], count, within(1, most));
  indices.resize(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), first);
}

}  // namespace

void decode(const Context& context, const std::string& path, const nlohmann::json& json,
            PointSelection& value, const Limits&) {
  decode_indices(context, path, json, "point", value.indices);
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json, TetSelection& value,
            const Limits&) {
  if (json.is_object()) {
    decode_run(context, path, json, value.indices);
  } else {
    decode_indices(context, path, json, "tet", value.indices);
  }
}

void decode(const Context& context, const std::string& path, const nlohmann::json& json,
            LabelSelection& value, const Limits& limits) {
  decode(context, path, json, value.label, limits);
}

std::size_t decode_choice(const Context& context, const std::string& path, const nlohmann::json& json,
                          std::span<const std::string_view> names) {
  const std::string word = json.is_string() ? json.get<std::string>() : std::string();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == word) return i;
  }
  fail(context, path, describe_json(json), expected_name(word, names));
}

ordered_json encode(const std::string& path, double value) {
  if (!std::isfinite(value)) throw Error("scene", path, fmt::format("{}", value), "a finite number");
  return value;
}
ordered_json encode(const std::string&, int value) {
  return value;
}
ordered_json encode(const std::string&, bool value) {
  return value;
}
ordered_json encode(const std::string&, const std::string& value) {
  return value;
}
ordered_json encode(const std::string& path, const Vec3& value) {
  return encode(path, std::array{value.x, value.y, value.z});
}
ordered_json encode(const std::string&, const MeshFile& value) {
  return value.path;
}
ordered_json encode(const std::string&, const BodyNames& value) {
  return value.names;
}
ordered_json encode(const std::string&, const FieldNames& value) {
  return value.names;
}
ordered_json encode(const std::string& path, const std::vector<double>& value) {
  auto json = ordered_json::array();
  for (std::size_t i = 0; i < value.size(); ++i) json.push_back(encode(element_path(path, i), value[i]));
  return json;
}
ordered_json encode(const std::string&, const PointSelection& value) {
  return value.indices;
}
ordered_json encode(const std::string&, const TetSelection& value) {
  constexpr std::size_t few = 4;
  const std::vector<Index>& indices = value.indices;
  const bool is_run = std::ranges::adjacent_find(indices, [](Index before, Index after) {
                        return after != before + 1;
                      }) == indices.end();
  if (!is_run || indices.size() <= few) return indices;
  return {{"first", indices.front()}, {"count", indices.size()}};
}
ordered_json encode(const std::string&, const LabelSelection& value) {
  return value.label;
}

}  // namespace palpate::scene_format
