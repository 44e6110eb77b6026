#include "grid/lattice.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <palpate/error.hpp>

namespace palpate {
namespace {

/// Cells along one axis; a domain without extent still has one.
double cells_along(double extent, double cell_size) {
  return std::max(1.0, std::ceil(extent / cell_size));
}

}  // namespace

Lattice::Lattice(const Box& bounds, double cell_size, double most_cells)
    : domain_(bounds), lower_(bounds.lower), cell_size_(cell_size) {
  // 21 bits an axis keep coordinates exact in the footprints; 2^31 cells keep the index below the 32 bits of
  // an entry.
  constexpr double most_along = 2097152.0;
  const double most = std::min(most_cells, 2147483648.0);
  const Vec3 extent = bounds.upper - bounds.lower;
  double sx = 1.0;
  double sy = 1.0;
  double sz = 1.0;
  const auto too_many = [&] {
    sx = cells_along(extent.x, cell_size_);
    sy = cells_along(extent.y, cell_size_);
    sz = cells_along(extent.z, cell_size_);
    return sx > most_along || sy > most_along || sz > most_along || sx * sy * sz > std::max(1.0, most);
  };
  while (too_many()) cell_size_ *= 2.0;
  size_ = {static_cast<std::int32_t>(sx), static_cast<std::int32_t>(sy), static_cast<std::int32_t>(sz)};
  inverse_cell_size_ = 1.0 / cell_size_;
}

Box bounds_of(const parallel::Threads& threads, std::span<const Vec3> positions,
              std::span<const std::uint8_t> used, std::vector<Box>& scratch) {
  constexpr std::size_t grain = 8192;
  scratch.resize(parallel::chunk_count(positions.size(), grain));
  parallel::for_chunks(
      threads, positions.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        Box box;
        for (std::size_t i = begin; i < end; ++i) {
          if (used[i] == 0) continue;
          const Vec3& p = positions[i];
          // Written so that NaN fails it.
          if (!(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= largest_coordinate) ||
              !is_finite(p)) {
            throw Error(
                "positions", "point " + std::to_string(i),
                "(" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) + ")",
                "finite coordinates of at most 1e100");
          }
          box.extend(p);
        }
        scratch[chunk] = box;
      });
  Box all;
  for (const Box& box : scratch) all.extend(box);
  return all;
}

}  // namespace palpate
