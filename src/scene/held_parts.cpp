#include "scene/held_parts.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>

#include "geometry/vector.hpp"
#include "scene/selector.hpp"

namespace palpate {
namespace {

constexpr double held = 0.1;  // of the height

/// For each point the lowest index of a point of its piece.
std::vector<Index> pieces(const Bodies& body) {
  std::vector<Index> first(body.points_rest().size());
  std::iota(first.begin(), first.end(), Index{0});
  const auto root = [&](Index point) {
    while (at(first, point) != point) point = at(first, point) = at(first, at(first, point));
    return point;
  };
  for (const Edge& edge : body.edges()) {
    const Index a = root(edge[0]);
    const Index b = root(edge[1]);
    at(first, std::max(a, b)) = std::min(a, b);
  }
  for (std::size_t point = 0; point < first.size(); ++point) first[point] = root(static_cast<Index>(point));
  return first;
}

/// The lowest tenth of the box of some points, wider than it to all sides, so that rounding loses no point.
BoxSelection lowest_tenth(const Bodies& body, const std::vector<Index>& points) {
  Vec3 lower = at(body.points_rest(), points.front());
  Vec3 upper = lower;
  for (const Index point : points) {
    const Vec3& p = at(body.points_rest(), point);
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  constexpr double wider = 0.01;
  const Vec3 margin = wider * (upper - lower);
  return {lower - margin, {upper.x + margin.x, upper.y + margin.y, lower.z + held * (upper.z - lower.z)}};
}

}  // namespace

HeldParts held_parts(const Bodies& body) {
  constexpr std::size_t most_pieces = 20;
  std::map<Index, std::vector<Index>> by_piece;
  std::vector<Index> all;
  const std::vector<Index> piece_of = pieces(body);
  for (const Edge& edge : body.edges()) all.insert(all.end(), edge.begin(), edge.end());
  std::ranges::sort(all);
  all.erase(std::ranges::unique(all).begin(), all.end());  // without points in no tet
  for (const Index point : all) by_piece[at(piece_of, point)].push_back(point);

  HeldParts parts{{lowest_tenth(body, all)}, std::vector<std::uint8_t>(piece_of.size(), 1)};
  const auto is_held = [&](Index point) {
    return std::ranges::any_of(
        parts.boxes, [&](const BoxSelection& box) { return contains(box, at(body.points_rest(), point)); });
  };
  std::vector<std::vector<Index>> loose;
  for (auto& [first, points] : by_piece) {
    if (std::ranges::none_of(points, is_held)) loose.push_back(points);
  }
  std::ranges::stable_sort(loose, [](const auto& a, const auto& b) { return a.size() > b.size(); });
  if (loose.size() > most_pieces) loose.resize(most_pieces);
  for (const std::vector<Index>& points : loose) parts.boxes.push_back(lowest_tenth(body, points));
  for (const auto& [first, points] : by_piece) {
    if (std::ranges::none_of(points, is_held)) continue;
    for (const Index point : points) at(parts.points, point) = is_held(point) ? 1 : 0;
  }
  return parts;
}

}  // namespace palpate
