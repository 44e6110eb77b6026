#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fem/contact_law.hpp"
#include "fem/force_newton.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/contact_laws.hpp"
#include "simd/contact_rates.hpp"

namespace palpate::fem {

/// The step in the span of a few directions z_i of the change of velocity: find c with
///
///   0 = F(c) = g - G c + h sum_k J_k^T (f_k(u_k + J_k c) - f_k(u_k)),
///
/// where G_ij = z_i^T A z_j, g_i = z_i^T r with the residual r at c = 0, f_k is the force of contact k, u_k
/// its relative velocity at c = 0 and J_k (3 x n) the derivative of that by c. The contacts are not
/// linearised here: with so few unknowns an iteration costs less than a product with A.
///
/// solve() continues from the last c by Newton's method with the true derivatives. If that does not lower |F|
/// (in the norm of G^-1), as at the limit between sticking and sliding, a few contacts are solved with their
/// forces as unknowns (ForceNewton). If that does not lower |F| either, it uses Newton's method with line
/// search on the convex problem with the bounds of friction at the last c (Haslinger's fixed point). It stops
/// when |F| has fallen to a tenth, or after two rounds, since the next direction changes F anyway.
class ReducedStep {
 public:
  static constexpr std::size_t max_directions = 48;  ///< maximum number of directions

  /// Removes all directions.
  /// \param capacity  largest number of directions from now on; <= `max_directions`
  void begin(std::size_t capacity);
  /// Sets the contacts. Then set their velocities at c = 0 and their rates again. The span must stay valid.
  void set_contacts(std::span<const ContactLaw> laws, const StepFriction& friction);
  [[nodiscard]] std::size_t directions() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] std::span<const double> solution() const { return {c_.data(), size_}; }
  /// Change of the solution by the last solve().
  [[nodiscard]] std::span<const double> change() const { return {change_.data(), size_}; }
  /// The relative velocity of a contact at c = 0.
  void set_base(std::size_t contact, const Vec3& velocity) { base_velocities_[contact] = velocity; }
  /// The relative velocity of a contact at the current c, after update() or solve().
  [[nodiscard]] const Vec3& velocity(std::size_t contact) const { return velocities_[contact]; }
  /// The force of a contact at the current c minus that at c = 0, N; after update() or solve().
  [[nodiscard]] const Vec3& force_change(std::size_t contact) const { return forces_[contact]; }
  /// Call after set_base() of all contacts: sets c = 0 and computes the forces there.
  void update(const parallel::Threads& threads);
  /// Sets the change of a contact's relative velocity by a direction. Returns the work that force_change()
  /// does in it.
  double set_rate(std::size_t contact, std::size_t direction, const Vec3& rate);
  /// Adds a direction, after its rates.
  /// \param row   z^T A z_i with all directions and itself (directions() + 1)
  /// \param work  sum of the results of set_rate()
  void add(std::span<const double> row, double residual, double work);
  void set_residual(std::size_t direction, double residual) { g_[direction] = residual; }
  /// Makes the current c the new c = 0. Then set the residuals again.
  void rebase(const parallel::Threads& threads);
  /// Call at c = 0: replaces the directions by the combination sum_i a_i z_i, followed by the last `kept`
  /// ones. Then set the residuals again.
  void compress(const parallel::Threads& threads, std::span<const double> a, std::size_t kept);
  /// Increases the capacity and keeps the current directions.
  /// \param capacity  > capacity(), <= `max_directions`
  void increase_capacity(std::size_t capacity);
  /// Solves in the span. Returns false if the last direction depends linearly on the others, up to rounding;
  /// then it is dropped. O(contacts directions^2) a round.
  bool solve(const parallel::Threads& threads);

 private:
  [[nodiscard]] simd::ContactRates rates() const;
  void find_step_velocities(const parallel::Threads& threads);
  [[nodiscard]] simd::ContactLawRows law_rows(bool with_bounds) const;
  void find_forces(const parallel::Threads& threads, const std::vector<Vec3>& velocities, bool with_bounds,
                   std::vector<Vec3>& forces) const;
  void try_step(const parallel::Threads& threads, double step_length, bool with_bounds);
  void accept_trial();
  void project(const parallel::Threads& threads, std::span<const double> c, std::span<const Vec3> forces,
               std::vector<double>& f);
  void take_change(std::size_t contact);
  void assemble(const parallel::Threads& threads, bool with_bounds);
  void assemble_new(const parallel::Threads& threads);
  void clear_stiffness();
  void set_capacity(std::size_t capacity);
  bool factor_gram();
  [[nodiscard]] double norm(std::span<const double> f);
  bool solve_linear(std::span<const double> f, std::vector<double>& step);
  bool step_newton(const parallel::Threads& threads);
  bool step_convex(const parallel::Threads& threads);
  void solve_lower(double* x) const;
  void condense();
  [[nodiscard]] CondensedContacts condensed() const;
  bool step_forces(const parallel::Threads& threads);
  double search_line(const parallel::Threads& threads);

  std::span<const ContactLaw> laws_;
  simd::AlignedVector<double> law_rows_;  ///< the laws, in groups of the kernel
  StepFriction friction_{};
  std::size_t capacity_ = 0;
  std::size_t stride_ = 0;  ///< length of a row of directions, padded
  std::size_t size_ = 0;
  std::vector<double> gram_;   ///< (capacity x stride)
  std::vector<double> lower_;  ///< Cholesky factor of gram_
  std::vector<double> g_;
  std::vector<double> c_;
  std::vector<double> change_;
  std::vector<Vec3> base_velocities_;  ///< velocities of the contacts at c = 0
  std::vector<Vec3> base_forces_;      ///< forces of the contacts at c = 0, N
  std::vector<Vec3> velocities_;       ///< at c
  std::vector<Vec3> forces_;           ///< forces at c minus base_forces_, N
  std::vector<Vec3> trial_velocities_;
  std::vector<Vec3> trial_forces_;
  std::vector<Vec3> step_velocities_;  ///< change of the velocities by step_
  simd::AlignedVector<float> rates_;   ///< (contacts x 3 x stride): J
  std::vector<double> bounds_;         ///< friction bounds, N
  std::vector<Matrix3> weights_;       ///< -df/du of the contacts, as used in stiffness_, N s/m
  std::vector<Matrix3> changes_;       ///< changes of weights_, scratch
  std::vector<double> stiffness_;      ///< (stride x stride) sum_k J_k^T H_k J_k
  std::size_t assembled_ = 0;          ///< number of directions that are in stiffness_
  std::vector<double> matrix_;         ///< (size x stride), scratch
  std::vector<double> partial_;
  std::vector<double> f_;  ///< F at the current c; at c = 0 valid only after solve() has begun
  bool at_base_ = true;    ///< c = 0
  std::vector<double> trial_f_, trial_c_, step_, solved_;
  ForceNewton force_newton_;
  std::vector<double> condensed_rows_;  ///< (contacts x 3 x size) of step_forces()
  std::vector<Vec3> free_velocities_;   ///< (contacts) without contact forces, m/s
  bool forces_help_ = true;             ///< step_forces() has not failed with these contacts
  double size_of_f_ = 0.0;
};

}  // namespace palpate::fem
