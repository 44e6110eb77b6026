#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace palpate {

/// One value of a scene, given in place of the file's: "contact.friction=0.3".
struct SceneChange {
  std::string text;      ///< as it was given
  std::string path;      ///< "bodies.liver.material.young_modulus" or "bodies[1].material.young_modulus"
  nlohmann::json value;  ///< JSON, or where the text is none, the text itself
};

/// Reads "PATH=VALUE". Throws Error with the source "--set" where a part is missing.
SceneChange parse_scene_change(std::string_view text);

/// Puts the value at its path. Missing objects on the path are made; elements of an array are named
/// by their number or, where they are objects, by their "name". Returns the path of all that the change gave,
/// as the reader names it: that of the value, or of the first object that was made for it; bodies by number.
/// Throws Error with the source "--set TEXT" where the path leads through something that is no object, or to
/// an element that is not there. Whether a scene has such a key is the reader's to say. O(length of the
/// path).
std::string apply_change(nlohmann::json& scene, const SceneChange& change);

}  // namespace palpate
