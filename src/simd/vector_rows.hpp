#pragma once

#include <array>
#include <cstddef>

namespace palpate::simd {

/// Numbers of a few items, one per lane.
struct LaneRow {
  static constexpr std::size_t most = 64;
  alignas(64) std::array<double, most> value;
  [[nodiscard]] double& operator[](std::size_t lane) { return value[lane]; }
  [[nodiscard]] double operator[](std::size_t lane) const { return value[lane]; }
  [[nodiscard]] double* data() { return value.data(); }
  [[nodiscard]] const double* data() const { return value.data(); }
};

/// Vectors of a few items, as structure of arrays.
struct VectorRows {
  static constexpr std::size_t most = LaneRow::most;
  LaneRow x;
  LaneRow y;
  LaneRow z;
  void put(const auto& v, std::size_t lane) {
    x[lane] = v.x;
    y[lane] = v.y;
    z[lane] = v.z;
  }
};

}  // namespace palpate::simd
