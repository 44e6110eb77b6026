#include "grid/fixed_positions.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace palpate {
namespace {

constexpr std::size_t fixed_grain = 2048;
/// Grain of loops with little work per item.
constexpr std::size_t light_grain = 8192;

/// Keeps numbers near or below 2^30, so that differences fit signed 32 bits.
int fraction_bits_of(const Lattice& lattice) {
  const Cell& size = lattice.size();
  const auto most = static_cast<std::uint32_t>(std::max({size[0], size[1], size[2]}));
  return 30 - static_cast<int>(std::bit_width(most - 1));
}

}  // namespace

FixedPositions::FixedPositions(std::span<const std::uint8_t> included, std::span<const std::uint8_t> marks)
    : included_(included.begin(), included.end()), points_(included.size()) {
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const std::uint32_t mark = marks[p] != 0 ? simd::marked : 0U;
    if (included[p] == 0) absent_.push_back(static_cast<std::uint32_t>(p));
    points_[p] = {0, 0, 0, static_cast<std::int32_t>(static_cast<std::uint32_t>(p) | mark)};
  }
}

bool FixedPositions::represents(const Lattice& lattice) {
  return std::isfinite(std::ldexp(lattice.inverse_cell_size(), 30));
}

std::optional<Box> FixedPositions::place(const parallel::Threads& threads, const Lattice& lattice,
                                         std::span<const Vec3> positions) {
  fraction_bits_ = fraction_bits_of(lattice);
  size_ = lattice.size();
  const double scale = std::ldexp(lattice.inverse_cell_size(), fraction_bits_);
  const Vec3 lower = lattice.domain().lower;
  bounds_.resize(parallel::chunk_count(positions.size(), fixed_grain));
  parallel::for_chunks(
      threads, positions.size(), fixed_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        bounds_[chunk] =
            simd::place_points(positions.subspan(begin, end - begin), lower, scale, points_.data() + begin);
      });
  // Excluded points may have any position: it is set to zero.
  for (const std::uint32_t p : absent_) points_[p] = {0, 0, 0, points_[p].name};
  if (!absent_.empty()) return std::nullopt;
  Box box;
  bool finite = true;
  for (const simd::Bounds& part : bounds_) {
    box.extend(Box{part.lower, part.upper});
    finite = finite && part.finite;
  }
  const Box most{{-largest_coordinate, -largest_coordinate, -largest_coordinate},
                 {largest_coordinate, largest_coordinate, largest_coordinate}};
  return finite && most.contains(box.lower) && most.contains(box.upper) ? std::optional(box) : std::nullopt;
}

void FixedPositions::set_points(std::span<const std::array<std::int32_t, 3>> numbers) {
  for (std::size_t p = 0; p < points_.size(); ++p)
    points_[p] = {numbers[p][0], numbers[p][1], numbers[p][2], points_[p].name};
}

void FixedPositions::write_linear_keys(const parallel::Threads& threads,
                                       std::vector<std::uint32_t>& keys) const {
  keys.resize(points_.size());
  const simd::KeyRule rule{fraction_bits_, size_};
  parallel::for_chunks(
      threads, points_.size(), light_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        simd::linear_keys(std::span(points_).subspan(begin, end - begin), rule, keys.data() + begin);
      });
  for (const std::uint32_t p : absent_) keys[p] = no_key;
}

}  // namespace palpate
