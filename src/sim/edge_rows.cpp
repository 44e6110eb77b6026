#include "sim/edge_rows.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/triangle.hpp"

namespace palpate {
namespace edge_rows {

double side_of(double cosine) {
  constexpr double faces_along = 0.95;
  constexpr double faces_aside = 0.6;
  return std::clamp((faces_along - cosine) / (faces_along - faces_aside), 0.0, 1.0);
}

double beyond_least(double weight) {
  return std::max(0.0, (weight - least_weight) / (1.0 - least_weight));
}

Meeting meeting(const EdgeResponse::Frame& frame, const Edge& edge, Index triangle, double parameter,
                const Vec3& direction) {
  const Triangle& corners = at(frame.bodies.triangles(), triangle);
  const std::array<Vec3, 3> t = corners_of(frame.positions, corners);
  const Vec3& a = at(frame.positions, edge[0]);
  const Vec3 x = a + parameter * (at(frame.positions, edge[1]) - a);
  Meeting found{triangle, parameter, weights_in(t, area_vector(t), x), 0.0, 0.0};
  const Vec3 normal = frame.surfaces.normals->at_point_now(frame.positions, triangle, x, SurfaceNormals::far);
  found.steepness = std::abs(dot(normalized(at(frame.positions, edge[1]) - a), normal));
  found.side = side_of(dot(normal, direction));
  return found;
}

double held_by(const EdgeResponse::Frame& frame, Index contact, double depth) {
  constexpr double enough = 0.5;
  if (contact < 0) return 0.0;
  const double force = at(frame.scales, contact) * at(frame.table.contacts().depth, contact);
  return std::min(1.0, force / (enough * depth));
}

double sharpness(const EdgeResponse::Frame& frame, Index edge) {
  constexpr double sharp = 0.25;        // sine
  constexpr double surely_sharp = 0.9;  // cosine
  const auto& [first, second] = at(frame.bodies.edge_triangles(), edge);
  if (second < 0) return 1.0;
  const Triangle& other = at(frame.bodies.triangles(), second);
  const Vec3 normal = normalized(area_vector(frame.positions, at(frame.bodies.triangles(), first)));
  const Vec3 other_normal = normalized(area_vector(frame.positions, other));
  const Edge& ends = at(frame.bodies.edges(), edge);
  if (height_of_third(frame.positions, other, ends[0], ends[1], normal) >= 0.0) return 0.0;
  if (dot(normal, other_normal) < surely_sharp) return 1.0;
  return std::min(1.0, length(cross(normal, other_normal)) / sharp);
}

bool borders_flush_face(const EdgeResponse::Frame& frame, Index edge) {
  return std::ranges::any_of(at(frame.bodies.edge_triangles(), edge),
                             [&](Index t) { return t >= 0 && frame.flush.covers(t); });
}

EdgeEnd end_of(Index edge, Index body, Index number, double stiffness, double depth, const Vec3& direction) {
  EdgeEnd end{.edge = edge, .body = body, .end = number, .law = {}};
  end.law.stiffness = stiffness;
  end.law.depth = depth;
  end.law.direction = direction;
  return end;
}

void add_at_triangle(const EdgeResponse::Frame& frame, const Edge& edge, const Meeting& meeting, EdgeEnd end,
                     std::vector<EdgeResponse::Row>& rows) {
  const Triangle& t = at(frame.bodies.triangles(), meeting.triangle);
  const auto& [w0, w1, w2] = meeting.weights;
  end.points = {edge[0], edge[1], t[0], t[1], t[2]};
  end.coefficients = {1.0 - meeting.parameter, meeting.parameter, -w0, -w1, -w2};
  rows.push_back({.end = end, .depth = end.law.depth});
}

}  // namespace edge_rows

fem::Coupling EdgeEnd::coupling() const {
  fem::Coupling coupling;
  coupling.points = points;
  coupling.coefficients = coefficients;
  return coupling;
}

}  // namespace palpate
