#include "scene/held_parts.hpp"

#include <algorithm>
#include <cstddef>
#include <map>

#include "geometry/disjoint_sets.hpp"
#include "geometry/vector.hpp"
#include "scene/selector.hpp"

namespace palpate {
namespace {

constexpr double held = 0.1;  // relative to the height

/// The lowest tenth of the bounding box of some points. It is wider than the box to all sides, so that
/// rounding loses no point.
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
  DisjointSets pieces(body.points_rest().size());
  for (const Edge& edge : body.edges()) pieces.join(edge[0], edge[1]);
  for (const Edge& edge : body.edges()) all.insert(all.end(), edge.begin(), edge.end());
  std::ranges::sort(all);
  all.erase(std::ranges::unique(all).begin(), all.end());  // without points that are in no tet
  for (const Index point : all) by_piece[pieces.find(point)].push_back(point);

  HeldParts parts{{lowest_tenth(body, all)}, std::vector<std::uint8_t>(body.points_rest().size(), 1)};
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
