#include "fem/corner_sums.hpp"

#include <algorithm>
#include <numeric>

#include "fem/grains.hpp"
#include "geometry/vector.hpp"
#include "simd/corner_sums.hpp"

namespace palpate::fem {
CornerSums::CornerSums(std::span<const Tet> corners, std::size_t point_count) {
  constexpr std::uint32_t none = 0xffffffffU;
  std::vector<std::uint32_t> part_of_point(point_count, none);  // index of each point in the current chunk
  std::vector<std::vector<std::uint32_t>> parts(point_count);
  std::uint32_t count = 0;
  for (std::size_t first = 0; first < corners.size(); first += chunk) {
    chunk_begin_.push_back(count);
    const auto own = corners.subspan(first, std::min(chunk, corners.size() - first));
    for (const Tet& tet : own) {
      for (const Index point : tet) {
        std::uint32_t& part = at(part_of_point, point);
        if (part == none || part < chunk_begin_.back()) {
          part = count++;
          at(parts, point).push_back(part);
        }
        place_of_corner_.push_back(static_cast<std::uint16_t>(part - chunk_begin_.back()));
      }
    }
  }
  chunk_begin_.push_back(count);
  part_sums_.resize(count);
  points_.resize(point_count);
  std::iota(points_.begin(), points_.end(), Index{0});
  std::ranges::stable_sort(points_, {}, [&](Index point) { return at(parts, point).size(); });
  part_begin_.push_back(0);
  for (const Index point : points_) {
    parts_.insert(parts_.end(), at(parts, point).begin(), at(parts, point).end());
    part_begin_.push_back(static_cast<std::uint32_t>(parts_.size()));
  }
}

void CornerSums::take(std::size_t number, const Values& values) {
  simd::Padded3* sums = part_sums_.data() + chunk_begin_[number];
  std::fill(sums, part_sums_.data() + chunk_begin_[number + 1], simd::Padded3{});
  const std::size_t first = 4 * chunk * number;
  const std::size_t count = std::min(4 * chunk, place_of_corner_.size() - first);
  simd::add_corners(values.data(), place_of_corner_.data() + first, count / 4, sums);
}

void CornerSums::collect(const parallel::Threads& threads, std::span<simd::Padded3> sums) const {
  parallel::for_each(threads, points_.size(), point_grain, [&](std::size_t i) {
    simd::Padded3 sum;
    for (std::uint32_t k = part_begin_[i]; k < part_begin_[i + 1]; ++k) {
      const simd::Padded3& part = part_sums_[parts_[k]];
      sum = {sum.x + part.x, sum.y + part.y, sum.z + part.z, 0.0};
    }
    at(sums, points_[i]) = sum;
  });
}

}  // namespace palpate::fem
