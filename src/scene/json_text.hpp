#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace palpate {

/// Parses JSON with // and /* */ comments. Throws Error naming `source` and either "line L, column C" (not
/// JSON, a number too large for a double) or the path of a repeated key. O(n log n).
nlohmann::json parse_json(std::string_view text, const std::string& source);

/// Readable JSON: a value that fits on a line of 110 columns is on one line; others are indented by 2.
std::string format_json(const nlohmann::ordered_json& value);

/// A short description of a value for "found" in an error: the value itself, or "an object", "an array of 3".
std::string describe_json(const nlohmann::json& value);

/// Path of `key` in the object at `path`: "bodies[2].material"; a key with special characters is written as a
/// JSON string.
std::string key_path(const std::string& path, std::string_view key);
/// Path of element `index` of the array at `path`.
std::string element_path(const std::string& path, std::size_t index);

}  // namespace palpate
