#include "contact/flush_faces.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/box.hpp"
#include "geometry/predicates.hpp"
#include "geometry/triangle.hpp"

namespace palpate {
namespace {

/// Distance from the other body up to which a triangle lies flush on it, relative to its size.
constexpr double gap_of_size = 1e-3;

/// The tets of a body near a box, sorted by their lower bound along x.
class TetsNear {
 public:
  TetsNear(const Bodies& bodies, std::span<const Vec3> positions, Index body, const Box& region)
      : bodies_(bodies), positions_(positions) {
    const Range& range = at(bodies.bodies(), body).tets;
    for (Index t = range.begin; t < range.end; ++t) {
      const Box box = box_of(positions, at(bodies.tets(), t));
      if (!box.overlaps(region)) continue;
      tets_.push_back({box, t});
      longest_ = std::max(longest_, box.upper.x - box.lower.x);
    }
    std::ranges::sort(tets_, {}, [](const Entry& e) { return e.box.lower.x; });
  }
  [[nodiscard]] bool contains(const Vec3& x) const {
    auto tet =
        std::ranges::lower_bound(tets_, x.x - longest_, {}, [](const Entry& e) { return e.box.lower.x; });
    for (; tet != tets_.end() && tet->box.lower.x <= x.x; ++tet) {
      if (!tet->box.contains(x)) continue;
      const Tet& t = at(bodies_.tets(), tet->tet);
      if (point_in_tet(x, at(positions_, t[0]), at(positions_, t[1]), at(positions_, t[2]),
                       at(positions_, t[3])))
        return true;
    }
    return false;
  }

 private:
  struct Entry {
    Box box;
    Index tet;
  };
  const Bodies& bodies_;
  std::span<const Vec3> positions_;
  std::vector<Entry> tets_;
  double longest_ = 0.0;
};

/// Whether just outside of a triangle, in the middle and at the corners, there is another body.
bool lies_on(const std::array<Vec3, 3>& corners, const TetsNear& other) {
  const Vec3 area = area_vector(corners);
  const Vec3 middle = (1.0 / 3.0) * (corners[0] + corners[1] + corners[2]);
  const Vec3 outside = gap_of_size * std::sqrt(length(area)) * normalized(area);
  constexpr double inwards = 0.02;
  return other.contains(middle + outside) && std::ranges::all_of(corners, [&](const Vec3& corner) {
           return other.contains(corner + inwards * (middle - corner) + outside);
         });
}

Box box_of_body(const Bodies& bodies, std::span<const Vec3> positions, Index body) {
  Box box;
  const Range& points = at(bodies.bodies(), body).points;
  for (Index p = points.begin; p < points.end; ++p) box.extend(at(positions, p));
  return box;
}

}  // namespace

FlushFaces::FlushFaces(const Bodies& bodies, std::span<const std::uint8_t> still,
                       std::span<const Vec3> positions)
    : covered_(bodies.triangles().size()) {
  for (Index a = 0; a < bodies.body_count(); ++a) {
    if (at(still, a) == 0) continue;
    Box box = box_of_body(bodies, positions, a);
    const double margin = gap_of_size * length(box.upper - box.lower);
    box = {box.lower - Vec3{margin, margin, margin}, box.upper + Vec3{margin, margin, margin}};
    for (Index b = 0; b < bodies.body_count(); ++b) {
      if (a == b || at(still, b) == 0) continue;
      const Box of_other = box_of_body(bodies, positions, b);
      if (!box.overlaps(of_other)) continue;
      const TetsNear other(bodies, positions, b, box);
      const Range& range = at(bodies.bodies(), a).triangles;
      for (Index t = range.begin; t < range.end; ++t) {
        if (at(covered_, t) == 0 && lies_on(corners_of(positions, at(bodies.triangles(), t)), other))
          at(covered_, t) = 1;
      }
    }
  }
  for (std::size_t t = 0; t < covered_.size(); ++t)
    if (covered_[t] != 0) triangles_.push_back(static_cast<Index>(t));
}

bool FlushFaces::leads_through(const Bodies& bodies, std::span<const Vec3> positions, Index body,
                               const Vec3& from, const Vec3& direction, double depth) const {
  const Range& range = at(bodies.bodies(), body).triangles;
  for (auto t = std::ranges::lower_bound(triangles_, range.begin); t != triangles_.end() && *t < range.end;
       ++t) {
    const std::array<Vec3, 3> corners = corners_of(positions, at(bodies.triangles(), *t));
    const Vec3 area = area_vector(corners);
    const double along = dot(area, direction);
    if (!(along > 0.0)) continue;
    const double distance = dot(area, corners[0] - from) / along;
    const double slack = gap_of_size * std::sqrt(length(area));
    if (distance < -slack || distance > depth + slack) continue;
    const std::array<double, 3> weights = weights_in(corners, area, from + distance * direction);
    if (std::ranges::min(weights) >= -gap_of_size) return true;
  }
  return false;
}

}  // namespace palpate
