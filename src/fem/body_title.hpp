#pragma once

#include <string>

#include <palpate/mesh.hpp>

namespace palpate::fem {

/// A body's name in messages: "body liver". Unnamed bodies of a scene are called "body 0", "body 1" already.
inline std::string body_title(const Body& body) {
  return body.name.starts_with("body ") ? body.name : "body " + body.name;
}

}  // namespace palpate::fem
