#pragma once

namespace palpate::simd {

/// A vector of three with a fourth lane, which is zero: one aligned load of four.
struct alignas(32) Padded3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double w = 0.0;
};
inline double dot(const Padded3& a, const Padded3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Three floats and a fourth lane, which may hold another value.
struct alignas(16) Quad {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  float w = 0.0F;
};

}  // namespace palpate::simd
