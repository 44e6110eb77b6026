#include "mesh/clusters.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"

namespace palpate {
namespace {

double longest_side(const Box& box) {
  const Vec3 d = box.upper - box.lower;
  return std::max({d.x, d.y, d.z});
}

class Cutter {
 public:
  Cutter(const Bodies& bodies, TetClusters& result) : bodies_(bodies), result_(result) {
    tets_.reserve(bodies.tets().size());
    for (std::size_t t = 0; t < bodies.tets().size(); ++t) {
      const Box box = box_of(bodies.points_rest(), bodies.tets()[t]);
      const Vec3 middle = 0.5 * (box.lower + box.upper);
      tets_.push_back({{middle.x, middle.y, middle.z}, static_cast<Index>(t)});
    }
  }

  void cut(std::size_t begin, std::size_t end) {
    const std::size_t size = end - begin;
    if (size <= TetCluster::most_tets && (size == 1 || lies_together(begin, end))) return add(begin, end);
    constexpr std::size_t whole = TetCluster::most_tets;
    const std::size_t left = size > whole ? whole * ((size + 2 * whole - 1) / (2 * whole)) : size / 2;
    const std::size_t axis = longest_axis(begin, end);
    const auto at_place = [&](std::size_t i) { return tets_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(
        at_place(begin), at_place(begin + left), at_place(end), [axis](const Placed& a, const Placed& b) {
          return a.middle[axis] != b.middle[axis] ? a.middle[axis] < b.middle[axis] : a.tet < b.tet;
        });
    cut(begin, begin + left);
    cut(begin + left, end);
  }

 private:
  struct Placed {
    std::array<double, 3> middle;
    Index tet;
  };

  [[nodiscard]] const Tet& tet(std::size_t place) const { return at(bodies_.tets(), tets_[place].tet); }

  [[nodiscard]] std::size_t longest_axis(std::size_t begin, std::size_t end) const {
    Box box;
    for (std::size_t i = begin; i < end; ++i) box.extend(box_of(bodies_.points_rest(), tet(i)));
    const Vec3 d = box.upper - box.lower;
    return d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
  }

  bool lies_together(std::size_t begin, std::size_t end) {
    list_points(begin, end);
    Box box;
    double largest_tet = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Box of_tet = box_of(bodies_.points_rest(), tet(i));
      box.extend(of_tet);
      largest_tet = std::max(largest_tet, longest_side(of_tet));
    }
    return points_.size() <= TetCluster::most_points &&
           longest_side(box) <= most_cluster_extent * largest_tet;
  }

  /// Different points of the tets, ascending.
  void list_points(std::size_t begin, std::size_t end) {
    points_.clear();
    for (std::size_t i = begin; i < end; ++i) points_.insert(points_.end(), tet(i).begin(), tet(i).end());
    std::sort(points_.begin(), points_.end());
    points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
  }

  void add(std::size_t begin, std::size_t end) {
    list_points(begin, end);
    const auto first = tets_.begin() + static_cast<std::ptrdiff_t>(begin);
    std::sort(first, tets_.begin() + static_cast<std::ptrdiff_t>(end),
              [](const Placed& a, const Placed& b) { return a.tet < b.tet; });
    TetCluster cluster{};
    cluster.first_tet = static_cast<Index>(result_.tets.size());
    cluster.first_point = static_cast<Index>(result_.points.size());
    cluster.body = bodies_.body_of(tet(begin));
    cluster.tets = static_cast<std::uint8_t>(end - begin);
    cluster.points = static_cast<std::uint8_t>(points_.size());
    for (std::size_t lane = 0; lane < TetCluster::most_tets; ++lane) {
      const Tet& corners = tet(lane < end - begin ? begin + lane : begin);
      for (std::size_t c = 0; c < 4; ++c) {
        const auto place = std::lower_bound(points_.begin(), points_.end(), corners[c]) - points_.begin();
        cluster.corners[c][lane] = static_cast<std::uint8_t>(place);
      }
    }
    for (std::size_t i = begin; i < end; ++i) result_.tets.push_back(tets_[i].tet);
    result_.points.insert(result_.points.end(), points_.begin(), points_.end());
    result_.clusters.push_back(cluster);
  }

  const Bodies& bodies_;
  TetClusters& result_;
  std::vector<Placed> tets_;
  std::vector<Index> points_;
};

}  // namespace

TetClusters make_clusters(const Bodies& bodies) {
  TetClusters result;
  Cutter cutter(bodies, result);
  for (const Body& body : bodies.bodies())
    cutter.cut(static_cast<std::size_t>(body.tets.begin), static_cast<std::size_t>(body.tets.end));
  return result;
}

}  // namespace palpate
