#include "grid/fixed_positions.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace palpate {
namespace {

/// Numbers stay below 2^30 and a few: differences fit 32 bits with a sign.
int fraction_bits_of(const Lattice& lattice) {
  const Cell& size = lattice.size();
  const auto most = static_cast<std::uint32_t>(std::max({size[0], size[1], size[2]}));
  return 30 - std::bit_width(most - 1);
}

}  // namespace

FixedPositions::FixedPositions(std::span<const std::uint8_t> takes_part, std::span<const std::uint8_t> marks)
    : takes_part_(takes_part.begin(), takes_part.end()), points_(takes_part.size()) {
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const std::uint32_t mark = marks[p] != 0 ? simd::marked : 0U;
    points_[p] = {0, 0, 0, static_cast<std::int32_t>(static_cast<std::uint32_t>(p) | mark)};
  }
  const auto n = static_cast<std::size_t>(std::count(takes_part.begin(), takes_part.end(), 1));
  for (std::vector<std::int32_t>* list : {&x_, &y_, &z_, &name_}) list->resize(n + simd::row_padding);
}

bool FixedPositions::represents(const Lattice& lattice) {
  return std::isfinite(std::ldexp(lattice.inverse_cell_size(), 30));
}

void FixedPositions::place(const parallel::Threads& threads, const Lattice& lattice,
                           std::span<const Vec3> positions) {
  fraction_bits_ = fraction_bits_of(lattice);
  for (std::size_t axis = 0; axis < 3; ++axis) last_cell_[axis] = lattice.size()[axis] - 1;
  const double scale = std::ldexp(lattice.inverse_cell_size(), fraction_bits_);
  const Vec3 lower = lattice.domain().lower;
  parallel::for_each(threads, positions.size(), 2048, [&](std::size_t p) {
    if (takes_part_[p] == 0) return;
    const Vec3 from_lower = positions[p] - lower;
    points_[p].x = static_cast<std::int32_t>(from_lower.x * scale);
    points_[p].y = static_cast<std::int32_t>(from_lower.y * scale);
    points_[p].z = static_cast<std::int32_t>(from_lower.z * scale);
  });
}

void FixedPositions::put_in_order(const parallel::Threads& threads, std::span<const Entry> entries) {
  parallel::for_each(threads, entries.size(), 2048, [&](std::size_t e) {
    const simd::FixedPoint& point = at(points_, reference_of(entries[e]));
    x_[e] = point.x;
    y_[e] = point.y;
    z_[e] = point.z;
    name_[e] = point.name;
  });
}

}  // namespace palpate
