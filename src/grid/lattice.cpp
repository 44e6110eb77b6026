#include "grid/lattice.hpp"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <palpate/error.hpp>

#include "number_text.hpp"

namespace palpate {
namespace {

/// Cells along one axis; a domain without extent still has one.
double cells_along(double extent, double cell_size) {
  return std::max(1.0, std::ceil(extent / cell_size));
}

}  // namespace

Lattice::Lattice(const Box& bounds, double cell_size)
    : domain_(bounds), lower_(bounds.lower), cell_size_(cell_size) {
  // 21 bits per axis: an index fits 63 bits, and footprints compute coordinates exactly.
  constexpr double most_along = 2097152.0;
  const Vec3 extent = bounds.upper - bounds.lower;
  const double longest = std::max({extent.x, extent.y, extent.z});
  for (; cells_along(longest, cell_size_) > most_along; ++doublings_) cell_size_ *= 2.0;
  size_ = {static_cast<std::int32_t>(cells_along(extent.x, cell_size_)),
           static_cast<std::int32_t>(cells_along(extent.y, cell_size_)),
           static_cast<std::int32_t>(cells_along(extent.z, cell_size_))};
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
            throw Error("positions", "point " + std::to_string(i),
                        "(" + number_text(p.x) + ", " + number_text(p.y) + ", " + number_text(p.z) + ")",
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
