#pragma once

#include <span>
#include <vector>

#include "fem/body_rotations.hpp"
#include "fem/conjugate_gradients.hpp"
#include "fem/contact_law.hpp"
#include "fem/error_estimate.hpp"
#include "fem/inner_solve.hpp"
#include "fem/linear_system.hpp"
#include "fem/multigrid.hpp"
#include "fem/reduced_step.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"

namespace palpate::fem {

/// A step with contacts: find x with b - A x + h sum_k J_k^T f_k(J_k (v + x)) = 0.
struct ContactProblem {
  /// A: the matrix of bodies, ties and grabs, without contacts.
  LinearSystem* system = nullptr;
  /// A with the linearised contacts added: the matrix for the preconditioners.
  LinearSystem* stiffened = nullptr;
  std::span<const ContactLaw> laws;
  /// The couplings of `stiffened`. The last ones are the contacts, in the order of the laws.
  std::span<Coupling> couplings;
  StepFriction friction{};
  std::span<const simd::Padded3> base;  ///< (n_points) v: the velocities to which x is added
};

/// Conjugate gradients for a step with contacts. Contact forces are nonlinear: unilateral, with Coulomb's
/// friction. As in the linear method, an iteration takes the preconditioned residual as a new direction and
/// needs one product with it. But the step is the solution of the whole nonlinear problem in the span of all
/// directions so far (ReducedStep). This is sequential subspace optimisation (Narkiss & Zibulevsky, Technion
/// CCIT 559 (2005)), similar to nonlinear Krylov methods (Washio & Oosterlee, ETNA 6 (1997)). Without
/// contacts it equals conjugate gradients. Contacts may change their status any number of times between two
/// products. So a step takes as many iterations as one linear solve, or a few times that.
///
/// With thousands of contacts, the step in the span costs more than many products. Then a few iterations of
/// conjugate gradients with linearised contacts make each direction (InnerSolve).
///
/// Memory and the cost of the contacts limit the number of directions. At the limit, the last step and the
/// last few directions are kept. The preconditioner is renewed with the current contacts every few
/// iterations. Vectors are in float, by rows, on a residual scaled to about 1; their sum is checked in
/// double, as in ConjugateGradients. The bits are the same for every thread count. Keeps its memory between
/// solves.
class ContactSolver {
 public:
  /// \param b  (n_points) right side without contacts, zero at points that are not free
  /// \param x          (n_points) On entry a guess; if zero is better, zero is used. On return the solution
  /// \param positions  (n_points), for Multigrid::update()
  /// \param goes_on  x is the solution of the last call, with the same A and b, so its directions are used
  ///     again
  SolveReport solve(const parallel::Threads& threads, const ContactProblem& problem,
                    std::span<const simd::Padded3> b, std::span<simd::Padded3> x, const SolveGoal& goal,
                    Multigrid& multigrid, std::span<const Vec3> positions, bool goes_on);

  /// Rotates the directions with the frames of bodies that have turned. Their products with A rotate alike if
  /// A only has the tissue of bodies: A = Q A_before Q^T. O(n_points directions).
  void rotate_directions(const parallel::Threads& threads, std::span<const Index> point_of_row,
                         std::span<const Index> body_of_point, const BodyRotations& rotations);

 private:
  struct Run;
  void resize(const Run& run);
  [[nodiscard]] static std::size_t most_directions(const Run& run);
  [[nodiscard]] static int inner_iterations(const Run& run);
  void start(Run& run, bool goes_on);
  void begin_estimates(const Run& run);
  void restart(Run& run, bool keeps_directions);
  void find_residual(const Run& run);
  double add_contacts(const Run& run);
  void load(Run& run);
  void weigh_guess(Run& run);
  void project_guess(const Run& run);
  double find_rates(const Run& run, std::size_t direction);
  void put_forces(const Run& run);
  void compute_residual(Run& run);
  void choose(Run& run, bool goes_on);
  [[nodiscard]] static bool must_change(const Run& run);
  static void store_fraction(Run& run);
  void change_preconditioner(Run& run);
  void renew_preconditioner(Run& run);
  void keep_current(Run& run);
  void precondition(Run& run);
  bool add_direction(Run& run);
  double multiply(const Run& run, std::size_t direction);
  void add_products(const Run& run, std::size_t direction);
  void apply_step(Run& run);
  void estimate_error(Run& run) const;
  void flush(Run& run);
  bool check_true_residual(Run& run);
  bool is_worse_than_zero(const Run& run);
  bool gains_speed(const Run& run);
  bool grow(Run& run);
  void shrink(Run& run);
  void move_directions(const Run& run, std::size_t kept);
  [[nodiscard]] float* direction(std::size_t i) { return directions_.data() + i * values_; }
  [[nodiscard]] float* product(std::size_t i) { return products_.data() + i * values_; }
  [[nodiscard]] double& mass(std::size_t i, std::size_t j) {
    return masses_[ReducedStep::max_directions * i + j];
  }

  std::vector<Vec3> impulses_;  ///< of the contacts, scratch
  ReducedStep reduced_;
  InnerSolve inner_;
  bool multigrid_ = false;         ///< the last solve ended with multigrid
  double residual_of_zero_ = 0.0;  ///< reference for relative residuals, N s
  // One value for each row, in float.
  std::size_t values_ = 0;                    ///< number of values in a vector
  simd::AlignedVector<float> directions_;     ///< z_i, with |z_i|_A = 1
  simd::AlignedVector<float> products_;       ///< A z_i
  simd::AlignedVector<float> base_residual_;  ///< at c = 0, scaled
  simd::AlignedVector<float> residual_;       ///< at the current c, scaled
  simd::AlignedVector<float> preconditioned_;
  simd::AlignedVector<float> guess_;  ///< x at c = 0
  simd::AlignedVector<simd::Quad> vector_;
  std::vector<simd::Quad>
      forces_;  ///< impulses of the couplings minus those at c = 0, scaled; 0 except for contacts
  // One value for each point, in double.
  std::vector<simd::Padded3> true_residual_;
  std::vector<simd::Padded3> with_contacts_;
  std::vector<simd::Padded3> guess_kept_;
  std::vector<simd::Padded3> residual_kept_;
  // Products of directions.
  std::vector<double> masses_;     ///< z_i^T M z_j
  std::vector<double> of_guess_;   ///< z_i^T M x at c = 0
  std::vector<double> of_change_;  ///< scratch
  std::vector<float> scaled_;      ///< scratch
  std::vector<double> totals_;     ///< scratch
  std::vector<double> sums_;       ///< scratch
  std::vector<double> partial_;    ///< scratch
  ErrorEstimate estimate_;
  ChangeEstimate change_estimate_;  ///< with multigrid, or with several inner iterations
};

}  // namespace palpate::fem
