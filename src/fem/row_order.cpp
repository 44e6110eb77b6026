#include "fem/row_order.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr int bits = 16;  // an axis

/// Moves bit i of the number to bit 3 i.
std::uint64_t spread(std::uint64_t number) {
  std::uint64_t result = 0;
  for (int i = 0; i < bits; ++i) result |= (number >> i & 1U) << (3 * i);
  return result;
}

}  // namespace

std::vector<Index> points_along_curve(std::span<const Vec3> rest, std::span<const Index> body_of_point,
                                      std::span<const std::uint8_t> free) {
  std::vector<std::tuple<Index, std::uint64_t, Index>> keys;
  if (rest.empty()) return {};
  Vec3 lower = rest[0];
  Vec3 upper = rest[0];
  for (const Vec3& p : rest) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  const Vec3 size = upper - lower;
  const double longest = std::max({size.x, size.y, size.z});
  const double scale = longest > 0.0 ? ((1 << bits) - 1) / longest : 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (free[i] == 0) continue;
    const Vec3 place = scale * (rest[i] - lower);
    const auto cell = [](double x) { return spread(static_cast<std::uint64_t>(x)); };
    keys.emplace_back(body_of_point[i], cell(place.x) | cell(place.y) << 1 | cell(place.z) << 2,
                      static_cast<Index>(i));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<Index> points(keys.size());
  std::ranges::transform(keys, points.begin(), [](const auto& key) { return std::get<2>(key); });
  return points;
}

std::vector<Index> tets_along_curve(const Bodies& bodies) {
  const std::size_t count = bodies.points_rest().size();
  const std::vector<std::uint8_t> all(count, 1);
  const std::vector<Index> points = points_along_curve(bodies.points_rest(), bodies.body_of_point(), all);
  std::vector<Index> place(count);
  for (std::size_t k = 0; k < count; ++k) at(place, points[k]) = static_cast<Index>(k);
  std::vector<std::pair<Index, Index>> keys;  // bodies in order, as their points are
  for (const Tet& tet : bodies.tets()) {
    const auto place_of = [&](std::size_t corner) { return at(place, tet[corner]); };
    keys.emplace_back(std::min({place_of(0), place_of(1), place_of(2), place_of(3)}),
                      static_cast<Index>(keys.size()));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<Index> tets(keys.size());
  std::ranges::transform(keys, tets.begin(), [](const auto& key) { return key.second; });
  return tets;
}

}  // namespace palpate::fem
