#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "mesh/unused_points.hpp"
#include "number_text.hpp"
#include "scene/json_text.hpp"
#include "scene/near.hpp"
#include "scene/scene.hpp"
#include "scene/suggest.hpp"

/// Evaluation of the selections of a scene.
namespace palpate {

/// The path of a body in errors, such as "bodies[2]".
inline std::string path_of(std::size_t body) {
  return "bodies[" + std::to_string(body) + "]";
}

inline bool contains(const BoxSelection& box, const Vec3& p) {
  return box.lower.x <= p.x && p.x <= box.upper.x && box.lower.y <= p.y && p.y <= box.upper.y &&
         box.lower.z <= p.z && p.z <= box.upper.z;
}
inline bool contains(const SphereSelection& sphere, const Vec3& p) {
  return length(p - sphere.center) <= sphere.radius;
}

/// The body of a scene with that name. Throws Error naming `if` if there is none, or if it is the body
/// `self`.
inline Index body_named(const Scene& scene, const std::string& name, const std::string& where, Index self) {
  std::vector<std::string_view> known;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (static_cast<Index>(b) == self) continue;
    if (scene.bodies[b].name == name) return static_cast<Index>(b);
    known.push_back(scene.bodies[b].name);
  }
  throw Error(scene.source, where, "'" + name + "'",
              known.empty() ? "the name of another body; this scene has no other"
                            : "another body: " + expected_name(name, known));
}

/// Indices of the points for which holds(point) is true.
template <class Holds>
std::vector<Index> selected(std::span<const Vec3> points, Holds&& holds) {
  std::vector<Index> indices;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (holds(points[i])) indices.push_back(static_cast<Index>(i));
  }
  return indices;
}

/// Finds the points of a body that a selection selects, or its tets by their centres. Points in no tet are
/// left out; an index of one is an error.
struct Selector {
  const Scene& scene;
  const Bodies& bodies;
  Index body;
  std::span<const Vec3> points;      ///< points from which it selects
  std::string what;                  ///< what the points are: "point" or "tet"
  std::span<const double> labels{};  ///< (n_points) of tets, if a label is selected

  /// Finds the selected points; throws Error naming `path`, the key path of the selection, where there are
  /// none.
  template <class... Kinds>
  std::vector<Index> operator()(const std::variant<Kinds...>& selection, const std::string& path) const {
    std::vector<Index> indices = std::visit([&](const auto& kind) { return select(kind, path); }, selection);
    if (indices.empty()) {
      throw Error(scene.source, path, "no " + what + " of '" + at(scene.bodies, body).name + "'",
                  "one or more " + what + "s selected");
    }
    return indices;
  }
  /// The points of all of these parts, perhaps with repetitions. Throws Error as above, naming the element.
  std::vector<Index> operator()(const std::vector<PointPart>& parts, const std::string& path) const {
    std::vector<Index> indices;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::vector<Index> more = (*this)(parts[i].points, element_path(path, i));
      indices.insert(indices.end(), more.begin(), more.end());
    }
    return indices;
  }

 private:
  /// Points in no tet: forces on them would be lost.
  [[nodiscard]] bool is_left_out(Index i) const {
    return what == "point" && is_unused(bodies, at(bodies.bodies(), body).points.begin + i);
  }
  /// Indices of the points for which holds(point) is true.
  template <class Holds>
  [[nodiscard]] std::vector<Index> where(Holds&& holds) const {
    std::vector<Index> indices = selected(points, holds);
    std::erase_if(indices, [&](Index i) { return is_left_out(i); });
    return indices;
  }
  [[nodiscard]] std::vector<Index> select(const BoxSelection& box, const std::string&) const {
    return where([&](const Vec3& p) { return contains(box, p); });
  }
  [[nodiscard]] std::vector<Index> select(const SphereSelection& sphere, const std::string&) const {
    return where([&](const Vec3& p) { return contains(sphere, p); });
  }
  [[nodiscard]] std::vector<Index> select(const PointSelection& list, const std::string& path) const {
    return checked(list.indices, path);
  }
  [[nodiscard]] std::vector<Index> select(const TetSelection& list, const std::string& path) const {
    return checked(list.indices, path);
  }
  [[nodiscard]] std::vector<Index> select(const LabelSelection& wanted, const std::string& path) const {
    std::vector<Index> indices;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (labels[i] == wanted.label) indices.push_back(static_cast<Index>(i));
    }
    if (!indices.empty()) return indices;
    throw Error(scene.source, path + ".label", std::to_string(wanted.label),
                "a label of its tets: " + known_labels());
  }
  [[nodiscard]] std::string known_labels() const {
    std::string text;
    for (const double label : std::set<double>(labels.begin(), labels.end()))
      text += (text.empty() ? "" : ", ") + number_text(label);
    return text;
  }
  [[nodiscard]] std::vector<Index> select(const NearSelection& near, const std::string& path) const {
    const Index other = body_named(scene, near.body, path + ".near.body", body);
    return where([&](const Vec3& p) {
      return (!near.box || contains(*near.box, p)) && is_near(bodies, other, p, near.distance);
    });
  }
  [[nodiscard]] std::vector<Index> checked(const std::vector<Index>& indices, const std::string& path) const {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const bool exists = indices[i] >= 0 && static_cast<std::size_t>(indices[i]) < points.size();
      if (exists && !is_left_out(indices[i])) continue;
      throw Error(scene.source, path + "." + what + "s[" + std::to_string(i) + "]",
                  std::to_string(indices[i]) + (exists ? ", a point in no tet" : ""),
                  exists ? "points of tets"
                         : "a " + what + " index in [0, " + std::to_string(points.size() - 1) + "]");
    }
    return indices;
  }
};

}  // namespace palpate
