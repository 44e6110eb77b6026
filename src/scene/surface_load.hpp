#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/model.hpp>

#include "geometry/vector.hpp"
#include "scene/scene.hpp"

namespace palpate {

/// The surface triangles of a body with all corners selected.
/// \param selected  points of the body, as indices in the body
inline std::vector<Index> triangles_of(const Bodies& bodies, Index body, std::span<const Index> selected) {
  const Body& range = at(bodies.bodies(), body);
  std::vector<std::uint8_t> chosen(static_cast<std::size_t>(range.points.size()), 0);
  for (const Index i : selected) at(chosen, i) = 1;
  std::vector<Index> triangles;
  for (Index t = range.triangles.begin; t < range.triangles.end; ++t) {
    const Triangle& corners = at(bodies.triangles(), t);
    if (std::ranges::all_of(corners, [&](Index p) { return at(chosen, p - range.points.begin) != 0; }))
      triangles.push_back(t);
  }
  return triangles;
}

/// A pressure or traction of a scene, on the surface triangles of a body with all corners selected. Throws
/// Error naming `where` if there is none.
/// \param selected  points of the body, as indices in the body
inline SurfaceLoad surface_load_of(const Scene& scene, const Bodies& bodies, Index body, const Load& load,
                                   std::span<const Index> selected, const std::string& where) {
  SurfaceLoad surface{.triangles = triangles_of(bodies, body, selected),
                      .pressure = load.pressure.value_or(0.0),
                      .traction = load.traction.value_or(Vec3{}),
                      .ramp = load.ramp.value_or(Ramp{})};
  if (!surface.triangles.empty()) return surface;
  throw Error(scene.source, where, "no surface triangle with all of its corners",
              "one or more triangles selected");
}

}  // namespace palpate
