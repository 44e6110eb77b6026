#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "geometry/box.hpp"
#include "grid/entry.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "simd/cluster_query.hpp"

namespace palpate {

/// Positions as fixed-point numbers in fractions of a cell (docs/query.md).
///
/// A number is floor((x - lower) / cell size x 2^fraction_bits()), computed in double: below 2^31, monotone
/// in x, and the error of a difference of two is below 1 + 2^-20. The cell of a point is its number without
/// the fraction.
class FixedPositions {
 public:
  /// \param included  per point; the others have no fixed position
  /// \param marks  per point: whether its index gets the flag simd::marked
  FixedPositions(std::span<const std::uint8_t> included, std::span<const std::uint8_t> marks);

  /// Whether the numbers of a lattice stay finite: all but cells smaller than 1e-290.
  [[nodiscard]] static bool represents(const Lattice& lattice);
  /// Copies the positions (n_points x 3) of a frame, and returns the box of the included points; none where a
  /// coordinate may not be finite or is beyond largest_coordinate. Valid only if the box is in the domain of
  /// the lattice. Parallel, O(n).
  std::optional<Box> place(const parallel::Threads& threads, const Lattice& lattice,
                           std::span<const Vec3> positions);
  /// Copies new fixed positions of points and keeps their indices. The lattice must have the same
  /// fraction_bits().
  void set_points(std::span<const std::array<std::int32_t, 3>> numbers);
  /// The keys of all points, linear cell indices below 2^31; excluded points have no_key. Parallel, O(n).
  void write_linear_keys(const parallel::Threads& threads, std::vector<std::uint32_t>& keys) const;

  [[nodiscard]] std::span<const simd::FixedPoint> points() const { return points_; }  ///< (n_points)
  [[nodiscard]] int fraction_bits() const { return fraction_bits_; }
  /// The shift of coarse coordinates.
  [[nodiscard]] int coarse_shift() const { return std::max(fraction_bits_ - simd::Coarse::cell_bits, 0); }
  /// The cell of a fixed position; equal to Lattice::cell_of().
  [[nodiscard]] Cell cell_of(const simd::FixedPoint& p) const {
    return {std::min(p.x >> fraction_bits_, size_[0] - 1), std::min(p.y >> fraction_bits_, size_[1] - 1),
            std::min(p.z >> fraction_bits_, size_[2] - 1)};
  }
  [[nodiscard]] bool included(Index point) const { return at(included_, point) != 0; }
  [[nodiscard]] std::size_t bytes() const { return points_.capacity() * sizeof(simd::FixedPoint); }

 private:
  std::vector<std::uint8_t> included_;
  std::vector<std::uint32_t> absent_;  ///< points that are left out
  std::vector<simd::Bounds> bounds_;   ///< of a chunk
  std::vector<simd::FixedPoint> points_;
  int fraction_bits_ = 0;
  Cell size_{};
};

}  // namespace palpate
