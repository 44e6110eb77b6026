#include "simd/crossing_query.hpp"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/crossing_query.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our headers are compiled for each target, so they come after that.
#include "simd/cluster_lanes-inl.hpp"
#include "simd/row_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE Int load(const BoxGroup::Row& row, std::size_t lane) {
  return hn::Load(ints, row.data() + lane);
}
HWY_INLINE Int min3(Int a, Int b, Int c) {
  return hn::Min(a, hn::Min(b, c));
}
HWY_INLINE Int max3(Int a, Int b, Int c) {
  return hn::Max(a, hn::Max(b, c));
}

/// Writes one child's ends along an axis into its parent.
HWY_INLINE void put(Int lowest, Int highest, std::size_t k, std::size_t place, BoxGroup& parent) {
  parent.lower[k][place] = hn::GetLane(hn::MinOfLanes(ints, lowest));
  parent.upper[k][place] = hn::GetLane(hn::MaxOfLanes(ints, highest));
}
HWY_INLINE void clear_from(std::size_t place, BoxGroup& parent) {
  for (; place < BoxGroup::most; ++place) {
    for (std::size_t k = 0; k < 3; ++k) {
      parent.lower[k][place] = std::numeric_limits<std::int32_t>::max();
      parent.upper[k][place] = -1;
    }
  }
}

void fit_leaves(const FixedPoint* points, std::span<const LeafTriangles> triangles, BoxGroup* leaves,
                std::int32_t* extents, BoxGroup& parent) {
  const Int most = hn::Set(ints, std::numeric_limits<std::int32_t>::max());
  const Int none = hn::Set(ints, -1);
  for (std::size_t leaf = 0; leaf < triangles.size(); ++leaf) {
    Int extent = hn::Zero(ints);
    Int lowest[3] = {most, most, most};
    Int highest[3] = {none, none, none};
    for (std::size_t lane = 0; lane < BoxGroup::most; lane += lanes()) {
      const auto corner = [&](std::size_t i) HWY_ATTR {
        const std::int32_t* const places = triangles[leaf].corner[i].data() + lane;
        return load_rows(ints, [&](std::size_t at) HWY_ATTR { return &points->x + places[at]; });
      };
      const auto unused = hn::Lt(load(triangles[leaf].triangle, lane), hn::Zero(ints));
      const RowColumns<Ints> a = corner(0);
      const RowColumns<Ints> b = corner(1);
      const RowColumns<Ints> c = corner(2);
      const auto put_along = [&](Int x, Int y, Int z, std::size_t k) HWY_ATTR {
        const Int lower = hn::IfThenElse(unused, most, min3(x, y, z));
        const Int upper = hn::IfThenElse(unused, none, max3(x, y, z));
        hn::Store(lower, ints, leaves[leaf].lower[k].data() + lane);
        hn::Store(upper, ints, leaves[leaf].upper[k].data() + lane);
        lowest[k] = hn::Min(lowest[k], lower);
        highest[k] = hn::Max(highest[k], upper);
        extent = hn::Max(extent, hn::Sub(upper, lower));
      };
      put_along(a.x, b.x, c.x, 0);
      put_along(a.y, b.y, c.y, 1);
      put_along(a.z, b.z, c.z, 2);
    }
    for (std::size_t k = 0; k < 3; ++k) put(lowest[k], highest[k], k, leaf, parent);
    extents[leaf] = hn::GetLane(hn::MaxOfLanes(ints, extent));
  }
  clear_from(triangles.size(), parent);
}

void fit_parent(std::span<const BoxGroup> children, BoxGroup& parent) {
  for (std::size_t child = 0; child < children.size(); ++child) {
    for (std::size_t k = 0; k < 3; ++k) {
      Int lowest = load(children[child].lower[k], 0);
      Int highest = load(children[child].upper[k], 0);
      for (std::size_t lane = lanes(); lane < BoxGroup::most; lane += lanes()) {
        lowest = hn::Min(lowest, load(children[child].lower[k], lane));
        highest = hn::Max(highest, load(children[child].upper[k], lane));
      }
      put(lowest, highest, k, child, parent);
    }
  }
  clear_from(children.size(), parent);
}

std::size_t list_children(const BoxGroup* level, const std::int32_t* first_child,
                          std::span<const std::int32_t> nodes, const FixedBox& box, std::int32_t* children) {
  const Int below[3] = {hn::Set(ints, box.lower.x - 1), hn::Set(ints, box.lower.y - 1),
                        hn::Set(ints, box.lower.z - 1)};
  const Int upper[3] = {hn::Set(ints, box.upper.x), hn::Set(ints, box.upper.y), hn::Set(ints, box.upper.z)};
  const Int first_places = hn::Iota(ints, 0);
  std::size_t count = 0;
  for (const std::int32_t node : nodes) {
    const BoxGroup& group = level[node];
    Int number = hn::Add(first_places, hn::Set(ints, first_child[node]));
    for (std::size_t lane = 0; lane < BoxGroup::most; lane += lanes()) {
      // Negative where an interval of the group begins beyond the box, or does not end before it.
      const auto beyond = [&](std::size_t k)
                              HWY_ATTR { return hn::Sub(upper[k], load(group.lower[k], lane)); };
      const auto reaches = [&](std::size_t k)
                               HWY_ATTR { return hn::Sub(below[k], load(group.upper[k], lane)); };
      const Int out = hn::Or(hn::Or(beyond(0), beyond(1)), beyond(2));
      const Int in = hn::And(hn::And(reaches(0), reaches(1)), reaches(2));
      count += store_kept(number, hn::Lt(hn::AndNot(out, in), hn::Zero(ints)), children + count);
      number = hn::Add(number, hn::Set(ints, static_cast<std::int32_t>(lanes())));
    }
  }
  return count;
}

/// Calls use(e, q) for the edges of a star; q is the other end of edge e.
template <class Use>
HWY_INLINE void for_each_end(const FixedPoint* points, std::span<const BorderEdge> edges, EdgeStar& star,
                             const Use& use) {
  const Index contact = edges.front().contact;
  const std::size_t most = std::min(edges.size(), EdgeStar::most);
  std::size_t size = 0;
  do {
    const Index other = edges[size].free_point;
    star.other[size] = other;
    use(size, points[other]);
    ++size;
  } while (size < most && edges[size].contact == contact);
  star.size = size;
}

#if HWY_TARGET == HWY_SCALAR
void gather_star(const FixedPoint* points, std::span<const BorderEdge> edges, EdgeStar& star) {
  const FixedPoint& p = star.point;
  star.box = {p, p};
  for_each_end(points, edges, star, [&](std::size_t e, const FixedPoint& q) {
    FixedPoint& l = star.box.lower;
    FixedPoint& u = star.box.upper;
    l = {std::min(l.x, q.x), std::min(l.y, q.y), std::min(l.z, q.z), 0};
    u = {std::max(u.x, q.x), std::max(u.y, q.y), std::max(u.z, q.z), 0};
    star.along[e] = {static_cast<float>(q.x - p.x), static_cast<float>(q.y - p.y),
                     static_cast<float>(q.z - p.z), 0.0F};
  });
  const auto [l, u] = star.box;
  star.reach = std::max({p.x - l.x, p.y - l.y, p.z - l.z, u.x - p.x, u.y - p.y, u.z - p.z});
}
#else
void gather_star(const FixedPoint* points, std::span<const BorderEdge> edges, EdgeStar& star) {
  const hn::FixedTag<std::int32_t, 4> d;
  const hn::RebindToFloat<decltype(d)> in_float;
  const auto point = hn::Load(d, &star.point.x);
  auto lower = point;
  auto upper = point;
  for_each_end(points, edges, star, [&](std::size_t e, const FixedPoint& end) HWY_ATTR {
    const auto other = hn::Load(d, &end.x);
    lower = hn::Min(lower, other);
    upper = hn::Max(upper, other);
    hn::Store(hn::ConvertTo(in_float, hn::Sub(other, point)), in_float, star.along[e].data());
  });
  hn::Store(lower, d, &star.box.lower.x);
  hn::Store(upper, d, &star.box.upper.x);
  FixedPoint away;
  hn::Store(hn::Max(hn::Sub(point, lower), hn::Sub(upper, point)), d, &away.x);
  star.reach = std::max(away.x, std::max(away.y, away.z));
}
#endif

/// Triangles as a point sees them: the normals of the planes through the point and each side, turned inwards,
/// and six times the volume of the point and the triangle.
struct Cones {
  Vector normal[3];
  Float volume;

  HWY_INLINE Cones(const FixedPoint* points, const LeafTriangles* triangles, const FixedPoint& from,
                   const std::int32_t* entries) {
    const Int from_x = hn::Set(ints, from.x);
    const Int from_y = hn::Set(ints, from.y);
    const Int from_z = hn::Set(ints, from.z);
    Vector corner[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t* const places = triangles->corner[i].data();
      const auto [x, y, z] =
          load_rows(ints, [&](std::size_t lane) HWY_ATTR { return &points->x + places[entries[lane]]; });
      corner[i] = {hn::ConvertTo(floats, hn::Sub(x, from_x)), hn::ConvertTo(floats, hn::Sub(y, from_y)),
                   hn::ConvertTo(floats, hn::Sub(z, from_z))};
    }
    for (std::size_t i = 0; i < 3; ++i) normal[i] = cross(corner[i], corner[(i + 1) % 3]);
    volume = dot(normal[1], corner[0]);
    const Float sign = hn::And(volume, hn::Set(floats, -0.0F));
    volume = hn::Abs(volume);
    for (Vector& n : normal) n = {hn::Xor(n.x, sign), hn::Xor(n.y, sign), hn::Xor(n.z, sign)};
  }
  /// Keeps the first `count` triangles: no edge gets beyond the others.
  HWY_INLINE void keep(std::size_t count) {
    const Float infinity = hn::Set(floats, std::numeric_limits<float>::infinity());
    volume = hn::IfThenElse(hn::FirstN(floats, count), volume, infinity);
  }
};

/// The least of the volumes that are positive where an edge meets a triangle: those of the edge with each
/// side, and the one beyond the triangle. `most`: the largest one.
HWY_INLINE Float least_volume(const Cones& cones, const std::array<float, 4>& edge, Float* most) {
  const Vector along{hn::Set(floats, edge[0]), hn::Set(floats, edge[1]), hn::Set(floats, edge[2])};
  const Float a = dot(cones.normal[0], along);
  const Float b = dot(cones.normal[1], along);
  const Float c = dot(cones.normal[2], along);
  const Float beyond = hn::Sub(hn::Add(hn::Add(a, b), c), cones.volume);
  if (most != nullptr) *most = hn::Max(hn::Max(a, b), hn::Max(c, beyond));
  return hn::Min(hn::Min(a, b), hn::Min(c, beyond));
}

/// Tests all edges against the triangles of one vector.
/// \tparam all_sure  the point is certainly on one side of each triangle
template <bool all_sure>
HWY_INLINE std::size_t test_edges(const Cones& cones, const EdgeStar& star, std::size_t first, Float bound,
                                  std::size_t count, StarHits& hits) {
  const auto unknown = hn::Le(cones.volume, bound);
  const Float lowest = hn::Neg(bound);
  auto place = static_cast<std::uint32_t>(first * EdgeStar::most);
  const std::uint32_t end = place + static_cast<std::uint32_t>(star.size);
  for (const std::array<float, 4>* edge = star.along.data(); place < end; ++edge, ++place) {
    Float most;
    Float least = least_volume(cones, *edge, all_sure ? nullptr : &most);
    auto may = hn::Gt(least, lowest);
    if constexpr (!all_sure) {
      // If the point is on the other side, all volumes have the other sign.
      may = hn::Or(may, hn::And(unknown, hn::Lt(most, bound)));
      least = hn::IfThenZeroElse(unknown, least);
    }
    const std::uint32_t bits = bits_of(floats, may);
    hn::Store(least, floats, hits.least.data() + count * lanes());
    hits.hit[count] = {place, bits};
    count += bits != 0 ? 1 : 0;
  }
  return count;
}

void test_star(const FixedPoint* points, const LeafTriangles* triangles, std::span<std::int32_t> entries,
               const EdgeStar& star, float reach, StarHits& hits) {
  hits.bound = crossing_bound(reach);
  hits.lanes = lanes();
  const Float bound = hn::Set(floats, hits.bound);
  hn::StoreU(hn::Set(ints, entries.back()), ints, entries.data() + entries.size());
  std::size_t count = 0;
  for (std::size_t first = 0; first < entries.size(); first += lanes()) {
    Cones cones(points, triangles, star.point, entries.data() + first);
    if (entries.size() - first < lanes()) cones.keep(entries.size() - first);
    if (hn::AllTrue(floats, hn::Gt(cones.volume, bound))) {
      count = test_edges<true>(cones, star, first, bound, count, hits);
    } else {
      count = test_edges<false>(cones, star, first, bound, count, hits);
    }
  }
  hits.size = count;
}

CrossingKernels make_crossing_kernels() {
  return {&fit_leaves, &fit_parent, &list_children, &gather_star, &test_star};
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(make_crossing_kernels);

CrossingKernels crossing_kernels() {
  return HWY_DYNAMIC_DISPATCH(make_crossing_kernels)();
}

float crossing_bound(float reach) {
  constexpr float u = 0x1p-24F;
  constexpr float slack = 1.001F;  // allows for the rounding of the bound itself
  const float square = reach * reach;
  const float vector = 1.01F + u * reach;
  const float normal = 4.0F * reach * vector + 2.0F * vector * vector + 4.1F * u * square;
  const float volume = 3.0F * normal * (reach + vector) + (6.1F * vector + 16.1F * u * reach) * square;
  return slack * (4.0F * volume + 55.0F * u * reach * square);
}

}  // namespace palpate::simd
#endif
