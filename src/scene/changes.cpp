#include "scene/changes.hpp"

#include <charconv>
#include <cstddef>
#include <optional>
#include <vector>

#include <palpate/error.hpp>

#include "scene/json_text.hpp"
#include "scene/suggest.hpp"

namespace palpate {
namespace {

using nlohmann::json;

[[noreturn]] void fail(const SceneChange& change, const std::string& where, const std::string& found,
                       const std::string& expected) {
  throw Error("--set " + change.text, where, found, expected);
}

/// Splits "bodies[1].material" into "bodies", "1", "material".
std::vector<std::string> steps_of(const SceneChange& change) {
  std::vector<std::string> steps(1);
  for (const char c : change.path) {
    if (c == '.' || c == '[') {
      if (!steps.back().empty()) steps.emplace_back();
    } else if (c != ']') {
      steps.back() += c;
    }
  }
  if (steps.back().empty()) fail(change, "", "'" + change.path + "'", "a path of keys, as contact.friction");
  return steps;
}

std::optional<std::size_t> element_number(const json& array, const std::string& step) {
  std::size_t number = 0;
  const char* const end = step.data() + step.size();
  const auto read = std::from_chars(step.data(), end, number);
  if (read.ec == std::errc{} && read.ptr == end && number < array.size()) return number;
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (array[i].is_object() && array[i].contains("name") && array[i]["name"] == step) return i;
  }
  return std::nullopt;
}

std::string expected_element(const json& array, const std::string& step) {
  std::vector<std::string> names;
  for (const json& element : array) {
    if (element.is_object() && element.contains("name") && element["name"].is_string())
      names.push_back(element["name"].get<std::string>());
  }
  const std::string number = array.empty() ? "" : "a number below " + std::to_string(array.size());
  if (names.empty()) return number.empty() ? "no element: the array is empty" : number;
  return number + " or " + expected_name(step, std::vector<std::string_view>(names.begin(), names.end()));
}

}  // namespace

SceneChange parse_scene_change(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos || equals == 0)
    throw Error("--set", "", "'" + std::string(text) + "'", "KEY=VALUE, for example contact.friction=0.3");
  if (equals + 1 == text.size()) {
    throw Error("--set " + std::string(text), "", "an empty value",
                "KEY=VALUE, for example contact.friction=0.3; an empty text is KEY='\"\"'");
  }
  SceneChange change{std::string(text), std::string(text.substr(0, equals)), {}};
  const std::string value(text.substr(equals + 1));
  change.value = json::parse(value, nullptr, false);
  if (change.value.is_discarded()) change.value = value;
  return change;
}

std::string apply_change(json& scene, const SceneChange& change) {
  json* place = &scene;
  std::string path;
  std::string made;  // the first key of the path that did not exist
  for (const std::string& step : steps_of(change)) {
    if (place->is_array()) {
      const auto number = element_number(*place, step);
      if (!number) fail(change, path, "'" + step + "'", expected_element(*place, step));
      path = element_path(path, *number);
      place = &(*place)[*number];
    } else {
      if (!place->is_object() && !place->is_null())
        fail(change, path, describe_json(*place), "an object that has '" + step + "'");
      path = key_path(path, step);
      if (made.empty() && !place->contains(step)) made = path;
      place = &(*place)[step];
    }
  }
  *place = change.value;
  return made.empty() ? path : made;
}

}  // namespace palpate
