#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Integer coordinates (i, j, k) of a cell.
using Cell = std::array<std::int32_t, 3>;

/// All cells with lower <= cell <= upper in each coordinate.
struct CellRange {
  Cell lower;
  Cell upper;
  [[nodiscard]] bool contains(const Cell& c) const {
    return lower[0] <= c[0] && c[0] <= upper[0] && lower[1] <= c[1] && c[1] <= upper[1] && lower[2] <= c[2] &&
           c[2] <= upper[2];
  }
  /// Number of cells along an axis, and in all (at most 2^63).
  [[nodiscard]] std::uint64_t along(std::size_t axis) const {
    return static_cast<std::uint64_t>(upper[axis] - lower[axis] + 1);
  }
  [[nodiscard]] std::uint64_t count() const { return along(0) * along(1) * along(2); }
};

/// Limit on the number of cells for which memory is allocated: 8 for each primitive, but at least 65536. In
/// larger domains, blocks of cells have one start (compact), cells are larger (uniform), or only cells in use
/// are stored (hash, cuckoo).
constexpr std::uint64_t most_cells_for(std::size_t primitives) {
  return std::max<std::uint64_t>(65536, 8 * std::uint64_t{primitives});
}

/// The domain cut into cubic cells (paper 4.1): s = ceil((e_max - e_min) / d), (i, j, k) of eq. 2.
class Lattice {
 public:
  Lattice() = default;
  /// A domain that holds `bounds`, with cells of size d = `cell_size` > 0. If an axis had more than 2^21
  /// cells, d is doubled until it fits; doublings() says how often. Contacts do not depend on d, only the
  /// time to find them.
  Lattice(const Box& bounds, double cell_size);

  /// The cell of a point; one outside the domain gets the nearest cell. Monotone in each coordinate even in
  /// rounding: a point in a box is in a cell of cells_of(box).
  [[nodiscard]] Cell cell_of(const Vec3& p) const {
    return {coordinate(p.x, lower_.x, size_[0]), coordinate(p.y, lower_.y, size_[1]),
            coordinate(p.z, lower_.z, size_[2])};
  }
  [[nodiscard]] CellRange cells_of(const Box& box) const { return {cell_of(box.lower), cell_of(box.upper)}; }
  /// Cell index, eq. 1: c = i + j s_x + k s_x s_y. At most 63 bits.
  [[nodiscard]] std::uint64_t linear_index(const Cell& cell) const {
    return static_cast<std::uint64_t>(cell[0]) +
           static_cast<std::uint64_t>(size_[0]) *
               (static_cast<std::uint64_t>(cell[1]) +
                static_cast<std::uint64_t>(size_[1]) * static_cast<std::uint64_t>(cell[2]));
  }
  [[nodiscard]] std::uint64_t cell_count() const { return linear_index({0, 0, size_[2]}); }
  /// How often d was doubled to make coordinates fit 21 bits.
  [[nodiscard]] int doublings() const { return doublings_; }
  [[nodiscard]] const Cell& size() const { return size_; }
  [[nodiscard]] double cell_size() const { return cell_size_; }
  [[nodiscard]] double inverse_cell_size() const { return inverse_cell_size_; }
  [[nodiscard]] const Box& domain() const { return domain_; }

  /// Calls visit(i, j, k) for every cell that the segment (a, b) passes, and few others (within a millionth
  /// of a cell): the rows of cells in z, then y, are cut out of the segment one after the other. O(cells
  /// passed).
  template <class Visit>
  void for_each_cell_of_segment(const Vec3& a, const Vec3& b, Visit&& visit) const;

 private:
  [[nodiscard]] double scaled(double x, double lower) const { return (x - lower) * inverse_cell_size_; }
  [[nodiscard]] static std::int32_t clamped(double x, std::int32_t size) {
    return static_cast<std::int32_t>(std::clamp(x, 0.0, static_cast<double>(size - 1)));
  }
  [[nodiscard]] std::int32_t coordinate(double x, double lower, std::int32_t size) const {
    return clamped(scaled(x, lower), size);
  }

  Box domain_;
  Vec3 lower_;
  Cell size_{0, 0, 0};
  double cell_size_ = 0.0;
  double inverse_cell_size_ = 0.0;
  int doublings_ = 0;
};

/// Coordinates beyond this are refused: their differences and products would leave the range of doubles.
inline constexpr double largest_coordinate = 1e100;

/// The box of all positions that `used` marks (n_points). Throws Error naming the first marked point that is
/// not finite or beyond largest_coordinate. `scratch` keeps memory between calls. O(n), parallel.
Box bounds_of(const parallel::Threads& threads, std::span<const Vec3> positions,
              std::span<const std::uint8_t> used, std::vector<Box>& scratch);

template <class Visit>
void Lattice::for_each_cell_of_segment(const Vec3& a, const Vec3& b, Visit&& visit) const {
  // In units of a cell. The rounding error of a position is far below `slack` (coordinates have at most 21
  // bits).
  constexpr double slack = 1e-6;
  const std::array<double, 3> p{scaled(a.x, lower_.x), scaled(a.y, lower_.y), scaled(a.z, lower_.z)};
  const std::array<double, 3> q{scaled(b.x, lower_.x), scaled(b.y, lower_.y), scaled(b.z, lower_.z)};
  struct Part {
    double begin;  // the part of the segment, as parameters from p to q
    double end;
  };
  const auto cells = [&](std::size_t axis, const Part& part) {
    const double x0 = p[axis] + part.begin * (q[axis] - p[axis]);
    const double x1 = p[axis] + part.end * (q[axis] - p[axis]);
    return std::array{clamped(std::min(x0, x1) - slack, size_[axis]),
                      clamped(std::max(x0, x1) + slack, size_[axis])};
  };
  const auto clip = [&](std::size_t axis, const Part& part, std::int32_t cell) {
    const double step = q[axis] - p[axis];
    if (std::abs(step) < 2.0 * slack) return part;  // it is all in this slab, or within `slack` of it
    const double t0 = (static_cast<double>(cell) - slack - p[axis]) / step;
    const double t1 = (static_cast<double>(cell) + 1.0 + slack - p[axis]) / step;
    return Part{std::max(part.begin, std::min(t0, t1)), std::min(part.end, std::max(t0, t1))};
  };
  const Part whole{0.0, 1.0};
  const auto k_cells = cells(2, whole);
  for (std::int32_t k = k_cells[0]; k <= k_cells[1]; ++k) {
    const Part in_k = k_cells[0] == k_cells[1] ? whole : clip(2, whole, k);
    const auto j_cells = cells(1, in_k);
    for (std::int32_t j = j_cells[0]; j <= j_cells[1]; ++j) {
      const Part in_j = j_cells[0] == j_cells[1] ? in_k : clip(1, in_k, j);
      const auto i_cells = cells(0, in_j);
      for (std::int32_t i = i_cells[0]; i <= i_cells[1]; ++i) visit(i, j, k);
    }
  }
}

}  // namespace palpate
