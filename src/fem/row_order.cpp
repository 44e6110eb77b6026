#include "fem/row_order.hpp"

#include <algorithm>
#include <tuple>

#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr int bits = 16;  // an axis

/// Bit i of the number becomes bit 3 i.
std::uint64_t spread(std::uint64_t number) {
  std::uint64_t result = 0;
  for (int i = 0; i < bits; ++i) result |= (number >> i & 1U) << (3 * i);
  return result;
}

}  // namespace

std::vector<Index> points_along_curve(const Elements& elements, std::span<const std::uint8_t> free) {
  const auto rest = elements.points_rest();
  std::vector<Index> body(rest.size(), 0);
  for (std::size_t e = 0; e < elements.corners().size(); ++e) {
    for (const Index point : elements.corners()[e]) at(body, point) = elements.body_of_element()[e];
  }
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
    keys.emplace_back(body[i], cell(place.x) | cell(place.y) << 1 | cell(place.z) << 2,
                      static_cast<Index>(i));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<Index> points(keys.size());
  std::ranges::transform(keys, points.begin(), [](const auto& key) { return std::get<2>(key); });
  return points;
}

}  // namespace palpate::fem
