#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/outcomes.hpp>

#include "geometry/box.hpp"
#include "geometry/box_tree.hpp"
#include "mesh/faces.hpp"
#include "sim/checked_body.hpp"

// Volumes of parts of bodies, computed by cutting tets.
namespace palpate {
namespace {

using Corners = std::array<Vec3, 4>;

double six_volumes(const Corners& c) {
  return dot(cross(c[1] - c[0], c[2] - c[0]), c[3] - c[0]);
}

Corners corners_of(const Tet& tet, std::span<const Vec3> positions) {
  return {at(positions, tet[0]), at(positions, tet[1]), at(positions, tet[2]), at(positions, tet[3])};
}

double volume_of(const Corners& tet, std::span<const HalfSpace> spaces);

/// Volume of a prism over the triangle (a, b, c), as three tets.
double volume_of_prism(const std::array<Vec3, 3>& low, const std::array<Vec3, 3>& high,
                       std::span<const HalfSpace> spaces) {
  return volume_of({low[0], low[1], low[2], high[0]}, spaces) +
         volume_of({low[1], low[2], high[0], high[1]}, spaces) +
         volume_of({low[2], high[0], high[1], high[2]}, spaces);
}

/// Volume of the part of a tet in all half-spaces, >= 0. Each half-space leaves one tet or three.
double volume_of(const Corners& tet, std::span<const HalfSpace> spaces) {
  if (spaces.empty()) return std::abs(six_volumes(tet)) / 6.0;
  const HalfSpace& space = spaces.front();
  const auto others = spaces.subspan(1);
  std::array<double, 4> height{};
  std::array<std::size_t, 4> order{};  // corners inside first
  std::size_t inside = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    height[i] = dot(tet[i] - space.point, space.normal);
    if (height[i] > 0.0) order[inside++] = i;
  }
  if (inside == 0) return 0.0;
  if (inside == 4) return volume_of(tet, others);
  std::size_t next = inside;
  for (std::size_t i = 0; i < 4; ++i)
    if (!(height[i] > 0.0)) order[next++] = i;
  const auto corner = [&](std::size_t i) { return tet[order[i]]; };
  const auto cut = [&](std::size_t in, std::size_t out) {
    const double a = height[order[in]];
    const double s = a / (a - height[order[out]]);
    return (1.0 - s) * corner(in) + s * corner(out);
  };
  if (inside == 1) return volume_of({corner(0), cut(0, 1), cut(0, 2), cut(0, 3)}, others);
  if (inside == 2)
    return volume_of_prism({corner(0), cut(0, 2), cut(0, 3)}, {corner(1), cut(1, 2), cut(1, 3)}, others);
  return volume_of_prism({corner(0), corner(1), corner(2)}, {cut(0, 3), cut(1, 3), cut(2, 3)}, others);
}

double signed_volume_of(const Corners& tet, std::span<const HalfSpace> spaces) {
  return std::copysign(volume_of(tet, spaces), six_volumes(tet));
}

void check(std::span<const HalfSpace> spaces) {
  for (const HalfSpace& space : spaces) {
    if (is_finite(space.point) && is_finite(space.normal) && space.normal != Vec3{}) continue;
    throw Error("outcomes", "half-space", "a normal that is zero, or a number that is not finite",
                "finite numbers and a direction");
  }
}

/// The four half-spaces of a tet; empty if the tet has no volume.
std::vector<HalfSpace> faces_of(const Corners& tet) {
  const double volume = six_volumes(tet);
  std::vector<HalfSpace> spaces;
  if (volume == 0.0) return spaces;
  for (const auto& [i, j, k] : outward_face) {
    const Vec3 outward = cross(tet[j] - tet[i], tet[k] - tet[i]);
    spaces.push_back({tet[i], std::copysign(1.0, -volume) * outward});
  }
  return spaces;
}

Box box_of_corners(const Corners& tet) {
  Box box;
  for (const Vec3& corner : tet) box.extend(corner);
  return box;
}

}  // namespace

double volume_in(const Bodies& bodies, Index body, std::span<const Vec3> positions,
                 std::span<const HalfSpace> spaces) {
  check(spaces);
  const Range tets = checked_body(bodies, body).tets;
  double sum = 0.0;
  for (Index t = tets.begin; t < tets.end; ++t)
    sum += signed_volume_of(corners_of(at(bodies.tets(), t), positions), spaces);
  return sum;
}

double volume_within(const Bodies& bodies, Index body, Index other, std::span<const Vec3> positions,
                     std::span<const HalfSpace> spaces) {
  check(spaces);
  const Range tets = checked_body(bodies, body).tets;
  const Range region = checked_body(bodies, other).tets;
  std::vector<Corners> of_region;
  std::vector<Box> boxes;
  for (Index t = region.begin; t < region.end; ++t) {
    of_region.push_back(corners_of(at(bodies.tets(), t), positions));
    boxes.push_back(box_of_corners(of_region.back()));
  }
  const BoxTree tree(std::move(boxes));
  double sum = 0.0;
  for (Index t = tets.begin; t < tets.end; ++t) {
    const Corners tet = corners_of(at(bodies.tets(), t), positions);
    tree.for_each_within(
        box_of_corners(tet), [] { return 0.0; },
        [&](std::size_t r) {
          std::vector<HalfSpace> all = faces_of(of_region[r]);
          if (all.empty()) return;
          all.insert(all.end(), spaces.begin(), spaces.end());
          sum += std::copysign(1.0, six_volumes(of_region[r])) * signed_volume_of(tet, all);
        });
  }
  return sum;
}

}  // namespace palpate
