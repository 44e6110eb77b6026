#pragma once

#include <array>
#include <span>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::io {

/// Unit normals of triangle corners (n_triangles x 3), for shading: the mean, weighted by area, of the
/// triangles at that point whose normals differ from this one by less than 35 degrees. So round shapes look
/// round and boxes keep their edges. Zero for triangles without area. O(n_triangles x triangles a point).
std::vector<std::array<Vec3, 3>> corner_normals(std::span<const Vec3> points,
                                                std::span<const Triangle> triangles);

}  // namespace palpate::io
