#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "fem/matrix.hpp"
#include "parallel/parallel.hpp"
#include "simd/sliced_rows.hpp"

namespace palpate::fem {

/// A force between a point and up to four others through a relative position u = sum_k coefficients[k]
/// x[points[k]]: a contact has (1, -w0, .., -w3), a grab spring (1).
///
/// Linearised at the start of a step of length h, the force on u is force - (damping + h stiffness) u', with
/// u' the time derivative of u at the END of the step. Point k receives coefficients[k] times this force. No
/// point appears twice.
struct Coupling {
  std::array<Index, 5> points{-1, -1, -1, -1, -1};  ///< -1: unused
  std::array<double, 5> coefficients{};
  Vec3 force;                  ///< on u at the start of the step, without the damping, N
  SymmetricMatrix3 stiffness;  ///< -d force / d u, positive semi-definite, N/m
  SymmetricMatrix3 damping;    ///< -d force / d u', positive semi-definite, N s/m
};

/// u from positions, or its time derivative from velocities, of all points (n_points x 3).
[[nodiscard]] Vec3 relative(const Coupling& coupling, std::span<const Vec3> values);

/// The force on u over a step of length `time_step`, N, from the velocities at its end (n_points x 3). It is
/// the force that the step used. So sums over couplings balance weight and change of momentum.
[[nodiscard]] Vec3 end_force(const Coupling& coupling, double time_step,
                             std::span<const Vec3> velocities_end);

/// The couplings' part of the linear system of a step: W = sum_c J_c^T (h D_c + h^2 S_c) J_c, with J_c the
/// coefficients of coupling c, restricted to the free points. It is never assembled.
///
/// A product has two phases: each coupling computes its own vector, then each point adds up the vectors of
/// its couplings, in ascending order. The lists of who is coupled with whom are kept until points or
/// coefficients change, that is, until the next detection; all solves until then only renew values. Keeps its
/// memory between steps.
class CouplingSystem {
 public:
  /// Sets the couplings of a step. The span must stay valid until the next call. O(n_couplings), parallel;
  /// O(n_points + n_couplings) where points or coefficients are others than before.
  /// \param free  (n_points) 1: free; the same in all calls. All points of couplings must be in [0, n_points)
  void set(const parallel::Threads& threads, std::span<const Coupling> couplings, double time_step,
           std::span<const std::uint8_t> free);

  [[nodiscard]] std::size_t size() const { return couplings_.size(); }
  /// Phase 1 of W x in double, for x of (n_points).
  void multiply(const parallel::Threads& threads, std::span<const simd::Padded3> x);
  /// Phase 2: the row of W x of a free point.
  [[nodiscard]] Vec3 product(Index point) const;
  /// Prepares products in float, of vectors in this order. O(n_couplings), parallel; O(n_rows + n_couplings)
  /// where points or coefficients are others than in the last call.
  /// \param row_of_point  (n_points), -1: no row; the same in all calls
  /// \param row_count  number of rows, including padding
  void order(const parallel::Threads& threads, std::span<const Index> row_of_point, std::size_t row_count);
  /// Phase 1 in float, in the order given to order(); also prepares phase 2.
  void multiply(const parallel::Threads& threads, std::span<const simd::Quad> x);
  [[nodiscard]] simd::CouplingRows rows() const;
  /// Phase 1 in float of these couplings only.
  void multiply_listed(const parallel::Threads& threads, std::span<const simd::Quad> x,
                       std::span<const std::uint32_t> list);
  /// Rows and coefficients of each coupling, made by order().
  [[nodiscard]] std::span<const simd::CouplingTerm> terms() const { return terms_; }
  /// Whether a free point is in any coupling.
  [[nodiscard]] bool holds(Index point) const { return at(begin_, point + 1) > at(begin_, point); }
  /// The diagonal block of W at a free point.
  [[nodiscard]] SymmetricMatrix3 diagonal_block(Index point) const;
  /// A start plus coefficient times value, for each coupling from number `first` on that holds a point.
  /// \param values  of the couplings from `first` on
  [[nodiscard]] Vec3 added(Vec3 start, Index point, std::span<const Vec3> values, std::size_t first) const;
  /// Sum of the couplings' forces at the start of the step on a free point, N.
  [[nodiscard]] Vec3 start_force(Index point) const;

  [[nodiscard]] std::span<const Coupling> couplings() const { return couplings_; }
  /// h D + h^2 S of a coupling.
  [[nodiscard]] SymmetricMatrix3 weight(std::size_t coupling) const;

 private:
  /// The contribution of a coupling at a point.
  struct Entry {
    Index coupling = 0;
    double coefficient = 0.0;
  };
  /// Which points a coupling joins, and how.
  struct Stencil {
    std::array<Index, 5> points;
    std::array<double, 5> coefficients;
    friend bool operator==(const Stencil&, const Stencil&) = default;
  };
  [[nodiscard]] std::span<const Entry> entries(Index point) const;
  [[nodiscard]] bool copy_stencils(const parallel::Threads& threads);
  void list_entries(std::span<const std::uint8_t> free);
  void order_entries(const parallel::Threads& threads, std::span<const Index> row_of_point,
                     std::size_t row_count);

  std::span<const Coupling> couplings_;
  std::vector<Stencil> stencils_;          ///< of couplings_
  std::vector<std::uint8_t> changed_;      ///< scratch: 1 for each chunk of stencils that has changed
  bool is_listed_ = false;                 ///< entries_ are those of stencils_
  bool is_ordered_ = false;                ///< the same for row_entries_
  std::vector<SymmetricMatrix3> weights_;  ///< h D + h^2 S of each coupling
  std::vector<Vec3> products_;             ///< result of phase 1, for each coupling
  std::vector<Index> begin_;               ///< (n_points + 1) into entries_
  std::vector<Index> next_;
  std::vector<Entry> entries_;  ///< by point, couplings ascending
  // The terms in float, by rows.
  std::vector<simd::CouplingTerm> terms_;
  std::vector<simd::Quad> row_products_;
  std::vector<Index> row_begin_;
  std::vector<simd::CouplingEntry> row_entries_;
};

}  // namespace palpate::fem
