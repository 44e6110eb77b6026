#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <palpate/mesh.hpp>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"

namespace palpate {
namespace {

/// Accumulates minimum, mean and maximum.
class SpreadOf {
 public:
  void add(double x) {
    min_ = std::min(min_, x);
    max_ = std::max(max_, x);
    sum_ += x;
    ++count_;
  }
  [[nodiscard]] Spread get() const {
    return count_ == 0 ? Spread{} : Spread{min_, sum_ / static_cast<double>(count_), max_};
  }

 private:
  double min_ = std::numeric_limits<double>::infinity();
  double max_ = -std::numeric_limits<double>::infinity();
  double sum_ = 0.0;
  std::size_t count_ = 0;
};

/// The angle at edge (a, b) between the faces through c and d, in degrees.
double dihedral_angle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 axis = b - a;
  const Vec3 m = cross(axis, c - a);
  const Vec3 n = cross(axis, d - a);
  return std::atan2(length(cross(m, n)), dot(m, n)) * 180.0 / std::numbers::pi;
}

void add_dihedral_angles(const std::array<Vec3, 4>& p, SpreadOf& angles) {
  angles.add(dihedral_angle(p[0], p[1], p[2], p[3]));
  angles.add(dihedral_angle(p[0], p[2], p[1], p[3]));
  angles.add(dihedral_angle(p[0], p[3], p[1], p[2]));
  angles.add(dihedral_angle(p[1], p[2], p[0], p[3]));
  angles.add(dihedral_angle(p[1], p[3], p[0], p[2]));
  angles.add(dihedral_angle(p[2], p[3], p[0], p[1]));
}

}  // namespace

MeshStatistics mesh_statistics(const Bodies& bodies, std::span<const Vec3> positions, Index body) {
  Body part;
  if (body >= 0) {
    part = at(bodies.bodies(), body);
  } else if (bodies.body_count() > 0) {
    const Body& last = bodies.bodies().back();
    part = {"", {0, last.points.end}, {0, last.edges.end}, {0, last.triangles.end}, {0, last.tets.end}};
  }
  MeshStatistics s;
  s.points = part.points.size();
  s.edges = part.edges.size();
  s.triangles = part.triangles.size();
  s.tets = part.tets.size();

  SpreadOf lengths;
  for (Index e = part.edges.begin; e < part.edges.end; ++e) {
    const Edge& edge = at(bodies.edges(), e);
    lengths.add(length(at(positions, edge[1]) - at(positions, edge[0])));
  }
  SpreadOf angles;
  Box bounds;
  for (Index t = part.tets.begin; t < part.tets.end; ++t) {
    const Tet& tet = at(bodies.tets(), t);
    const std::array<Vec3, 4> p{at(positions, tet[0]), at(positions, tet[1]), at(positions, tet[2]),
                                at(positions, tet[3])};
    s.volume += dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0])) / 6.0;
    add_dihedral_angles(p, angles);
    for (const Vec3& corner : p) bounds.extend(corner);
  }
  s.edge_length = lengths.get();
  s.dihedral_angle = angles.get();
  if (s.tets > 0) {
    s.lower = bounds.lower;
    s.upper = bounds.upper;
  }
  return s;
}

}  // namespace palpate
