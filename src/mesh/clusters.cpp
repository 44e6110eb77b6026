#include "mesh/clusters.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "geometry/axis.hpp"
#include "geometry/box.hpp"
#include "geometry/disjoint_sets.hpp"
#include "geometry/vector.hpp"

namespace palpate {
namespace {

double longest_side(const Box& box) {
  const Vec3 d = box.upper - box.lower;
  return std::max({d.x, d.y, d.z});
}

/// \tparam Primitive  Tet or Triangle
template <class Primitive>
class Cutter {
 public:
  Cutter(const Bodies& bodies, std::span<const Primitive> primitives, Clusters& result)
      : bodies_(bodies), primitives_(primitives), result_(result) {
    placed_.reserve(primitives.size());
    for (std::size_t t = 0; t < primitives.size(); ++t) {
      const Box box = box_of(bodies.points_rest(), primitives[t]);
      const Vec3 middle = 0.5 * (box.lower + box.upper);
      placed_.push_back({{middle.x, middle.y, middle.z}, static_cast<Index>(t), 0});
    }
  }

  /// Connected parts that fill a cluster are cut separately, so that no cluster spans a gap. All smaller
  /// parts are cut as one.
  void cut_all(const Range& range, const Range& points) {
    const auto begin = static_cast<std::size_t>(range.begin);
    const auto end = static_cast<std::size_t>(range.end);
    find_parts(begin, end, points);
    std::stable_sort(at_place(begin), at_place(end),
                     [](const Placed& a, const Placed& b) { return a.part < b.part; });
    for (std::size_t first = begin; first < end;) {
      std::size_t last = first;
      while (last < end && placed_[last].part == placed_[first].part) ++last;
      cut(first, last);
      first = last;
    }
  }

 private:
  struct Placed {
    std::array<double, 3> middle;
    Index primitive;
    Index part;  ///< number of the connected part
  };

  [[nodiscard]] auto at_place(std::size_t i) { return placed_.begin() + static_cast<std::ptrdiff_t>(i); }

  /// Sets the part of the primitives of a body: the first point of the connected part, or the largest number
  /// for all small parts.
  void find_parts(std::size_t begin, std::size_t end, const Range& points) {
    DisjointSets parts(static_cast<std::size_t>(points.size()));
    for (std::size_t i = begin; i < end; ++i) {
      for (const Index corner : primitive(i))
        parts.join(corner - points.begin, primitive(i)[0] - points.begin);
    }
    std::vector<std::size_t> size(static_cast<std::size_t>(points.size()), 0);
    for (std::size_t i = begin; i < end; ++i) {
      placed_[i].part = points.begin + parts.find(primitive(i)[0] - points.begin);
      ++at(size, placed_[i].part - points.begin);
    }
    for (std::size_t i = begin; i < end; ++i) {
      if (at(size, placed_[i].part - points.begin) < Cluster::most_primitives) placed_[i].part = points.end;
    }
  }

  void cut(std::size_t begin, std::size_t end) {
    const std::size_t size = end - begin;
    if (size <= Cluster::most_primitives && (size == 1 || lies_together(begin, end))) return add(begin, end);
    constexpr std::size_t whole = Cluster::most_primitives;
    const std::size_t left = size > whole ? whole * ((size + 2 * whole - 1) / (2 * whole)) : size / 2;
    const Box box = box_of_primitives(begin, end);
    const std::size_t axis = longest_axis(box.upper - box.lower);
    std::nth_element(at_place(begin), at_place(begin + left), at_place(end),
                     [axis](const Placed& a, const Placed& b) {
                       return a.middle[axis] != b.middle[axis] ? a.middle[axis] < b.middle[axis]
                                                               : a.primitive < b.primitive;
                     });
    cut(begin, begin + left);
    cut(begin + left, end);
  }

  [[nodiscard]] const Primitive& primitive(std::size_t place) const {
    return at(primitives_, placed_[place].primitive);
  }

  [[nodiscard]] Box box_of_primitives(std::size_t begin, std::size_t end) const {
    Box box;
    for (std::size_t i = begin; i < end; ++i) box.extend(box_of(bodies_.points_rest(), primitive(i)));
    return box;
  }

  bool lies_together(std::size_t begin, std::size_t end) {
    list_points(begin, end);
    Box box;
    double largest = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Box box_of_one = box_of(bodies_.points_rest(), primitive(i));
      box.extend(box_of_one);
      largest = std::max(largest, longest_side(box_of_one));
    }
    return points_.size() <= Cluster::most_points && longest_side(box) <= most_cluster_extent * largest;
  }

  /// Lists the distinct points of the primitives, ascending.
  void list_points(std::size_t begin, std::size_t end) {
    points_.clear();
    for (std::size_t i = begin; i < end; ++i)
      points_.insert(points_.end(), primitive(i).begin(), primitive(i).end());
    std::sort(points_.begin(), points_.end());
    points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
  }

  void add(std::size_t begin, std::size_t end) {
    list_points(begin, end);
    const auto first = placed_.begin() + static_cast<std::ptrdiff_t>(begin);
    std::sort(first, placed_.begin() + static_cast<std::ptrdiff_t>(end),
              [](const Placed& a, const Placed& b) { return a.primitive < b.primitive; });
    Cluster cluster{};
    cluster.first = static_cast<Index>(result_.primitives.size());
    cluster.first_point = static_cast<Index>(result_.points.size());
    cluster.body = bodies_.body_of(primitive(begin));
    cluster.size = static_cast<std::uint8_t>(end - begin);
    cluster.points = static_cast<std::uint8_t>(points_.size());
    for (std::size_t lane = 0; lane < Cluster::most_primitives; ++lane) {
      const Primitive& corners = primitive(lane < end - begin ? begin + lane : begin);
      for (std::size_t c = 0; c < 4; ++c) {
        const auto place =
            std::lower_bound(points_.begin(), points_.end(), corners[std::min(c, corners.size() - 1)]) -
            points_.begin();
        cluster.corners[c][lane] = static_cast<std::uint8_t>(place);
      }
    }
    for (std::size_t i = begin; i < end; ++i) result_.primitives.push_back(placed_[i].primitive);
    std::vector<std::uint16_t>& at_point = result_.at_point;
    at_point.resize(at_point.size() + points_.size());
    for (const auto& corners : cluster.corners) {
      for (std::size_t lane = 0; lane < end - begin; ++lane)
        at_point[result_.points.size() + corners[lane]] |= static_cast<std::uint16_t>(1U << lane);
    }
    result_.points.insert(result_.points.end(), points_.begin(), points_.end());
    result_.clusters.push_back(cluster);
  }

  const Bodies& bodies_;
  std::span<const Primitive> primitives_;
  Clusters& result_;
  std::vector<Placed> placed_;
  std::vector<Index> points_;
};

}  // namespace

Clusters make_tet_clusters(const Bodies& bodies) {
  Clusters result;
  Cutter<Tet> cutter(bodies, bodies.tets(), result);
  for (const Body& body : bodies.bodies()) cutter.cut_all(body.tets, body.points);
  return result;
}

Clusters make_triangle_clusters(const Bodies& bodies) {
  Clusters result;
  Cutter<Triangle> cutter(bodies, bodies.triangles(), result);
  for (const Body& body : bodies.bodies()) cutter.cut_all(body.triangles, body.points);
  return result;
}

}  // namespace palpate
