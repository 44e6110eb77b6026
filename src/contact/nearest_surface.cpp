#include "contact/nearest_surface.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

#include "geometry/predicates.hpp"

namespace palpate {

Vec3 nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double l2 = squared_length(ab);
  const double t = l2 > 0.0 ? std::clamp(dot(p - a, ab) / l2, 0.0, 1.0) : 0.0;
  return a + t * ab;
}

Vec3 face_normal(const Bodies& bodies, std::span<const Vec3> positions, Index tet, std::size_t opposite) {
  const Tet& corners = at(bodies.tets(), tet);
  const auto& [i, j, k] = outward_face[opposite];
  const Vec3& corner = at(positions, corners[i]);
  return normalized(cross(at(positions, corners[j]) - corner, at(positions, corners[k]) - corner));
}

Vec3 nearest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& t) {
  return nearest_on_triangle(p, t, cross(t[1] - t[0], t[2] - t[0]));
}

Vec3 nearest_on_rim(const Vec3& p, const std::array<Vec3, 3>& t) {
  Vec3 best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 q = nearest_on_segment(p, t[i], t[(i + 1) % 3]);
    const double distance = squared_length(q - p);
    if (distance < best_distance) {
      best_distance = distance;
      best = q;
    }
  }
  return best;
}

bool is_nearer(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal,
               double radius) {
  const auto is_left_of = [&](const Vec3& from, const Vec3& to) {
    return dot(cross(to - from, p - from), normal) >= 0.0;
  };
  if (is_left_of(a, b) && is_left_of(b, c) && is_left_of(c, a) && squared_length(normal) > 0.0) return true;
  const double r2 = radius * radius;
  // The other end is an end of the next side, and tested there.
  const auto is_near = [&](const Vec3& from, const Vec3& to) {
    const double l2 = squared_length(to - from);
    const double along = dot(p - from, to - from);
    const double to_corner = squared_length(p - from);
    return to_corner < r2 || (along > 0.0 && along < l2 && to_corner * l2 - along * along < r2 * l2);
  };
  return is_near(a, b) || is_near(b, c) || is_near(c, a);
}

namespace {

constexpr std::size_t few = 32;  // with fewer tets, a linear search is faster than a table

std::size_t place_of(Index tet) {
  return static_cast<std::size_t>(tet) * 0x9E3779B97F4A7C15ULL >> 32;
}

}  // namespace

void ExitSearch::start(Index tet) {
  if (!table_.empty()) std::fill(table_.begin(), table_.end(), -1);
  table_.clear();
  reached_.assign(1, tet);
}

bool ExitSearch::is_in_table(Index tet) const {
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = place_of(tet) & mask;
  while (table_[slot] >= 0 && table_[slot] != tet) slot = (slot + 1) & mask;
  return table_[slot] == tet;
}

/// Adds a tet that has not been reached yet.
void ExitSearch::add(Index tet) {
  reached_.push_back(tet);
  if (reached_.size() < few) return;
  if (2 * reached_.size() > table_.size()) {
    grow();
  } else {
    put_in_table(tet);
  }
}

void ExitSearch::put_in_table(Index tet) {
  const std::size_t mask = table_.size() - 1;
  std::size_t slot = place_of(tet) & mask;
  while (table_[slot] >= 0) slot = (slot + 1) & mask;
  table_[slot] = tet;
}

/// Makes a table with room for twice the tets reached, and puts them in.
void ExitSearch::grow() {
  table_.assign(std::bit_ceil(4 * reached_.size()), -1);
  for (const Index tet : reached_) put_in_table(tet);
}

SurfacePoint ExitSearch::nearest(const Bodies& bodies, std::span<const Vec3> positions, Index tet,
                                 const Vec3& p, Index without, double radius, double enough) {
  SurfacePoint best{p, {}, radius};
  const auto reach = [&] { return best.distance > enough ? best.distance : 0.0; };
  walk(
      bodies, positions, tet, p, without, reach, [](const Vec3&) { return true; },
      [&](Index here, std::size_t opposite, const Vec3& q, double distance) {
        const Vec3 outward = normalized(q - p);
        best = {q, outward == Vec3{} ? face_normal(bodies, positions, here, opposite) : outward, distance,
                here, opposite};
      });
  return best;
}

namespace {

// Limits of the cosine between a direction and the normal of a side.
constexpr double along = 0.75;  // two faces at a right angle cannot both be above it
constexpr double against = -0.3;

}  // namespace

double ExitSearch::distance_to_side(const Bodies& bodies, std::span<const Vec3> positions, Index tet,
                                    const Vec3& p, const Vec3& direction, double radius, double band) {
  double nearest = radius;
  double farther = 0.0;  // of the face that was asked for last
  walk(
      bodies, positions, tet, p, -1, [&] { return nearest; },
      [&](const Vec3& normal) {
        const double cosine = dot(normalized(normal), direction);
        const double inside = std::min(along - cosine, cosine - against);
        farther = inside < band ? radius * (1.0 - inside / band) : 0.0;
        return inside >= 0.0 && farther < nearest;
      },
      [&](Index, std::size_t, const Vec3&, double distance) {
        nearest = std::min(nearest, distance + farther);
      });
  return nearest;
}

Index ExitSearch::tet_of(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                         const Vec3& x) {
  const double most = length(x - p);
  const ExitAhead ahead = exit_ahead(bodies, positions, tet, p, normalized(x - p), most);
  if (!ahead.leaves() && ahead.tet >= 0) return ahead.tet;
  walk(
      bodies, positions, tet, x, -1, [&] { return most; }, [](const Vec3&) { return false; },
      [](Index, std::size_t, const Vec3&, double) {});
  const auto found = std::ranges::find_if(reached_, [&](Index t) {
    const Tet& corners = at(bodies.tets(), t);
    return point_in_tet(x, at(positions, corners[0]), at(positions, corners[1]), at(positions, corners[2]),
                        at(positions, corners[3]));
  });
  return found == reached_.end() ? -1 : *found;
}

bool ExitSearch::stays_clear(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                             const Vec3& direction, double radius, double moved, double rotated) {
  constexpr double sliver = 1e-12;  // squared sine of an angle below which a normal is too inexact
  start(tet);
  std::size_t next = 0;
  while (next < reached_.size()) {
    const Index here = reached_[next++];
    const Tet& corners = at(bodies.tets(), here);
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      const Index neighbor = at(bodies.tet_neighbors(), here)[opposite];
      if (neighbor >= 0 && has_reached(neighbor)) continue;
      const auto& [i, j, k] = outward_face[opposite];
      const Vec3& a = at(positions, corners[i]);
      const Vec3& b = at(positions, corners[j]);
      const Vec3& c = at(positions, corners[k]);
      const Vec3 normal = cross(b - a, c - a);
      const double n2 = squared_length(normal);
      const double ab2 = squared_length(b - a);
      const double ac2 = squared_length(c - a);
      if (!(n2 > sliver * ab2 * ac2)) return false;
      const double to_plane = dot(a - p, normal);
      if (to_plane * to_plane >= radius * radius * n2 || !is_nearer(p, a, b, c, normal, radius)) continue;
      if (neighbor >= 0) {
        add(neighbor);
        continue;
      }
      // The ends of both edges move, and a relative change of a vector changes its unit vector by at most
      // twice as much.
      const double change = 2.0 * moved * (std::sqrt(ab2) + std::sqrt(ac2)) + 4.0 * moved * moved;
      const double rotation = 2.0 * change / std::sqrt(n2) + rotated;
      const double cosine = dot(normal, direction) / std::sqrt(n2);
      if (cosine <= along + rotation && cosine >= against - rotation) return false;
    }
  }
  return true;
}

ExitAhead exit_ahead(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                     const Vec3& direction, double most) {
  constexpr int most_tets = 256;  // limit for a walk that rounding has made a loop
  for (int i = 0; i < most_tets; ++i) {
    const Tet& corners = at(bodies.tets(), tet);
    double exit = std::numeric_limits<double>::infinity();
    std::size_t through = 4;
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      const auto& [a, b, c] = outward_face[opposite];
      const Vec3& corner = at(positions, corners[a]);
      const Vec3 normal = cross(at(positions, corners[b]) - corner, at(positions, corners[c]) - corner);
      const double speed = dot(normal, direction);
      if (!(speed > 0.0)) continue;
      const double distance = dot(normal, corner - p) / speed;
      if (distance < exit) {
        exit = distance;
        through = opposite;
      }
    }
    if (through == 4) return {};
    if (exit >= most) return {tet, 4, most};
    const Index next = at(bodies.tet_neighbors(), tet)[through];
    if (next < 0) return {tet, through, std::max(0.0, exit)};
    tet = next;
  }
  return {};
}

double surface_ahead(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                     const Vec3& direction) {
  const double infinity = std::numeric_limits<double>::infinity();
  const ExitAhead exit = exit_ahead(bodies, positions, tet, p, direction, infinity);
  return exit.leaves() ? exit.distance : infinity;
}

SurfacePoint nearest_surface_point(const Bodies& bodies, std::span<const Vec3> positions, Index body,
                                   const Vec3& p, Index without) {
  SurfacePoint best{p, {0.0, 0.0, 1.0}, std::numeric_limits<double>::infinity()};
  const Range triangles = at(bodies.bodies(), body).triangles;
  for (Index t = triangles.begin; t < triangles.end; ++t) {
    const Triangle& corners = at(bodies.triangles(), t);
    if (without >= 0 && std::find(corners.begin(), corners.end(), without) != corners.end()) continue;
    const std::array<Vec3, 3> triangle{at(positions, corners[0]), at(positions, corners[1]),
                                       at(positions, corners[2])};
    const Vec3 normal = normalized(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
    if (normal == Vec3{}) continue;  // without area: its edges belong to neighbouring faces, too
    const Vec3 q = nearest_on_triangle(p, triangle);
    const double distance = length(q - p);
    if (distance >= best.distance) continue;
    const Vec3 outward = normalized(q - p);
    best = {q, outward == Vec3{} ? normal : outward, distance};
  }
  return best;
}

}  // namespace palpate
