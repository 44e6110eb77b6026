#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simd/cluster_query.hpp"

namespace palpate::simd::scalar {
namespace {

void load(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
          ClusterBlock& block) {
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const Cluster& cluster = *block.cluster[c];
    const auto list = point_lists.subspan(static_cast<std::size_t>(cluster.first_point), cluster.points);
    FixedPoint& lower = block.box[c].lower;
    FixedPoint& upper = block.box[c].upper;
    lower = upper = points[static_cast<std::size_t>(list[0])];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const FixedPoint& p = block.corners[c][i] = points[static_cast<std::size_t>(list[i])];
      lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z), 0};
      upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z), 0};
    }
  }
}

void gather(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
            ClusterBlock& block) {
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const Cluster& cluster = *block.cluster[c];
    const auto list = point_lists.subspan(static_cast<std::size_t>(cluster.first_point), cluster.points);
    for (std::size_t i = 0; i < list.size(); ++i)
      block.corners[c][i] = points[static_cast<std::size_t>(list[i])];
  }
}

void filter(const PointRows& rows, ClusterBlock& block) {
  std::size_t count = 0;
  block.candidates = block.candidate.data();
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const auto& [lower, upper, skips_marked] = block.box[c];
    block.first_candidate[c] = static_cast<std::uint32_t>(count);
    for (std::uint32_t r = block.first_row[c]; r < block.first_row[c + 1]; ++r) {
      for (std::uint32_t e = block.rows[r].begin; e < block.rows[r].end; ++e) {
        const auto within = [](std::int32_t x, std::int32_t from, std::int32_t to) {
          return from <= x && x <= to;
        };
        const std::int32_t index = index_of_name(rows.names[e]);
        const FixedPoint& p = rows.points[index];
        const bool in = within(p.x, lower.x, upper.x) && within(p.y, lower.y, upper.y) &&
                        within(p.z, lower.z, upper.z) && !within(p.name, lower.name, upper.name) &&
                        (p.name & skips_marked) >= 0;
        if (!in) continue;
        block.candidate[count++] = index;
      }
    }
  }
  block.first_candidate[block.clusters] = static_cast<std::uint32_t>(count);
}

using Vector = std::array<float, 3>;
Vector difference(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
float dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Half spaces n x + c >= 0 of a tet, and their error bound.
struct Planes {
  std::array<Vector, 4> normal;
  std::array<float, 4> offset;
  float bound;
};

/// \param reach  by how much planes are moved outwards, for a unit 1-norm of the normal
Planes planes_of(const std::array<Vector, 4>& corner, float reach, float bound) {
  const auto& [a, b, c, d] = corner;
  const Vector da = difference(a, d);
  const Vector db = difference(b, d);
  const Vector dc = difference(c, d);
  const Vector ab = difference(b, a);
  const Vector ac = difference(c, a);
  Planes planes{{cross(dc, db), cross(da, dc), cross(db, da), cross(ab, ac)}, {}, bound};
  const float volume = dot(planes.normal[0], da);
  if (!(std::abs(volume) > bound)) planes.bound = std::numeric_limits<float>::infinity();
  for (std::size_t face = 0; face < 4; ++face) {
    Vector& n = planes.normal[face];
    if (volume < 0.0F) n = {-n[0], -n[1], -n[2]};
    const float size = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
    planes.offset[face] = -dot(n, face < 3 ? d : a) + reach * size;
  }
  return planes;
}

Vector from_corner(const ClusterBox& box, std::int32_t x, std::int32_t y, std::int32_t z) {
  return {static_cast<float>(x - box.lower.x), static_cast<float>(y - box.lower.y),
          static_cast<float>(z - box.lower.z)};
}

std::array<Vector, 4> corners_of(const ClusterBlock& block, std::size_t c, std::size_t tet) {
  std::array<Vector, 4> corner;
  for (std::size_t k = 0; k < 4; ++k) {
    const FixedPoint& p = block.corners[c][block.cluster[c]->corners[k][tet]];
    corner[k] = from_corner(block.box[c], p.x, p.y, p.z);
  }
  return corner;
}

void test_tet(const FixedPoint* points, const ClusterBlock& block, std::size_t c, std::size_t tet,
              const Planes& planes, std::uint32_t* tets) {
  const ClusterBox& box = block.box[c];
  for (std::size_t i = block.first_candidate[c]; i < block.first_candidate[c + 1]; ++i) {
    const FixedPoint& point = points[block.candidates[i]];
    const Vector p = from_corner(box, point.x, point.y, point.z);
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t face = 0; face < 4; ++face)
      least = std::min(least, dot(planes.normal[face], p) + planes.offset[face]);
    const std::uint32_t may = least >= -planes.bound ? 1 : 0;
    const std::uint32_t surely = least > planes.bound ? 1 : 0;
    tets[i] |= (may | surely << 16) << tet;
  }
}

/// The index of a point in the list of a cluster; if it is not there, the number of points in the list.
std::size_t place_of(const ClusterBlock& block, std::size_t c, const FixedPoint& point) {
  std::size_t i = 0;
  while (i < block.cluster[c]->points && block.corners[c][i].name != point.name) ++i;
  return i;
}

/// Lists the candidates of a cluster that may be in a tet. Its own points come last, in the order of its
/// list.
void list_hits(const FixedPoint* points, std::size_t c, const std::uint32_t* tets, ClusterBlock& block) {
  const Cluster& cluster = *block.cluster[c];
  const auto number = static_cast<std::uint32_t>(c);
  std::array<ClusterBlock::Hit, Cluster::most_points> own{};
  for (std::size_t i = block.first_candidate[c]; i < block.first_candidate[c + 1]; ++i) {
    const std::int32_t candidate = block.candidates[i];
    const std::size_t place =
        includes_own(block.box[c]) ? place_of(block, c, points[candidate]) : cluster.points;
    if (place < cluster.points) {
      const std::uint32_t corner_of = block.at_point[static_cast<std::size_t>(cluster.first_point) + place];
      own[place] = {candidate, number, tets[i] & ~(corner_of * 0x10001U)};
    } else if (tets[i] != 0) {
      block.hit[block.hits++] = {candidate, number, tets[i]};
    }
  }
  for (const ClusterBlock::Hit& hit : own)
    if (hit.primitives != 0) block.hit[block.hits++] = hit;
}

/// \tparam BoundOf  function from the extent of a cluster to its error bound
template <class BoundOf>
void test_block(const FixedPoint* points, float reach, BoundOf&& bound_of, ClusterBlock& block) {
  std::array<std::uint32_t, ClusterBlock::most_points> tets{};
  block.hits = 0;
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const float bound = bound_of(extent_of(block.box[c]));
    for (std::size_t t = 0; t < block.cluster[c]->size; ++t)
      test_tet(points, block, c, t, planes_of(corners_of(block, c, t), reach, bound), tets.data());
    list_hits(points, c, tets.data(), block);
  }
}

void test(const FixedPoint* points, ClusterBlock& block) {
  test_block(points, 0.0F, volume_bound, block);
}
void near(const FixedPoint* points, std::int32_t margin, ClusterBlock& block) {
  test_block(
      points, reach_of(margin), [margin](float extent) { return near_bound(extent, margin); }, block);
}

bool upright(const ClusterBlock& block) {
  bool all = true;
  for (std::size_t c = 0; c < block.clusters; ++c) {
    for (std::size_t t = 0; t < block.cluster[c]->size; ++t) {
      const auto [a, b, cc, d] = corners_of(block, c, t);
      const float volume = dot(cross(difference(cc, d), difference(b, d)), difference(a, d));
      all = all && volume > volume_bound(extent_of(block.box[c]));
    }
  }
  return all;
}

}  // namespace

ClusterKernels cluster_kernels() {
  return {load, filter, test, near, gather, upright};
}

}  // namespace palpate::simd::scalar
