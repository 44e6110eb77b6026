#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace palpate {

/// A value of a scene that replaces the value in the file: "contact.friction=0.3".
struct SceneChange {
  std::string text;      ///< the text of the change
  std::string path;      ///< "bodies.liver.material.young_modulus" or "bodies[1].material.young_modulus"
  nlohmann::json value;  ///< the value as JSON; text that is no JSON becomes a string
};

/// Reads "PATH=VALUE". Throws Error with the source "--set" where a part is missing.
SceneChange parse_scene_change(std::string_view text);

/// Sets the value at its path. Missing objects on the path are created; elements of an array are named by
/// their number or, where they are objects, by their "name". Returns the path of what was added, as the
/// reader names it (bodies by number): that of the value, or of the first object created for it. Throws Error
/// with the source "--set TEXT" where the path leads through a value that is no object, or to an element that
/// does not exist. The reader checks later whether a scene has such a key. O(length of the path).
std::string apply_change(nlohmann::json& scene, const SceneChange& change);

}  // namespace palpate
