#include <algorithm>
#include <array>
#include <string>

#include <palpate/error.hpp>
#include <palpate/fibres.hpp>

#include "fem/harmonic_field.hpp"
#include "geometry/disjoint_sets.hpp"
#include "geometry/vector.hpp"

namespace palpate {
namespace {

constexpr const char* function = "fibres_between";
constexpr std::array<const char*, 2> end_names{"from", "to"};

/// (n_points) 1 at `from`, 2 at `to`, 0 elsewhere.
std::vector<std::uint8_t> marked_ends(Index n_points, std::span<const Index> from,
                                      std::span<const Index> to) {
  std::vector<std::uint8_t> ends(static_cast<std::size_t>(n_points), 0);
  for (std::uint8_t end = 0; end < 2; ++end) {
    const std::span<const Index> points = end == 0 ? from : to;
    if (points.empty()) throw Error(function, end_names[end], "no point", "one or more points");
    for (const Index point : points) {
      if (point < 0 || point >= n_points) {
        throw Error(function, end_names[end], "point " + std::to_string(point),
                    "0 to " + std::to_string(n_points - 1));
      }
      if (end == 1 && at(ends, point) == 1) {
        throw Error(function, end_names[end], "point " + std::to_string(point) + ", which is in 'from' too",
                    "ends without a common point");
      }
      at(ends, point) = static_cast<std::uint8_t>(end + 1);
    }
  }
  return ends;
}

/// Connected pieces of a mesh: (n_points) the lowest point of each piece.
std::vector<Index> pieces_of(const fem::ScalarTets& tets, std::size_t n_points) {
  DisjointSets pieces(n_points);
  for (std::size_t tet = 0; tet < tets.size(); ++tet) {
    for (const Index corner : tets.corners(tet)) pieces.join(corner, tets.corners(tet)[0]);
  }
  std::vector<Index> lowest(n_points);
  for (std::size_t point = 0; point < n_points; ++point)
    lowest[point] = pieces.find(static_cast<Index>(point));
  return lowest;
}

void check_pieces(const fem::ScalarTets& tets, std::span<const std::uint8_t> ends) {
  const std::vector<Index> pieces = pieces_of(tets, ends.size());
  std::vector<std::uint8_t> has(ends.size(), 0);
  for (std::size_t point = 0; point < ends.size(); ++point) at(has, pieces[point]) |= ends[point];
  for (std::size_t tet = 0; tet < tets.size(); ++tet) {
    const std::uint8_t there = at(has, at(pieces, tets.corners(tet)[0]));
    if (there == 3) continue;
    throw Error(function, end_names[there == 1 ? 1 : 0],
                "no point of this end in the connected piece of the body with tet " + std::to_string(tet),
                "points of both ends in each piece");
  }
}

/// Sets missing directions to the mean of those of tets with a common point, repeatedly.
void fill_gaps(const Bodies& bodies, Range tets, std::vector<Vec3>& directions) {
  std::vector<Index> open;
  for (Index tet = 0; tet < tets.size(); ++tet)
    if (at(directions, tet) == Vec3{}) open.push_back(tet);
  while (!open.empty()) {
    std::vector<Vec3> found;
    for (const Index tet : open) {
      Vec3 sum{};
      for (const Index corner : at(bodies.tets(), tets.begin + tet))
        for (const Index other : bodies.point_tets()[corner]) sum += at(directions, other - tets.begin);
      found.push_back(normalized(sum));
    }
    for (std::size_t i = 0; i < open.size(); ++i) at(directions, open[i]) = found[i];
    const std::size_t before = open.size();
    std::erase_if(open, [&](Index tet) { return at(directions, tet) != Vec3{}; });
    if (open.size() == before)
      return;  // directions cancel: the remaining tets keep the direction of their material
  }
}

}  // namespace

std::vector<Vec3> fibres_between(const Bodies& bodies, Index body, std::span<const Index> from,
                                 std::span<const Index> to) {
  if (body < 0 || body >= bodies.body_count())
    throw Error(function, "body", std::to_string(body), "0 to " + std::to_string(bodies.body_count() - 1));
  const Body& own = at(bodies.bodies(), body);
  const auto part = [](auto all, Range range) {
    return all.subspan(static_cast<std::size_t>(range.begin), static_cast<std::size_t>(range.size()));
  };
  const std::vector<std::uint8_t> ends = marked_ends(own.points.size(), from, to);
  const fem::ScalarTets tets(part(bodies.points_rest(), own.points), part(bodies.tets(), own.tets),
                             own.points.begin);
  check_pieces(tets, ends);
  std::vector<double> field(ends.size());
  std::ranges::transform(ends, field.begin(), [](std::uint8_t end) { return end == 0 ? 0.5 : end - 1.0; });
  fem::solve_laplace(tets, ends, field);

  std::vector<Vec3> gradients;
  double largest = 0.0;
  for (std::size_t tet = 0; tet < tets.size(); ++tet) {
    gradients.push_back(tets.gradient(tet, field));
    largest = std::max(largest, length(gradients.back()));
  }
  constexpr double rounding = 1e-10;  // relative to the largest gradient: smaller ones give no direction
  for (Vec3& gradient : gradients)
    gradient = length(gradient) > rounding * largest ? normalized(gradient) : Vec3{};
  fill_gaps(bodies, own.tets, gradients);
  return gradients;
}

}  // namespace palpate
