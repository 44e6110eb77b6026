// Aggregates of nodes, from which coarse levels are made.
#include <algorithm>
#include <cmath>

#include "fem/matrix.hpp"
#include "fem/transfer.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

std::span<const std::uint32_t> neighbors(const NodeGraph& graph, std::size_t node) {
  return graph.columns.subspan(graph.begin[node], graph.begin[node + 1] - graph.begin[node]);
}

/// All nodes, breadth first from the first node of each connected part.
std::vector<std::uint32_t> breadth_first(const NodeGraph& graph) {
  const std::size_t count = graph.begin.size() - 1;
  std::vector<std::uint32_t> order;
  order.reserve(count);
  std::vector<std::uint8_t> seen(count, 0);
  const auto visit = [&](std::uint32_t node) {
    if (seen[node] == 0) order.push_back(node);
    seen[node] = 1;
  };
  for (std::size_t start = 0; start < count; ++start) {
    std::size_t done = order.size();
    visit(static_cast<std::uint32_t>(start));
    for (; done < order.size(); ++done) {
      for (const std::uint32_t other : neighbors(graph, order[done])) visit(other);
    }
  }
  return order;
}

}  // namespace

std::vector<Index> aggregate(const NodeGraph& graph) {
  const std::size_t count = graph.begin.size() - 1;
  std::vector<Index> of(count, -1);
  const auto near = [&](std::size_t i) { return neighbors(graph, i); };
  Index next = 0;
  for (const std::uint32_t i : breadth_first(graph)) {
    if (of[i] >= 0 || std::ranges::any_of(near(i), [&](auto j) { return of[j] >= 0; })) continue;
    of[i] = next;
    for (const std::uint32_t j : near(i)) of[j] = next;
    ++next;
  }
  // Join the aggregate that most of the node's neighbours joined in the first pass.
  std::vector<Index> joined = of;
  std::vector<Index> around;
  for (std::size_t i = 0; i < count; ++i) {
    if (of[i] >= 0) continue;
    around.clear();
    for (const std::uint32_t j : near(i)) {
      if (of[j] >= 0) around.push_back(of[j]);
    }
    std::ranges::sort(around);
    std::ptrdiff_t most = 0;
    for (auto first = around.begin(); first != around.end();) {
      const auto last = std::upper_bound(first, around.end(), *first);
      if (last - first > most) joined[i] = *first;
      most = std::max(most, last - first);
      first = last;
    }
  }
  return joined;
}

std::vector<Node> nodes_of(std::span<const Index> aggregate_of_node, std::span<const Node> nodes) {
  const Index count = aggregate_of_node.empty() ? 0 : std::ranges::max(aggregate_of_node) + 1;
  std::vector<Node> aggregates(static_cast<std::size_t>(count));
  std::vector<double> members(aggregates.size(), 0.0);
  std::vector<double> own(aggregates.size(), 0.0);  // squared radii of the members
  std::vector<Matrix3> squares(aggregates.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    Node& whole = at(aggregates, aggregate_of_node[i]);
    whole.middle += nodes[i].middle;
    whole.body = nodes[i].body;
    at(members, aggregate_of_node[i]) += 1.0;
  }
  for (std::size_t a = 0; a < aggregates.size(); ++a)
    aggregates[a].middle = (1.0 / members[a]) * aggregates[a].middle;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Vec3 d = nodes[i].middle - at(aggregates, aggregate_of_node[i]).middle;
    add_outer(at(squares, aggregate_of_node[i]), 1.0, d, d);
    at(own, aggregate_of_node[i]) += nodes[i].radius * nodes[i].radius;
  }
  for (std::size_t a = 0; a < aggregates.size(); ++a) {
    const Matrix3& s = squares[a];
    const double size = s(0, 0) + s(1, 1) + s(2, 2);
    const Matrix3 minors = cofactors(s);
    const double flat = minors(0, 0) + minors(1, 1) + minors(2, 2);
    constexpr double line = 1e-4;
    const bool rotates = own[a] > 0.0 || flat > line * line * size * size;
    aggregates[a].radius = rotates ? std::sqrt((size + own[a]) / members[a]) : 0.0;
  }
  return aggregates;
}

}  // namespace palpate::fem
