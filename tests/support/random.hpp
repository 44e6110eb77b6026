#pragma once

#include <cstdint>
#include <random>

#include <palpate/types.hpp>

namespace palpate::test {

/// Random numbers of a property test; a failing test prints its seed.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
  Vec3 point(double low, double high) { return {uniform(low, high), uniform(low, high), uniform(low, high)}; }
  /// A point of an integer grid times `step`: many coordinates are equal, many determinants are zero.
  Vec3 grid_point(int low, int high, double step) {
    return {integer(low, high) * step, integer(low, high) * step, integer(low, high) * step};
  }
  std::uint64_t word() { return engine_(); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace palpate::test
