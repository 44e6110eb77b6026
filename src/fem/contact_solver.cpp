#include "fem/contact_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "room.hpp"
#include "simd/direction_rows.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t slice_grain = 16;
constexpr std::size_t point_grain = 256;
constexpr std::size_t contact_grain = 256;
/// Of the goal, what the drift of the float residual from the true one may be.
constexpr double drift_share = 0.1;
/// Of the estimate of the error from the changes of the solution, with multigrid.
constexpr double safety = 2.0;
/// The preconditioner takes the contacts anew after so many iterations.
constexpr int renewal = 8;
/// Times that the true residual is looked at before a solve that rounding stops is given up.
constexpr int most_looks = 4;

std::size_t place_of(std::size_t row) {
  return simd::slice_values * (row / simd::slice_rows) + row % simd::slice_rows;
}

Vec3 unpadded(const simd::Padded3& a) {
  return {a.x, a.y, a.z};
}

simd::Padded3 padded(const Vec3& a) {
  return {a.x, a.y, a.z, 0.0};
}

double squared(const simd::Padded3& a) {
  return a.x * a.x + a.y * a.y + a.z * a.z;
}

void set(std::span<float> values, std::size_t row, const simd::Padded3& value) {
  float* place = &values[place_of(row)];
  place[0] = static_cast<float>(value.x);
  place[simd::slice_rows] = static_cast<float>(value.y);
  place[2 * simd::slice_rows] = static_cast<float>(value.z);
}

double squared_row(const float* place) {
  double sum = 0.0;
  for (std::size_t e = 0; e < 3; ++e) {
    const auto value = static_cast<double>(place[simd::slice_rows * e]);
    sum += value * value;
  }
  return sum;
}

}  // namespace

/// A solve that has begun.
struct ContactSolver::Run {
  const parallel::Threads& threads;
  const ContactProblem& problem;
  std::span<const simd::Padded3> b;
  std::span<simd::Padded3> x;
  const SolveGoal& goal;
  Multigrid& multigrid;
  std::span<const Vec3> positions;
  SolveReport report{};
  int change_at = std::numeric_limits<int>::max();  ///< iteration at which automatic takes multigrid
  double scale = 1.0;          ///< of the float residuals: theirs times it are the true ones
  double guess_by_mass = 0.0;  ///< x^T M x at c = 0
  double squares = 0.0;        ///< |residual|^2, scaled
  double by_mass = 0.0;        ///< the same by 1 / m
  double decrease = 0.0;       ///< z^T r of the last direction: what the energy falls by, per its c
  double size = 0.0;           ///< of x, by mass
  int looks = 0;               ///< at the true residual
  bool broken = false;         ///< the last direction was no new one
  bool exact_products = false;

  [[nodiscard]] std::span<Coupling> contacts() const {
    return problem.couplings.subspan(problem.couplings.size() - problem.laws.size());
  }
  [[nodiscard]] std::span<const Index> points() const { return problem.system->blocks().point_of_row(); }
  [[nodiscard]] double solution_unit() const { return std::max(size, goal.least_scale); }
  [[nodiscard]] bool reached() const {
    return (goal.of_solution ? report.relative_error : report.relative_residual) <= goal.tolerance;
  }
  [[nodiscard]] Vec3 relative_velocity(const Coupling& coupling) const {
    Vec3 u;
    for (std::size_t i = 0; i < 5; ++i) {
      const Index point = coupling.points[i];
      if (point < 0) continue;
      u += coupling.coefficients[i] * (unpadded(at(problem.base, point)) + unpadded(at(x, point)));
    }
    return u;
  }
};

void ContactSolver::resize(const Run& run) {
  const std::size_t slices = run.problem.system->blocks().slice_count();
  values_ = simd::slice_values * slices;
  for (auto* list : {&base_residual_, &residual_, &preconditioned_, &guess_}) list->assign(values_, 0.0F);
  vector_.assign(simd::slice_rows * slices, simd::Quad{});
  for (auto* list : {&true_residual_, &with_contacts_, &guess_kept_, &residual_kept_})
    list->assign(run.b.size(), simd::Padded3{});
  constexpr std::size_t most = ReducedStep::largest;
  masses_.resize(most * most);
  for (auto* list : {&of_guess_, &of_change_}) list->resize(most);
  totals_.resize(2 * most + 3);
  make_room(sums_, (2 * most + 3) * parallel::chunk_count(slices, slice_grain));
}

/// As many as cost no more to find the best step in than a part of what an iteration takes otherwise, and fit
/// into memory.
std::size_t ContactSolver::most_directions(const Run& run) {
  constexpr double share = 0.3;
  constexpr double least = 6.0;
  constexpr double memory = 256e6;  // bytes
  constexpr double of_multigrid = 10.0;
  constexpr double of_jacobi = 2.0;  // products
  const auto bytes = static_cast<double>(run.problem.system->blocks().value_bytes());
  const double product = 18.0 * bytes / (9.0 * sizeof(float));  // operations
  const double iteration = product * (run.report.multigrid ? of_multigrid : of_jacobi);
  const auto contacts = static_cast<double>(run.problem.laws.size());
  const double by_cost = std::sqrt(share * iteration / (27.0 * contacts));
  const auto rows = static_cast<double>(run.points().size());
  const double by_memory = memory / (2.0 * 3.0 * sizeof(float) * rows);
  return static_cast<std::size_t>(
      std::clamp(std::min(by_cost, by_memory), least, static_cast<double>(ReducedStep::largest)));
}

/// b - A x in double.
void ContactSolver::find_residual(const Run& run) {
  run.problem.system->multiply_exactly(run.threads, run.x, true_residual_);
  parallel::for_each(run.threads, run.b.size(), point_grain, [&](std::size_t i) {
    true_residual_[i] = padded(unpadded(run.b[i]) - unpadded(true_residual_[i]));
  });
}

/// with_contacts_ = the residual with the impulses of the contacts at x; returns its size. O(contacts), in
/// their order.
double ContactSolver::add_contacts(const Run& run) {
  const auto contacts = run.contacts();
  std::ranges::copy(true_residual_, with_contacts_.begin());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactLaw& law = run.problem.laws[k];
    const Vec3 u = run.relative_velocity(contacts[k]);
    const Vec3 impulse =
        run.problem.friction.time_step * contact_force(law, run.problem.friction, u).whole(law.direction);
    for (std::size_t i = 0; i < 5; ++i) {
      const Index point = contacts[k].points[i];
      if (point < 0 || at(run.problem.system->free(), point) == 0) continue;
      simd::Padded3& r = at(with_contacts_, point);
      r = padded(unpadded(r) + contacts[k].coefficients[i] * impulse);
    }
  }
  return std::sqrt(parallel::sum(run.threads, with_contacts_.size(), partial_,
                                 [&](std::size_t i) { return squared(with_contacts_[i]); }));
}

/// The better of the guess and zero, by the residual; no directions but those of the last solve, if it goes
/// on.
void ContactSolver::start(Run& run, bool goes_on) {
  find_residual(run);
  if (goes_on) return;
  std::ranges::copy(run.x, guess_kept_.begin());
  std::ranges::copy(true_residual_, residual_kept_.begin());
  const double of_guess = add_contacts(run);
  std::ranges::fill(run.x, simd::Padded3{});
  std::ranges::copy(run.b, true_residual_.begin());
  const double of_zero = add_contacts(run);
  const double of_b = std::sqrt(
      parallel::sum(run.threads, run.b.size(), partial_, [&](std::size_t i) { return squared(run.b[i]); }));
  residual_of_zero_ = std::max(of_b, of_zero);
  if (of_guess <= of_zero) {
    std::ranges::copy(guess_kept_, run.x.begin());
    std::ranges::copy(residual_kept_, true_residual_.begin());
  }
  reduced_.begin(most_directions(run));
  directions_.resize(reduced_.most() * values_);
  products_.resize(reduced_.most() * values_);
}

/// Float vectors and contacts from x and the true residual as they are.
void ContactSolver::restart(Run& run, bool keeps_directions) {
  if (!keeps_directions) reduced_.begin(reduced_.most());
  reduced_.set_contacts(run.problem.laws, run.problem.friction);
  for (std::size_t d = 0; d < reduced_.directions(); ++d) find_rates(run, d);
  load(run);
  estimate_.clear();
  change_estimate_.clear();
}

void ContactSolver::load(Run& run) {
  const double largest = add_contacts(run);
  run.scale = largest > 0.0 && std::isfinite(largest) ? std::ldexp(1.0, std::ilogb(largest)) : 1.0;
  const double inverse = 1.0 / run.scale;
  const auto points = run.points();
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] < 0) return;
    set(base_residual_, row, padded(inverse * unpadded(at(with_contacts_, points[row]))));
    set(guess_, row, at(run.x, points[row]));
  });
  const auto contacts = run.contacts();
  parallel::for_each(run.threads, contacts.size(), contact_grain,
                     [&](std::size_t k) { reduced_.set_base(k, run.relative_velocity(contacts[k])); });
  reduced_.update(run.threads);
  project_guess(run);
}

/// What the directions have to do with residual and solution at c = 0.
void ContactSolver::project_guess(const Run& run) {
  const auto masses = run.problem.system->masses();
  const auto points = run.points();
  const std::size_t slices = values_ / simd::slice_values;
  const std::size_t chunks = parallel::chunk_count(slices, slice_grain);
  const std::size_t width = 2 * reduced_.directions();
  assign_with_room(sums_, width * chunks, 0.0);
  parallel::for_chunks(
      run.threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        const std::size_t from = simd::slice_values * begin;
        const std::size_t to = simd::slice_values * end;
        alignas(64) std::array<float, simd::slice_values * slice_grain> heavy{};
        for (std::size_t i = from; i < to; ++i) {
          const std::size_t row =
              simd::slice_rows * (i / simd::slice_values) + i % simd::slice_values % simd::slice_rows;
          heavy[i - from] = row < points.size() && points[row] >= 0 ? masses[row] * guess_[i] : 0.0F;
        }
        for (std::size_t d = 0; 2 * d < width; ++d) {
          double* sum = &sums_[width * chunk + 2 * d];
          sum[0] = simd::dot_floats(direction(d) + from, &base_residual_[from], to - from);
          sum[1] = simd::dot_floats(direction(d) + from, heavy.data(), to - from);
        }
      });
  for (std::size_t d = 0; 2 * d < width; ++d) {
    double of_residual = 0.0;
    of_guess_[d] = 0.0;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      of_residual += sums_[width * chunk + 2 * d];
      of_guess_[d] += sums_[width * chunk + 2 * d + 1];
    }
    reduced_.set_residual(d, run.scale * of_residual);
  }
}

/// Relative velocities of the contacts in a direction.
void ContactSolver::find_rates(const Run& run, std::size_t d) {
  const auto all = run.problem.stiffened->couplings().terms();
  const auto terms = all.subspan(all.size() - run.problem.laws.size());
  const float* z = direction(d);
  parallel::for_each(run.threads, terms.size(), contact_grain, [&](std::size_t k) {
    Vec3 u;
    for (std::size_t i = 0; i < 5; ++i) {
      const auto w = static_cast<double>(terms[k].coefficients[i]);
      if (w == 0.0) continue;
      const float* p = z + place_of(static_cast<std::size_t>(terms[k].rows[i]));
      u += w * Vec3{static_cast<double>(p[0]), static_cast<double>(p[simd::slice_rows]),
                    static_cast<double>(p[2 * simd::slice_rows])};
    }
    reduced_.set_rate(k, d, u);
  });
}

/// Impulses of the contacts at the present c, less those at c = 0.
void ContactSolver::put_forces(const Run& run) {
  const std::size_t first = run.problem.couplings.size() - run.problem.laws.size();
  resize_with_room(forces_, run.problem.couplings.size());
  std::fill(forces_.begin(), forces_.begin() + static_cast<std::ptrdiff_t>(first), simd::Quad{});
  const double factor = run.problem.friction.time_step / run.scale;
  parallel::for_each(run.threads, run.problem.laws.size(), contact_grain, [&](std::size_t k) {
    const Vec3 f = factor * reduced_.more_force(k);
    forces_[first + k] = {static_cast<float>(f.x), static_cast<float>(f.y), static_cast<float>(f.z), 0.0F};
  });
}

/// residual = base residual - sum c_i A z_i + what the contacts push more, and its sizes.
void ContactSolver::compute_residual(Run& run) {
  put_forces(run);
  const auto c = reduced_.solution();
  const simd::CouplingRows couplings = run.problem.stiffened->couplings().rows();
  const auto inverse_masses = run.problem.system->inverse_masses();
  const std::size_t rows = run.points().size();
  const std::size_t slices = values_ / simd::slice_values;
  const std::size_t chunks = parallel::chunk_count(slices, slice_grain);
  assign_with_room(sums_, 2 * chunks, 0.0);
  parallel::for_chunks(run.threads, slices, slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         const std::size_t from = simd::slice_values * begin;
                         const std::size_t count = simd::slice_values * (end - begin);
                         std::copy_n(&base_residual_[from], count, &residual_[from]);
                         for (std::size_t d = 0; d < c.size(); ++d) {
                           if (c[d] == 0.0) continue;
                           simd::subtract_floats(static_cast<float>(c[d] / run.scale), product(d) + from,
                                                 &residual_[from], count);
                         }
                         for (std::size_t row = simd::slice_rows * begin;
                              row < std::min(simd::slice_rows * end, rows); ++row) {
                           float* r = &residual_[place_of(row)];
                           for (auto e = couplings.begin[row]; e < couplings.begin[row + 1]; ++e) {
                             const simd::CouplingEntry& entry = couplings.entries[e];
                             const simd::Quad& f = forces_[static_cast<std::size_t>(entry.coupling)];
                             r[0] += entry.coefficient * f.x;
                             r[simd::slice_rows] += entry.coefficient * f.y;
                             r[2 * simd::slice_rows] += entry.coefficient * f.z;
                           }
                           const double square = squared_row(r);
                           sums_[2 * chunk] += square;
                           sums_[2 * chunk + 1] += square * static_cast<double>(inverse_masses[row]);
                         }
                       });
  run.squares = 0.0;
  run.by_mass = 0.0;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    run.squares += sums_[2 * chunk];
    run.by_mass += sums_[2 * chunk + 1];
  }
}

/// What the solve begins with, and when it changes; as ConjugateGradients has it.
void ContactSolver::choose(Run& run) {
  if (run.goal.preconditioner == Preconditioner::jacobi) return;
  const int most =
      std::min(ConjugateGradients::patience(*run.problem.stiffened), run.goal.max_iterations * 9 / 10);
  if (run.goal.preconditioner == Preconditioner::automatic && run.report.jacobi_iterations < most) {
    run.change_at = most;
  } else {
    run.report.multigrid = true;
  }
}

void ContactSolver::change_preconditioner(Run& run) {
  run.report.jacobi_iterations = run.change_at;
  run.change_at = std::numeric_limits<int>::max();
  run.report.multigrid = true;
  renew_preconditioner(run);
  estimate_.clear();
  change_estimate_.clear();
}

/// The preconditioner takes the contacts as they are now. The directions that are there stay.
void ContactSolver::renew_preconditioner(Run& run) {
  const auto contacts = run.contacts();
  parallel::for_each(run.threads, contacts.size(), contact_grain, [&](std::size_t k) {
    linearise(run.problem.laws[k], run.problem.friction, reduced_.velocity(k), contacts[k]);
  });
  LinearSystem& system = *run.problem.stiffened;
  system.couplings().set(run.problem.couplings, run.problem.friction.time_step, system.free());
  system.update_preconditioner(run.threads);
  if (!run.report.multigrid) return;
  run.multigrid.begin_step();
  run.multigrid.update(run.threads, system, run.positions);
}

void ContactSolver::precondition(Run& run) {
  if (run.report.multigrid) {
    run.multigrid.apply(run.threads, *run.problem.stiffened, residual_, preconditioned_);
    return;
  }
  const auto inverse = run.problem.stiffened->inverse_diagonal();
  constexpr std::size_t n = simd::slice_rows;
  parallel::for_each(run.threads, values_ / simd::slice_values, slice_grain, [&](std::size_t slice) {
    const float* d = &inverse[simd::slice_symmetric * slice];
    const float* from = &residual_[simd::slice_values * slice];
    float* to = &preconditioned_[simd::slice_values * slice];
    for (std::size_t lane = 0; lane < n; ++lane) {
      const float x = from[lane];
      const float y = from[n + lane];
      const float z = from[2 * n + lane];
      to[lane] = d[lane] * x + d[3 * n + lane] * y + d[4 * n + lane] * z;
      to[n + lane] = d[3 * n + lane] * x + d[n + lane] * y + d[5 * n + lane] * z;
      to[2 * n + lane] = d[4 * n + lane] * x + d[5 * n + lane] * y + d[2 * n + lane] * z;
    }
  });
}

/// product(d) = A z for the preconditioned residual z; returns z^T A z.
double ContactSolver::multiply(const Run& run, std::size_t d) {
  const auto points = run.points();
  parallel::for_each(run.threads, vector_.size(), point_grain, [&](std::size_t row) {
    const float* z = &preconditioned_[place_of(row)];
    vector_[row] = {z[0], z[simd::slice_rows], z[2 * simd::slice_rows], 0.0F};
  });
  const std::span<float> to(product(d), values_);
  if (!run.exact_products) return run.problem.system->multiply(run.threads, vector_, to);
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] < 0) return;
    const simd::Quad& z = vector_[row];
    at(guess_kept_, points[row]) = {static_cast<double>(z.x), static_cast<double>(z.y),
                                    static_cast<double>(z.z), 0.0};
  });
  run.problem.system->multiply_exactly(run.threads, guess_kept_, residual_kept_);
  std::ranges::fill(to, 0.0F);
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] >= 0) set(to, row, at(residual_kept_, points[row]));
  });
  return parallel::sum(run.threads, guess_kept_.size(), partial_, [&](std::size_t i) {
    return run.problem.system->free()[i] != 0 ? dot(unpadded(guess_kept_[i]), unpadded(residual_kept_[i]))
                                              : 0.0;
  });
}

/// The preconditioned residual as the next direction; false where there is nothing in it.
bool ContactSolver::add_direction(Run& run) {
  const std::size_t d = reduced_.directions();
  const double square = multiply(run, d);
  if (!(square > 0.0) || !std::isfinite(square)) return false;
  const auto factor = static_cast<float>(1.0 / std::sqrt(square));
  parallel::for_each(run.threads, values_ / simd::slice_values, slice_grain, [&](std::size_t slice) {
    for (std::size_t i = simd::slice_values * slice; i < simd::slice_values * (slice + 1); ++i) {
      direction(d)[i] = factor * preconditioned_[i];
      product(d)[i] *= factor;
    }
  });
  add_products(run, d);
  std::span<double> row(totals_.data(), d + 1);
  for (std::size_t k = 0; k <= d; ++k) {
    mass(d, k) = totals_[2 * k + 1];
    mass(k, d) = totals_[2 * k + 1];
  }
  of_guess_[d] = totals_[2 * d + 3];
  run.decrease = run.scale * totals_[2 * d + 4];
  const double of_residual = run.scale * totals_[2 * d + 2];
  for (std::size_t k = 0; k <= d; ++k) row[k] = totals_[2 * k];
  reduced_.add(row, of_residual);
  find_rates(run, d);
  return true;
}

/// totals_: of a new direction z with each z_k, z^T A z_k and z^T M z_k; with the residual at c = 0, the
/// guess by mass, and the present residual.
void ContactSolver::add_products(const Run& run, std::size_t d) {
  const std::size_t slices = values_ / simd::slice_values;
  const std::size_t chunks = parallel::chunk_count(slices, slice_grain);
  const std::size_t width = 2 * (d + 1) + 3;
  const auto masses = run.problem.system->masses();
  assign_with_room(sums_, width * chunks, 0.0);
  parallel::for_chunks(run.threads, slices, slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         const std::size_t from = simd::slice_values * begin;
                         const std::size_t count = simd::slice_values * (end - begin);
                         const float* z = direction(d) + from;
                         alignas(64) std::array<float, simd::slice_values * slice_grain> heavy{};
                         for (std::size_t i = 0; i < count; ++i) {
                           const std::size_t row = simd::slice_rows * ((from + i) / simd::slice_values) +
                                                   i % simd::slice_values % simd::slice_rows;
                           heavy[i] = row < masses.size() ? masses[row] * z[i] : 0.0F;
                         }
                         double* sum = &sums_[width * chunk];
                         for (std::size_t k = 0; k <= d; ++k) {
                           sum[2 * k] = simd::dot_floats(direction(k) + from, product(d) + from, count);
                           sum[2 * k + 1] = simd::dot_floats(direction(k) + from, heavy.data(), count);
                         }
                         sum[2 * d + 2] = simd::dot_floats(z, &base_residual_[from], count);
                         sum[2 * d + 3] = simd::dot_floats(&guess_[from], heavy.data(), count);
                         sum[2 * d + 4] = simd::dot_floats(z, &residual_[from], count);
                       });
  for (std::size_t k = 0; k < width; ++k) {
    totals_[k] = 0.0;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) totals_[k] += sums_[width * chunk + k];
  }
}

/// Solves in the span of the directions, and measures the step.
void ContactSolver::take_step(Run& run) {
  run.broken = !reduced_.solve(run.threads);
  const auto c = reduced_.solution();
  const auto change = reduced_.change();
  double squared_change = 0.0;
  double squared_size = run.guess_by_mass;
  for (std::size_t i = 0; i < c.size(); ++i) {
    double of_change = 0.0;
    double of_c = 0.0;
    for (std::size_t j = 0; j < c.size(); ++j) {
      of_change += mass(i, j) * change[j];
      of_c += mass(i, j) * c[j];
    }
    squared_change += change[i] * of_change;
    squared_size += c[i] * (of_c + 2.0 * of_guess_[i]);
  }
  run.size = std::sqrt(std::max(squared_size, 0.0));
  if (run.broken) return;
  change_estimate_.add(std::sqrt(std::max(squared_change, 0.0)));
  estimate_.add(std::max(change.back() * run.decrease, 0.0));
}

/// How far the iterations are by their own account.
void ContactSolver::judge(Run& run) const {
  run.report.relative_residual = 0.0;
  run.report.relative_error = 0.0;
  if (run.squares == 0.0) return;
  const double unit = std::max(residual_of_zero_, run.goal.least_residual);
  run.report.relative_residual = run.scale * std::sqrt(run.squares) / unit;
  const double estimate = run.report.multigrid ? safety * change_estimate_.error() : estimate_.error();
  run.report.relative_error = std::min(run.scale * std::sqrt(run.by_mass), estimate) / run.solution_unit();
}

/// x takes over what c says, which becomes 0.
void ContactSolver::flush(Run& run) {
  const auto c = reduced_.solution();
  const auto points = run.points();
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] < 0) return;
    Vec3 sum;
    for (std::size_t d = 0; d < c.size(); ++d) {
      const float* z = direction(d) + place_of(row);
      sum += c[d] * Vec3{static_cast<double>(z[0]), static_cast<double>(z[simd::slice_rows]),
                         static_cast<double>(z[2 * simd::slice_rows])};
    }
    simd::Padded3& x = at(run.x, points[row]);
    x = padded(unpadded(x) + sum);
    set(guess_, row, x);
  });
  run.guess_by_mass = parallel::sum(run.threads, run.x.size(), partial_, [&](std::size_t i) {
    const LinearSystem& system = *run.problem.system;
    return system.free()[i] != 0 ? system.blocks().diagonal()[i] * squared(run.x[i]) : 0.0;
  });
  reduced_.rebase(run.threads);
}

/// Takes over the solution and looks at the true residual; returns whether the float one was near it.
bool ContactSolver::settle(Run& run) {
  ++run.looks;
  flush(run);
  find_residual(run);
  const double ratio = run.scale;
  std::ranges::copy(residual_, preconditioned_.begin());
  load(run);
  compute_residual(run);
  const auto inverse_masses = run.problem.system->inverse_masses();
  const auto factor = static_cast<float>(ratio / run.scale);
  const double off =
      run.scale * std::sqrt(parallel::sum(run.threads, inverse_masses.size(), partial_, [&](std::size_t row) {
        double sum = 0.0;
        for (std::size_t e = 0; e < 3; ++e) {
          const std::size_t i = place_of(row) + simd::slice_rows * e;
          const auto d = static_cast<double>(residual_[i] - factor * preconditioned_[i]);
          sum += d * d;
        }
        return static_cast<double>(inverse_masses[row]) * sum;
      }));
  const bool near = off <= drift_share * run.goal.tolerance * run.solution_unit();
  run.exact_products = run.exact_products || !near;
  return near;
}

/// Makes room: the last step and the last few directions go on.
void ContactSolver::shrink(Run& run) {
  const std::size_t size = reduced_.directions();
  const std::size_t kept = size / 3;
  flush(run);
  move_directions(run, kept);
  const auto change = reduced_.change();
  std::span<double> row(of_change_.data(), size);
  double square = 0.0;
  for (std::size_t j = 0; j < size; ++j) {
    row[j] = 0.0;
    for (std::size_t i = 0; i < size; ++i) row[j] += change[i] * mass(i, j);
    square += change[j] * row[j];
  }
  for (std::size_t i = 0; i < kept; ++i) {
    for (std::size_t j = 0; j < kept; ++j) mass(i + 1, j + 1) = mass(size - kept + i, size - kept + j);
  }
  for (std::size_t i = 0; i < kept; ++i) {
    mass(0, i + 1) = row[size - kept + i];
    mass(i + 1, 0) = row[size - kept + i];
  }
  mass(0, 0) = square;
  reduced_.compress(change, kept);
  std::ranges::copy(residual_, base_residual_.begin());
  project_guess(run);
}

/// The last step to the first place, the last directions behind it; with their products.
void ContactSolver::move_directions(const Run& run, std::size_t kept) {
  const auto change = reduced_.change();
  const std::size_t size = reduced_.directions();
  const std::size_t slices = values_ / simd::slice_values;
  parallel::for_chunks(
      run.threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        const std::size_t from = simd::slice_values * begin;
        const std::size_t count = simd::slice_values * (end - begin);
        alignas(64) std::array<float, simd::slice_values * slice_grain> sum;
        for (float* list : {directions_.data(), products_.data()}) {
          const auto part = [&](std::size_t d) { return list + values_ * d + from; };
          sum.fill(0.0F);
          for (std::size_t d = 0; d < size; ++d)
            simd::subtract_floats(-static_cast<float>(change[d]), part(d), sum.data(), count);
          std::copy_n(sum.data(), count, part(0));
          for (std::size_t k = 0; k < kept; ++k) std::copy_n(part(size - kept + k), count, part(k + 1));
        }
      });
}

SolveReport ContactSolver::solve(const parallel::Threads& threads, const ContactProblem& problem,
                                 std::span<const simd::Padded3> b, std::span<simd::Padded3> x,
                                 const SolveGoal& goal, Multigrid& multigrid, std::span<const Vec3> positions,
                                 bool goes_on) {
  Run run{.threads = threads,
          .problem = problem,
          .b = b,
          .x = x,
          .goal = goal,
          .multigrid = multigrid,
          .positions = positions};
  run.report.jacobi_iterations = goal.jacobi_iterations;
  resize(run);
  choose(run);
  start(run, goes_on);
  restart(run, true);
  run.guess_by_mass = 0.0;
  if (reduced_.directions() > 0) reduced_.solve(threads);
  flush(run);
  if (reduced_.directions() > 0) {
    find_residual(run);
    load(run);
  }
  run.size = std::sqrt(run.guess_by_mass);
  compute_residual(run);
  bool begun = false;
  const bool fixed = goal.fixed_iterations > 0;
  const int most = fixed ? goal.fixed_iterations : goal.max_iterations;
  while (true) {
    judge(run);
    if ((!fixed && run.reached()) || run.report.iterations >= most) {
      const bool near = settle(run);
      judge(run);
      if (near || run.looks >= most_looks || run.report.iterations >= most) break;
    }
    if (run.report.iterations >= run.change_at) {
      change_preconditioner(run);
    } else if (begun && run.report.iterations % renewal == 0) {
      renew_preconditioner(run);
    } else if (!begun && run.report.multigrid) {
      multigrid.update(threads, *problem.stiffened, positions);
    }
    begun = true;
    if (reduced_.directions() == reduced_.most()) shrink(run);
    precondition(run);
    if (!add_direction(run)) {
      settle(run);
      judge(run);
      break;
    }
    take_step(run);
    ++run.report.iterations;
    if (run.broken) {
      // Rounding has made the directions alike: begins anew with the true residual.
      run.exact_products = true;
      flush(run);
      find_residual(run);
      restart(run, false);
    }
    compute_residual(run);
  }
  run.report.converged = run.reached();
  // A nonlinear solve takes some three times the iterations of a linear one without a fault of the hierarchy.
  if (run.report.multigrid) multigrid.count(run.report.iterations / 3);
  return run.report;
}

}  // namespace palpate::fem
