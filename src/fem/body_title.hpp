#pragma once

#include <string>

#include <palpate/mesh.hpp>

namespace palpate::fem {

/// A body as messages name it: "body liver". A scene calls those without a name "body 0", "body 1", which
/// says it already.
inline std::string body_title(const Body& body) {
  return body.name.starts_with("body ") ? body.name : "body " + body.name;
}

}  // namespace palpate::fem
