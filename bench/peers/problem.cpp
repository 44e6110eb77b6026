#include "peers/problem.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "contact/layers.hpp"
#include "geometry/predicates.hpp"

namespace palpate::bench {

Problem::Problem(const Bodies& bodies, const PairFilter& filter, Task task, Grouping grouping)
    : bodies_(&bodies), filter_(filter), task_(task) {
  const bool points = task == Task::points_in_tets;
  const auto add = [&](Range own_points, Range second) {
    std::vector<Index>& list = first_.emplace_back();
    if (points) {
      list.resize(static_cast<std::size_t>(own_points.size()));
      std::iota(list.begin(), list.end(), own_points.begin);
    }
    second_.push_back(second);
  };
  if (grouping == Grouping::one) {
    const std::size_t count = points ? bodies.tets().size() : bodies.triangles().size();
    add({0, static_cast<Index>(bodies.points_rest().size())}, {0, static_cast<Index>(count)});
  } else {
    for (const Body& body : bodies.bodies()) add(body.points, points ? body.tets : body.triangles);
  }
}

void Problem::take(const Frame& frame) {
  frame_ = frame;
  if (task_ == Task::points_in_tets) return;
  for (std::vector<Index>& list : first_) list.clear();
  for (std::size_t e = 0; e < frame.edges.size(); ++e)
    first_[groups() == 1 ? 0 : static_cast<std::size_t>(frame.edges[e].body)].push_back(
        static_cast<Index>(e));
}

bool Problem::may_meet(std::size_t first, std::size_t second) const {
  if (groups() == 1) return !first_[0].empty();
  if (task_ == Task::edges_on_triangles) return first == second && !first_[first].empty();
  return first != second || filter_.self_collision[first] != 0;
}

Box Problem::first_box(Index first) const {
  const std::span<const Vec3> x = frame_.positions;
  if (task_ == Task::points_in_tets) return {at(x, first), at(x, first)};
  const AimedEdge& edge = at(frame_.edges, first);
  return box_of(x, std::array{edge.in, edge.out});
}

Box Problem::second_box(Index second) const {
  return task_ == Task::points_in_tets ? box_of(frame_.positions, at(bodies_->tets(), second))
                                       : box_of(frame_.positions, at(bodies_->triangles(), second));
}

bool Problem::meets(Index first, Index second) const {
  return task_ == Task::points_in_tets
             ? point_meets(first, at(bodies_->tets(), second), second)
             : edge_meets(at(frame_.edges, first), at(bodies_->triangles(), second));
}

bool Problem::point_meets(Index point, const Tet& tet, Index tet_index) const {
  const std::span<const Vec3> x = frame_.positions;
  const Index own = at(bodies_->body_of_point(), point);
  const Index body = bodies_->body_of(tet);
  if (!filter_(own, body, point, tet)) return false;
  const Vec3& p = at(x, point);
  if (!box_of(x, tet).contains(p) ||
      !point_in_tet(p, at(x, tet[0]), at(x, tet[1]), at(x, tet[2]), at(x, tet[3])))
    return false;
  return own != body || !is_fold(*bodies_, x, point, tet_index);
}

bool Problem::edge_meets(const AimedEdge& edge, const Triangle& triangle) const {
  const std::span<const Vec3> x = frame_.positions;
  if (bodies_->body_of(triangle) != edge.body) return false;
  const std::array ends{edge.in, edge.out};
  const auto own = [&](Index corner) { return corner == edge.in || corner == edge.out; };
  if (std::any_of(triangle.begin(), triangle.end(), own)) return false;
  return box_of(x, triangle).overlaps(box_of(x, ends)) &&
         segment_meets_triangle(at(x, edge.in), at(x, edge.out), at(x, triangle[0]), at(x, triangle[1]),
                                at(x, triangle[2]));
}

}  // namespace palpate::bench
