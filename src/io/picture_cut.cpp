#include "io/picture_cut.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "geometry/vector.hpp"

namespace palpate::io {
namespace {

class Cutter {
 public:
  Cutter(const Bodies& bodies, std::span<const Vec3> positions, std::span<const double> values,
         const CutSettings& settings)
      : settings_(settings), normal_(normalized(settings.normal)) {
    result_.points.assign(positions.begin(), positions.end());
    result_.values.assign(values.begin(), values.end());
    result_.body_of_point.assign(bodies.body_of_point().begin(), bodies.body_of_point().end());
    for (std::size_t i = 0; i < bodies.triangles().size(); ++i) {
      const Triangle& t = bodies.triangles()[i];
      const Index body = bodies.body_of(t);
      if (at(settings.shown, body) == 0) continue;
      tet_ = bodies.triangle_tets()[i];
      at(settings.cut, body) == 0 ? add(t, all_edges) : add_clipped(t);
    }
    for (std::size_t t = 0; t < bodies.tets().size(); ++t) {
      const Tet& tet = bodies.tets()[t];
      const Index body = bodies.body_of(tet);
      tet_ = static_cast<Index>(t);
      if (at(settings.shown, body) != 0 && at(settings.cut, body) != 0) add_face(tet);
    }
  }
  CutSurface take() { return std::move(result_); }

 private:
  static constexpr std::uint8_t all_edges = 7;

  /// Height above the plane; the part with positive height is removed.
  [[nodiscard]] double height(Index p) const { return dot(at(result_.points, p) - settings_.point, normal_); }

  /// A new point where the segment from a, in front of the plane, to b, behind it, meets the plane.
  Index meeting(Index a, Index b) {
    const double fraction = height(a) / (height(a) - height(b));
    const Vec3 from = at(result_.points, a);
    const double value = at(result_.values, a);
    result_.points.push_back(from + fraction * (at(result_.points, b) - from));
    result_.values.push_back(value + fraction * (at(result_.values, b) - value));
    result_.body_of_point.push_back(at(result_.body_of_point, a));
    return static_cast<Index>(result_.points.size()) - 1;
  }

  void add(const Triangle& triangle, std::uint8_t edges) {
    result_.triangles.push_back(triangle);
    result_.edges.push_back(edges);
    result_.tet_of_triangle.push_back(tet_);
  }

  /// Adds the part of a triangle behind the plane: one or two triangles.
  void add_clipped(const Triangle& t) {
    std::vector<Index> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = t[i];
      const Index b = t[(i + 1) % 3];
      if (height(a) <= 0.0) corners.push_back(a);
      if (height(a) > 0.0 && height(b) < 0.0) corners.push_back(meeting(a, b));
      if (height(a) < 0.0 && height(b) > 0.0) corners.push_back(meeting(b, a));
    }
    add_polygon(corners);
  }

  /// Adds the section of a tet with the plane: a triangle or a quadrilateral.
  void add_face(const Tet& tet) {
    std::vector<Index> front;
    std::vector<Index> behind;
    for (const Index p : tet) (height(p) > 0.0 ? front : behind).push_back(p);
    std::vector<Index> corners;
    if (front.size() == 2) {
      corners = {meeting(front[0], behind[0]), meeting(front[0], behind[1]), meeting(front[1], behind[1]),
                 meeting(front[1], behind[0])};
    } else {
      for (const Index a : front) {
        for (const Index b : behind) corners.push_back(meeting(a, b));
      }
    }
    if (corners.size() >= 3) face_front(corners);
    add_polygon(corners);
  }

  /// Orients corners counter-clockwise as seen from the removed side.
  void face_front(std::vector<Index>& corners) const {
    const Vec3& a = at(result_.points, corners[0]);
    const Vec3 normal = cross(at(result_.points, corners[1]) - a, at(result_.points, corners[2]) - a);
    if (dot(normal, normal_) < 0.0) std::ranges::reverse(corners);
  }

  /// Adds a convex polygon of three or four corners. Its diagonal is not drawn as an edge.
  void add_polygon(const std::vector<Index>& c) {
    if (c.size() == 3) add({c[0], c[1], c[2]}, all_edges);
    if (c.size() != 4) return;
    add({c[0], c[1], c[2]}, 0b011);
    add({c[0], c[2], c[3]}, 0b110);
  }

  const CutSettings& settings_;
  Vec3 normal_;
  CutSurface result_;
  Index tet_ = 0;  ///< tet to which the added triangles belong
};

}  // namespace

CutSurface cut_open(const Bodies& bodies, std::span<const Vec3> positions, std::span<const double> values,
                    const CutSettings& settings) {
  return Cutter(bodies, positions, values, settings).take();
}

}  // namespace palpate::io
