#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include <palpate/types.hpp>

#include "geometry/vector.hpp"
#include "lattice.hpp"

namespace palpate::app {

/// Accepts a point only if it is at least a given distance away from all points accepted before.
class Thinner {
 public:
  explicit Thinner(double distance) : distance_(distance) {}
  bool take(const Vec3& p) {
    const auto cell = [&](double x) { return static_cast<std::int64_t>(std::floor(x / distance_)); };
    const std::array<std::int64_t, 3> at{cell(p.x), cell(p.y), cell(p.z)};
    bool free = true;
    for_points({3, 3, 3}, [&](int i, int j, int k) {
      const auto [begin, end] = taken_.equal_range({at[0] + i - 1, at[1] + j - 1, at[2] + k - 1});
      for (auto it = begin; it != end; ++it)
        free = free && squared_length(it->second - p) >= distance_ * distance_;
    });
    if (free) taken_.emplace(at, p);
    return free;
  }

 private:
  double distance_;
  std::multimap<std::array<std::int64_t, 3>, Vec3> taken_;
};

}  // namespace palpate::app
