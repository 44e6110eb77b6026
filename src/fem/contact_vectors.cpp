// The vectors of ContactSolver: in double by point, in float by row.
#include <algorithm>
#include <cmath>

#include "fem/contact_solver_run.hpp"
#include "fem/grains.hpp"
#include "room.hpp"
#include "simd/direction_rows.hpp"

namespace palpate::fem {
namespace {

using ChunkOfRows = std::array<float, simd::slice_values * slice_grain>;

/// Computes M v for a chunk of rows. The chunk begins at index `from`.
void weigh(std::span<const float> masses, std::size_t from, std::span<const float> v, ChunkOfRows& heavy) {
  const std::size_t first = simd::slice_rows * (from / simd::slice_values);
  for (std::size_t slice = 0; simd::slice_values * slice < v.size(); ++slice) {
    for (std::size_t lane = 0; lane < simd::slice_rows; ++lane) {
      const std::size_t row = first + simd::slice_rows * slice + lane;
      const float mass = row < masses.size() ? masses[row] : 0.0F;
      for (std::size_t e = 0; e < 3; ++e) {
        const std::size_t i = simd::slice_values * slice + simd::slice_rows * e + lane;
        heavy[i] = mass * v[i];
      }
    }
  }
}

}  // namespace

void ContactSolver::resize(const Run& run) {
  const std::size_t slices = run.problem.system->blocks().slice_count();
  values_ = simd::slice_values * slices;
  for (auto* list : {&base_residual_, &residual_, &preconditioned_, &guess_}) list->assign(values_, 0.0F);
  vector_.assign(simd::slice_rows * slices, simd::Quad{});
  for (auto* list : {&true_residual_, &with_contacts_, &guess_kept_, &residual_kept_})
    list->assign(run.b.size(), simd::Padded3{});
  constexpr std::size_t most = ReducedStep::max_directions;
  masses_.resize(most * most);
  for (auto* list : {&of_guess_, &of_change_}) list->resize(most);
  scaled_.resize(most);
  totals_.resize(2 * most + 3);
  make_room(sums_, (2 * most + 3) * parallel::chunk_count(slices, slice_grain));
}

/// residual = b - A x, in double.
void ContactSolver::find_residual(const Run& run) {
  run.problem.system->multiply_exactly(run.threads, run.x, true_residual_);
  parallel::for_each(run.threads, run.b.size(), point_grain, [&](std::size_t i) {
    true_residual_[i] = padded(unpadded(run.b[i]) - unpadded(true_residual_[i]));
  });
}

/// with_contacts_ = residual plus the impulses of the contacts at x. Returns its norm. O(points + contacts),
/// parallel; the sum at a point is in the order of the contacts.
double ContactSolver::add_contacts(const Run& run) {
  const auto contacts = run.contacts();
  resize_with_room(impulses_, contacts.size());
  parallel::for_each(run.threads, contacts.size(), contact_grain, [&](std::size_t k) {
    const ContactLaw& law = run.problem.laws[k];
    const Vec3 u = run.relative_velocity(contacts[k]);
    impulses_[k] =
        run.problem.friction.time_step * contact_force(law, run.problem.friction, u).whole(law.direction);
  });
  const CouplingSystem& couplings = run.problem.stiffened->couplings();
  const std::size_t first = couplings.size() - contacts.size();
  return std::sqrt(parallel::sum(run.threads, with_contacts_.size(), partial_, [&](std::size_t i) {
    const Vec3 sum = couplings.added(unpadded(true_residual_[i]), static_cast<Index>(i), impulses_, first);
    with_contacts_[i] = padded(sum);
    return squared_length(sum);
  }));
}

void ContactSolver::load(Run& run) {
  const double largest = add_contacts(run);
  run.scale = largest > 0.0 && std::isfinite(largest) ? std::ldexp(1.0, std::ilogb(largest)) : 1.0;
  const double inverse = 1.0 / run.scale;
  const auto points = run.points();
  parallel::for_each(run.threads, points.size(), point_grain, [&](std::size_t row) {
    if (points[row] < 0) return;
    set_row(base_residual_, row, unpadded(at(with_contacts_, points[row])), inverse);
    set_row(guess_, row, unpadded(at(run.x, points[row])));
  });
  const auto contacts = run.contacts();
  parallel::for_each(run.threads, contacts.size(), contact_grain,
                     [&](std::size_t k) { reduced_.set_base(k, run.relative_velocity(contacts[k])); });
  reduced_.update(run.threads);
  weigh_guess(run);
  project_guess(run);
}

/// Mass norm of the solution at c = 0.
void ContactSolver::weigh_guess(Run& run) {
  const LinearSystem& system = *run.problem.system;
  run.guess_by_mass = parallel::sum(run.threads, run.x.size(), partial_, [&](std::size_t i) {
    return system.free()[i] != 0 ? system.blocks().diagonal()[i] * squared_length(unpadded(run.x[i])) : 0.0;
  });
}

/// Inner products of the directions with the residual and with the solution at c = 0.
void ContactSolver::project_guess(const Run& run) {
  const std::size_t slices = values_ / simd::slice_values;
  const std::size_t chunks = parallel::chunk_count(slices, slice_grain);
  const std::size_t width = 2 * reduced_.directions();
  assign_with_room(sums_, width * chunks, 0.0);
  parallel::for_chunks(
      run.threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        const std::size_t from = simd::slice_values * begin;
        const std::size_t to = simd::slice_values * end;
        alignas(64) ChunkOfRows heavy;
        weigh(run.problem.system->masses(), from, std::span(guess_).subspan(from, to - from), heavy);
        for (std::size_t d = 0; 2 * d < width; ++d) {
          double* sum = &sums_[width * chunk + 2 * d];
          const simd::TwoSums sums =
              simd::dot_two(direction(d) + from, &base_residual_[from], heavy.data(), to - from);
          sum[0] = sums.first;
          sum[1] = sums.second;
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

/// Computes the relative velocities of the contacts in a direction. Returns the work of the contact forces in
/// it.
double ContactSolver::find_rates(const Run& run, std::size_t d) {
  const auto all = run.problem.stiffened->couplings().terms();
  const auto terms = all.subspan(all.size() - run.problem.laws.size());
  const float* z = direction(d);
  return parallel::sum(run.threads, terms.size(), partial_, [&](std::size_t k) {
    Vec3 u;
    for (std::size_t i = 0; i < 5; ++i) {
      const auto w = static_cast<double>(terms[k].coefficients[i]);
      if (w == 0.0) continue;
      const float* p = z + place_of(static_cast<std::size_t>(terms[k].rows[i]));
      u += w * Vec3{static_cast<double>(p[0]), static_cast<double>(p[simd::slice_rows]),
                    static_cast<double>(p[2 * simd::slice_rows])};
    }
    return reduced_.set_rate(k, d, u);
  });
}

/// Stores the impulses of the contacts at the current step (the coefficients c of the directions), minus
/// those at c = 0.
void ContactSolver::put_forces(const Run& run) {
  const std::size_t first = run.problem.couplings.size() - run.problem.laws.size();
  resize_with_room(forces_, run.problem.couplings.size());
  std::fill(forces_.begin(), forces_.begin() + static_cast<std::ptrdiff_t>(first), simd::Quad{});
  const double factor = run.problem.friction.time_step / run.scale;
  parallel::for_each(run.threads, run.problem.laws.size(), contact_grain, [&](std::size_t k) {
    const Vec3 f = factor * reduced_.force_change(k);
    forces_[first + k] = {static_cast<float>(f.x), static_cast<float>(f.y), static_cast<float>(f.z), 0.0F};
  });
}

/// residual = base residual - sum c_i A z_i + changes of the contact impulses. Also computes its norms.
void ContactSolver::compute_residual(Run& run) {
  put_forces(run);
  const auto c = reduced_.solution();
  for (std::size_t d = 0; d < c.size(); ++d) scaled_[d] = static_cast<float>(c[d] / run.scale);
  const simd::CouplingRows couplings = run.problem.stiffened->couplings().rows();
  const auto inverse_masses = run.problem.system->inverse_masses();
  const std::size_t rows = run.points().size();
  const std::size_t slices = values_ / simd::slice_values;
  const std::size_t chunks = parallel::chunk_count(slices, slice_grain);
  resize_with_room(sums_, 2 * chunks);
  parallel::for_chunks(run.threads, slices, slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         const std::size_t from = simd::slice_values * begin;
                         const std::size_t count = simd::slice_values * (end - begin);
                         std::copy_n(&base_residual_[from], count, &residual_[from]);
                         simd::subtract_combination({product(0) + from, values_, c.size()}, scaled_.data(),
                                                    &residual_[from], count);
                         double squares = 0.0;
                         double by_mass = 0.0;
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
                           const double square = squared_length(get_row(residual_, row));
                           squares += square;
                           by_mass += square * static_cast<double>(inverse_masses[row]);
                         }
                         sums_[2 * chunk] = squares;
                         sums_[2 * chunk + 1] = by_mass;
                       });
  run.squares = 0.0;
  run.by_mass = 0.0;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    run.squares += sums_[2 * chunk];
    run.by_mass += sums_[2 * chunk + 1];
  }
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
    if (points[row] >= 0) set_row(to, row, unpadded(at(residual_kept_, points[row])));
  });
  return parallel::sum(run.threads, guess_kept_.size(), partial_, [&](std::size_t i) {
    return run.problem.system->free()[i] != 0 ? dot(unpadded(guess_kept_[i]), unpadded(residual_kept_[i]))
                                              : 0.0;
  });
}

/// Adds the preconditioned residual as the next direction; false if it is zero.
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
  reduced_.add(row, of_residual, find_rates(run, d));
  return true;
}

/// Computes totals_: inner products of a new direction z: z^T A z_k and z^T M z_k for each z_k, and with the
/// residual at c = 0, the guess (by mass) and the current residual.
void ContactSolver::add_products(const Run& run, std::size_t d) {
  const std::size_t slices = values_ / simd::slice_values;
  const std::size_t chunks = parallel::chunk_count(slices, slice_grain);
  const std::size_t width = 2 * (d + 1) + 3;
  assign_with_room(sums_, width * chunks, 0.0);
  parallel::for_chunks(
      run.threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        const std::size_t from = simd::slice_values * begin;
        const std::size_t count = simd::slice_values * (end - begin);
        const float* z = direction(d) + from;
        alignas(64) ChunkOfRows heavy;
        weigh(run.problem.system->masses(), from, {z, count}, heavy);
        double* sum = &sums_[width * chunk];
        for (std::size_t k = 0; k <= d; ++k) {
          const simd::TwoSums sums =
              simd::dot_two(direction(k) + from, product(d) + from, heavy.data(), count);
          sum[2 * k] = sums.first;
          sum[2 * k + 1] = sums.second;
        }
        const simd::TwoSums residuals = simd::dot_two(z, &base_residual_[from], &residual_[from], count);
        sum[2 * d + 2] = residuals.first;
        sum[2 * d + 3] = simd::dot_floats(&guess_[from], heavy.data(), count);
        sum[2 * d + 4] = residuals.second;
      });
  for (std::size_t k = 0; k < width; ++k) {
    totals_[k] = 0.0;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) totals_[k] += sums_[width * chunk + k];
  }
}

/// Adds the step that c stands for to x, and sets c to 0.
void ContactSolver::flush(Run& run) {
  const auto c = reduced_.solution();
  const auto points = run.points();
  parallel::for_each(run.threads, values_ / simd::slice_values, slice_grain, [&](std::size_t slice) {
    alignas(64) std::array<double, simd::slice_values> sum;
    simd::combine_in_double({direction(0) + simd::slice_values * slice, values_, c.size()}, c.data(),
                            sum.data(), sum.size());
    for (std::size_t lane = 0; lane < simd::slice_rows; ++lane) {
      const std::size_t row = simd::slice_rows * slice + lane;
      if (row >= points.size() || points[row] < 0) continue;
      simd::Padded3& x = at(run.x, points[row]);
      x = padded(unpadded(x) +
                 Vec3{sum[lane], sum[simd::slice_rows + lane], sum[2 * simd::slice_rows + lane]});
      set_row(guess_, row, unpadded(x));
    }
  });
  weigh_guess(run);
  reduced_.rebase(run.threads);
}

}  // namespace palpate::fem
