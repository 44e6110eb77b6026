#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace palpate {

/// A change of a scene: a value that replaces the value in the file, such as "contact.friction=0.3".
struct SceneChange {
  std::string text;      ///< the text of the change
  std::string path;      ///< "bodies.liver.material.young_modulus" or "bodies[1].material.young_modulus"
  nlohmann::json value;  ///< the value as JSON; text that is no JSON becomes a string
};

/// Reads "PATH=VALUE". Throws Error with the source "--set" if a part is missing.
SceneChange parse_scene_change(std::string_view text);

/// Sets the value at its path. Missing objects on the path are created. An element of an array is named by
/// its number or, if it is an object, by its "name". Returns the path of what was added, with bodies by
/// number as in the reader's errors: the path of the value, or of the first object created for it. Throws
/// Error with the source "--set TEXT" if the path leads through a value that is not an object, or to an
/// element that does not exist. The reader checks later whether scenes have such a key. O(length of the
/// path).
std::string apply_change(nlohmann::json& scene, const SceneChange& change);

}  // namespace palpate
