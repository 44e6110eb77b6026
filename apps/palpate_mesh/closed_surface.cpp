#include "closed_surface.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "numbers.hpp"
#include "scene/first_scene.hpp"
#include "self_intersections.hpp"
#include "surface_edges.hpp"

namespace palpate::app {
namespace {

constexpr double default_hole_fraction =
    0.05;  // relative to the diagonal; larger holes are closed only if the user asks

Box box_of(const Surface& surface) {
  Box box;
  for (const Triangle& triangle : surface.triangles) {
    for (const Index corner : triangle) box.extend(at(surface.points, corner));
  }
  return box;
}

/// The diagonal of the box, mm. Throws Error if it is 0, or so large that CGAL's mesher loses digits and does
/// not end.
double diagonal_of(const Box& box, double millimeters, const std::string& source) {
  constexpr double least = 1e-9;
  constexpr double most = 1e9;
  const double diagonal = millimeters * length(box.upper - box.lower);
  if (diagonal >= least && diagonal <= most) return diagonal;
  throw Error(source, "", fmt::format("a diagonal of {:.4g} mm", diagonal),
              "a diagonal from 1e-9 to 1e9 mm (--unit?)");
}

std::string edge_text(const Surface& surface, const Edge& edge) {
  const auto end = [&](Index p) { return fmt::format("point {} {}", p, place_text(at(surface.points, p))); };
  return fmt::format("edge from {} to {}", end(edge[0]), end(edge[1]));
}

std::string holes_text(std::size_t holes, std::size_t edges, double largest) {
  return holes == 1 ? fmt::format("a hole of {} edges, {} mm across", edges, short_text(largest))
                    : fmt::format("{} holes, the largest {} mm across", holes, short_text(largest));
}

[[noreturn]] void fail_open(const Surface& surface, const SurfaceEdges& edges, const std::vector<Hole>& holes,
                            double millimeters, const std::string& source) {
  double largest = 0.0;
  for (const Hole& hole : holes) largest = std::max(largest, millimeters * hole.size);
  if (edges.odd_edges > 0) {
    std::string found =
        edges.triangles_at_first == 1
            ? fmt::format("the border of a sheet that is attached to an edge of other triangles")
            : fmt::format("{} triangles", edges.triangles_at_first);
    found += fmt::format(" ({} that are not manifold in all", counted(edges.odd_edges, "edge"));
    if (!holes.empty()) found += ", and " + holes_text(holes.size(), holes.front().edges.size(), largest);
    throw Error(source, edge_text(surface, *edges.first_bad), found + ")",
                "a closed surface: two triangles at each edge, or four");
  }
  constexpr double up = 1.001;  // so that a hole of the size in the message is closed
  throw Error(source, edge_text(surface, holes.front().edges.front()),
              holes_text(holes.size(), holes.front().edges.size(), largest),
              fmt::format("a closed surface; --close-holes {} closes {}", short_text(up * largest),
                          holes.size() == 1 ? "it" : "them"));
}

/// Closes the holes that are small enough and adds a remark on each. Throws Error if larger ones are left.
void close_holes(Surface& surface, const SurfaceEdges& edges, double most, double millimeters,
                 const std::string& source, std::vector<std::string>& remarks) {
  std::vector<Hole> open;
  double largest = 0.0;
  std::size_t border = 0;
  for (const Hole& hole : edges.holes) {
    if (millimeters * hole.size > most) {
      open.push_back(hole);
      continue;
    }
    largest = std::max(largest, millimeters * hole.size);
    border = hole.edges.size();
  }
  if (!open.empty() || edges.odd_edges > 0) fail_open(surface, edges, open, millimeters, source);
  if (edges.holes.empty()) return;
  for (const Hole& hole : edges.holes) close_hole(surface, hole);
  remarks.push_back("closed " + holes_text(edges.holes.size(), border, largest));
}

/// Adds a remark where the surface is too small or too large for an organ, with the unit that would fit.
void remark_size(const Box& box, double millimeters, std::vector<std::string>& remarks) {
  constexpr double shortest = 1.0;    // mm
  constexpr double longest = 3000.0;  // mm
  const Vec3 sides = box.upper - box.lower;
  const double side = std::max({sides.x, sides.y, sides.z});
  if (millimeters * side >= shortest && millimeters * side <= longest) return;
  const MeshUnit unit = guess_unit(side);
  remarks.push_back(fmt::format("is {} mm long: is it in another unit?{}", short_text(millimeters * side),
                                unit.name.empty() ? "" : fmt::format(" (--unit {})", unit.name)));
}

void remark_self_intersections(const SelfIntersections& found, std::vector<std::string>& remarks) {
  if (found.pairs == 0) return;
  remarks.push_back(
      fmt::format("cuts itself: {} of triangles cross, the first near {}; what two sheets enclose "
                  "together counts as outside",
                  counted(found.pairs, "pair"), place_text(found.segments.front()[0])));
}

/// Records where parts of the surface touch in edges or points, and adds a remark.
void join_parts(const Surface& surface, const SurfaceEdges& edges, ClosedSurface& closed) {
  for (const Edge& edge : edges.shared_edges)
    closed.joints.push_back({at(surface.points, edge[0]), at(surface.points, edge[1])});
  const std::vector<Index> points = touching_points(surface);
  for (const Index p : points) closed.joints.push_back({at(surface.points, p), at(surface.points, p)});
  if (!edges.shared_edges.empty()) {
    closed.remarks.push_back(
        fmt::format("{} of four or more triangles, where parts touch: they are joined there",
                    counted(edges.shared_edges.size(), "edge")));
  }
  if (!points.empty()) {
    closed.remarks.push_back(
        fmt::format("{} where parts touch: they are joined there", counted(points.size(), "point")));
  }
}

}  // namespace

ClosedSurface closed_surface(Surface surface, const Shaping& shaping, const std::string& source) {
  if (surface.triangles.empty()) throw Error(source, "", "no triangles", "a closed surface");
  const double millimeters = shaping.unit_millimeters;
  const Box box = box_of(surface);
  const double diagonal = diagonal_of(box, millimeters, source);
  ClosedSurface closed;
  const SurfaceEdges edges = edges_of(surface);
  close_holes(surface, edges, shaping.close_holes.value_or(default_hole_fraction * diagonal), millimeters,
              source, closed.remarks);
  closed.one_sided = edges.one_sided;
  SelfIntersections cuts = self_intersections(surface);
  remark_self_intersections(cuts, closed.remarks);
  closed.joints = std::move(cuts.segments);
  join_parts(surface, edges, closed);
  if (!edges.one_sided) {
    closed.remarks.emplace_back(
        "some triangles face inwards, others outwards: the volume is estimated on a lattice");
  }
  remark_size(box, millimeters, closed.remarks);
  for (Vec3& point : surface.points) point = millimeters * point;
  for (auto& joint : closed.joints) joint = {millimeters * joint[0], millimeters * joint[1]};
  closed.surface = std::move(surface);
  return closed;
}

}  // namespace palpate::app
