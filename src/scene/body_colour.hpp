#pragma once

#include "io/body_colours.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// The colour of a body in pictures and on the page: its own, if it has one; else grey, if it is rigid; else
/// one by its number in the scene.
inline io::Colour body_colour(const SceneBody& body, Index number) {
  if (body.color) return io::to_colour(*body.color);
  return is_rigid(body) ? io::neutral_colour : io::default_colour(number);
}

}  // namespace palpate
