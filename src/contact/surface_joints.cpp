#include "contact/surface_joints.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/triangle.hpp"
#include "simd/triangle_normals.hpp"

namespace palpate {
namespace {

constexpr double smooth_cosine = 0.5;  // 60 degrees
/// Sine of the angle between two triangles below which they are flat, since it may come from rounding.
constexpr double flat_sine = 1e-3;
/// A point is hollow although the surface bends outwards there, if that is less than this fraction of its
/// bend inwards: measured surfaces are not smooth.
constexpr double outwards_of_inwards = 0.3;

}  // namespace

SurfaceJoints::SurfaceJoints(const Bodies& bodies)
    : sides_(bodies.triangles().size()),
      hollow_(bodies.points_rest().size()),
      creases_(bodies.triangles().size()) {
  std::vector<Bends> bends(bodies.points_rest().size());
  find_bends(bodies, bends);
  std::ranges::transform(bends, hollow_.begin(), [](const Bends& b) {
    return b.inwards > 0.0 && b.outwards <= outwards_of_inwards * b.inwards ? 1 : 0;
  });
  add_creases(bodies, simd::SmoothTriangle::sharp_bits,
              [&](Index t, std::size_t i, Index, Index) { return over(t, i) < 0; });
  add_creases(bodies, simd::SmoothTriangle::hollow_bits,
              [&](Index t, std::size_t i, Index first, Index second) {
                return over(t, i) >= 0 && (smooth_over(t, i, first) < 0 || smooth_over(t, i, second) < 0);
              });
}

void SurfaceJoints::find_bends(const Bodies& bodies, std::vector<Bends>& bends) {
  const std::span<const Triangle> triangles = bodies.triangles();
  std::vector<Vec3> normals(triangles.size());
  std::ranges::transform(triangles, normals.begin(),
                         [&](const Triangle& t) { return normalized(area_vector(bodies.points_rest(), t)); });
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      Side& side = sides_[t][i];
      side.other = bodies.triangle_neighbors()[t][i];
      if (side.other < 0 || !(dot(normals[t], at(normals, side.other)) >= smooth_cosine)) continue;
      const double sine = length(cross(normals[t], at(normals, side.other)));
      side.bend = sine < flat_sine ? flat : bent;
      if (side.bend == flat) continue;
      const Index first = triangles[t][(i + 1) % 3];
      const Index second = triangles[t][(i + 2) % 3];
      const bool is_inwards =
          height_of_third(bodies.points_rest(), at(triangles, side.other), first, second, normals[t]) > 0.0;
      for (const Index point : {first, second}) {
        double& most = is_inwards ? at(bends, point).inwards : at(bends, point).outwards;
        most = std::max(most, sine);
      }
    }
  }
}

/// Sets the bits of creases of one kind, from `first_bit` on.
/// \param is_crease  function of a triangle, its side, and the ends of the side
template <class IsCrease>
void SurfaceJoints::add_creases(const Bodies& bodies, unsigned first_bit, IsCrease&& is_crease) {
  const std::span<const Triangle> triangles = bodies.triangles();
  std::vector<std::uint8_t> is_end(bodies.points_rest().size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index first = triangles[t][(i + 1) % 3];
      const Index second = triangles[t][(i + 2) % 3];
      if (!is_crease(static_cast<Index>(t), i, first, second)) continue;
      creases_[t] |= 1U << (first_bit + i);
      at(is_end, first) = at(is_end, second) = 1;
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (at(is_end, triangles[t][i]) != 0) creases_[t] |= 8U << (first_bit + i);
    }
  }
}

}  // namespace palpate
