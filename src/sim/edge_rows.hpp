#pragma once

#include <array>
#include <vector>

#include <palpate/mesh.hpp>

#include "sim/edge_response.hpp"

// What the rows of edge contacts, of edges at rims and of insets have in common (EdgeResponse).
namespace palpate::edge_rows {

/// Stiffness at an end, relative to that of a contact.
inline constexpr double part_of_an_end = 0.5;
/// An end acts only if the product of its weights is at least this. Smaller ones have no effect on the bodies
/// but cost a row of the solver. Most edges of uneven faces in contact have smaller ones.
inline constexpr double least_weight = 0.05;
/// The weight less `least_weight`, so that forces begin at zero.
[[nodiscard]] double beyond_least(double weight);

/// 0 to 1: how far a surface is a side as seen along a contact direction, by the cosine of the angle between
/// its normal and the direction: 0 for a face (0.95 or more), 1 for a side (0.6 or less).
[[nodiscard]] double side_of(double cosine);

/// The point where an edge meets a triangle.
struct Meeting {
  Index triangle;
  double parameter;               ///< on the edge
  std::array<double, 3> weights;  ///< in the triangle
  double side;                    ///< side_of() the triangle
  double steepness;               ///< of the edge over the triangle: sine of the angle between them
};

[[nodiscard]] Meeting meeting(const EdgeResponse::Frame& frame, const Edge& edge, Index triangle,
                              double parameter, const Vec3& direction);

/// Fraction of an edge of this depth that the contact of a point supports: 1 if it has half the force or
/// more.
[[nodiscard]] double held_by(const EdgeResponse::Frame& frame, Index contact, double depth);

/// Factor of the force of an edge by the angle of its own body there: zero if the surface is flat or concave,
/// one for convex edges of a few degrees or more. A body that comes through a face has points or convex edges
/// in it.
[[nodiscard]] double sharpness(const EdgeResponse::Frame& frame, Index edge);

/// Whether an edge is at the seam of its body with another one: there is no crease.
[[nodiscard]] bool borders_flush_face(const EdgeResponse::Frame& frame, Index edge);

[[nodiscard]] EdgeEnd end_of(Index edge, Index body, Index number, double stiffness, double depth,
                             const Vec3& direction);
/// Adds a row between a point of an edge and a point of a triangle.
void add_at_triangle(const EdgeResponse::Frame& frame, const Edge& edge, const Meeting& meeting, EdgeEnd end,
                     std::vector<EdgeResponse::Row>& rows);

}  // namespace palpate::edge_rows
