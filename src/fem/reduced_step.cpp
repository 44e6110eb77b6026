#include "fem/reduced_step.hpp"

#include <algorithm>
#include <cmath>

#include "room.hpp"

namespace palpate::fem {
namespace {

/// Contacts of a chunk: part of the result's definition.
constexpr std::size_t grain = 64;
/// |F| that is left, by what was.
constexpr double reduction = 0.1;
constexpr int most_rounds = 6;
/// A slope so flat is none.
constexpr double flat = 0.1;

std::size_t padded(std::size_t n) {
  return (n + simd::direction_lanes - 1) / simd::direction_lanes * simd::direction_lanes;
}

}  // namespace

void ReducedStep::begin(std::size_t most) {
  most_ = most;
  stride_ = padded(most);
  size_ = 0;
  for (auto* matrix : {&gram_, &lower_, &matrix_, &stiffness_}) matrix->assign(stride_ * stride_, 0.0);
  for (auto* vector : {&g_, &c_, &change_, &f_, &trial_f_, &trial_c_, &step_, &solved_})
    vector->assign(stride_, 0.0);
}

void ReducedStep::set_contacts(std::span<const ContactLaw> laws, const StepFriction& friction) {
  laws_ = laws;
  friction_ = friction;
  for (auto* list :
       {&base_velocities_, &base_forces_, &velocities_, &forces_, &trial_velocities_, &trial_forces_})
    resize_with_room(*list, laws.size());
  resize_with_room(rates_, 3 * stride_ * laws.size());
  resize_with_room(bounds_, laws.size());
  resize_with_room(weights_, laws.size());
  resize_with_room(changes_, laws.size());
  make_room(partial_, parallel::chunk_count(laws.size(), grain) * stride_ * stride_);
  forget_stiffness();
}

void ReducedStep::forget_stiffness() {
  assembled_ = 0;
  std::ranges::fill(stiffness_, 0.0);
  std::ranges::fill(weights_, Matrix3{});
}

simd::ContactRates ReducedStep::rates() const {
  return {.values = rates_.data(), .stride = stride_, .n = padded(size_)};
}

void ReducedStep::update(const parallel::Threads& threads) {
  std::ranges::fill(c_, 0.0);
  parallel::for_each(threads, laws_.size(), grain, [&](std::size_t k) {
    velocities_[k] = base_velocities_[k];
    base_forces_[k] = contact_force(laws_[k], friction_, base_velocities_[k]).whole(laws_[k].direction);
    forces_[k] = {};
  });
}

void ReducedStep::rebase(const parallel::Threads& threads) {
  std::ranges::copy(velocities_, base_velocities_.begin());
  update(threads);
}

void ReducedStep::add(std::span<const double> row, double residual) {
  for (std::size_t i = 0; i <= size_; ++i) {
    gram_[stride_ * size_ + i] = row[i];
    gram_[stride_ * i + size_] = row[i];
  }
  g_[size_] = residual;
  c_[size_] = 0.0;
  ++size_;
}

void ReducedStep::set_rate(std::size_t contact, std::size_t direction, const Vec3& rate) {
  double* j = rates_.data() + 3 * stride_ * contact + direction;
  j[0] = rate.x;
  j[stride_] = rate.y;
  j[2 * stride_] = rate.z;
}

void ReducedStep::compress(std::span<const double> a, std::size_t kept) {
  const std::size_t first = size_ - kept;
  std::vector<double>& row = trial_c_;  // a^T G
  for (std::size_t j = 0; j < size_; ++j) {
    row[j] = 0.0;
    for (std::size_t i = 0; i < size_; ++i) row[j] += a[i] * gram_[stride_ * i + j];
  }
  double square = 0.0;
  for (std::size_t j = 0; j < size_; ++j) square += a[j] * row[j];
  for (std::size_t k = 0; k < 3 * laws_.size(); ++k) {
    double* j = rates_.data() + stride_ * k;
    double sum = 0.0;
    for (std::size_t i = 0; i < size_; ++i) sum += a[i] * j[i];
    std::copy(j + first, j + size_, j + 1);
    j[0] = sum;
  }
  for (std::size_t i = 0; i < kept; ++i) {
    for (std::size_t j = 0; j < kept; ++j)
      gram_[stride_ * (i + 1) + j + 1] = gram_[stride_ * (first + i) + first + j];
  }
  for (std::size_t i = 0; i < kept; ++i) {
    gram_[i + 1] = row[first + i];
    gram_[stride_ * (i + 1)] = row[first + i];
  }
  gram_[0] = square;
  size_ = kept + 1;
  forget_stiffness();
}

/// F at c with these forces, less those at c = 0.
void ReducedStep::project(const parallel::Threads& threads, std::span<const double> c,
                          std::span<const Vec3> forces, std::vector<double>& f) {
  const std::size_t chunks = parallel::chunk_count(laws_.size(), grain);
  assign_with_room(partial_, chunks * stride_, 0.0);
  parallel::for_chunks(
      threads, laws_.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        simd::project_forces(rates(), forces.data(), partial_.data() + stride_ * chunk, begin, end);
      });
  for (std::size_t i = 0; i < size_; ++i) {
    double sum = 0.0;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) sum += partial_[stride_ * chunk + i];
    sum = g_[i] + friction_.time_step * sum;
    for (std::size_t j = 0; j < size_; ++j) sum -= gram_[stride_ * i + j] * c[j];
    f[i] = sum;
  }
}

/// F at c, with the bounds of friction as they are or by Coulomb's law; and velocities and forces there.
void ReducedStep::evaluate(const parallel::Threads& threads, std::span<const double> c, bool with_bounds,
                           std::vector<Vec3>& u, std::vector<Vec3>& forces, std::vector<double>& f) {
  parallel::for_chunks(threads, laws_.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::combine_rates(rates(), c.data(), base_velocities_.data(), u.data(), begin, end);
    for (std::size_t k = begin; k < end; ++k) {
      const Vec3 force = with_bounds ? force_with_bound(laws_[k], friction_, u[k], bounds_[k])
                                     : contact_force(laws_[k], friction_, u[k]).whole(laws_[k].direction);
      forces[k] = force - base_forces_[k];
    }
  });
  project(threads, c, forces, f);
}

/// Rows and columns of new directions in stiffness_, with the weights that it has.
void ReducedStep::assemble_new(const parallel::Threads& threads) {
  const std::size_t chunks = parallel::chunk_count(laws_.size(), grain);
  for (; assembled_ < size_; ++assembled_) {
    assign_with_room(partial_, 2 * chunks * stride_, 0.0);
    parallel::for_chunks(threads, laws_.size(), grain,
                         [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                           double* row = partial_.data() + 2 * stride_ * chunk;
                           simd::add_stiffness_row(rates(), weights_.front().values.data(), assembled_, row,
                                                   row + stride_, begin, end);
                         });
    for (std::size_t l = 0; l <= assembled_; ++l) {
      double row = 0.0;
      double column = 0.0;
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
        row += partial_[2 * stride_ * chunk + l];
        column += partial_[2 * stride_ * chunk + stride_ + l];
      }
      stiffness_[stride_ * assembled_ + l] = row;
      stiffness_[stride_ * l + assembled_] = column;
    }
  }
}

/// -dF/dc at the present c. Only contacts that hold otherwise than before cost O(directions^2).
void ReducedStep::assemble(const parallel::Threads& threads, bool with_bounds) {
  assemble_new(threads);
  const std::size_t chunks = parallel::chunk_count(laws_.size(), grain);
  const std::size_t n = padded(size_);
  assign_with_room(partial_, chunks * stride_ * n, 0.0);
  parallel::for_chunks(
      threads, laws_.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        for (std::size_t k = begin; k < end; ++k) {
          const Matrix3 now = with_bounds
                                  ? derivative_with_bound(laws_[k], friction_, velocities_[k], bounds_[k])
                                  : derivative(laws_[k], friction_, velocities_[k]);
          changes_[k] = now - weights_[k];
          weights_[k] = now;
        }
        simd::add_stiffness(rates(), changes_.front().values.data(), partial_.data() + stride_ * n * chunk,
                            begin, end);
      });
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t l = 0; l < size_; ++l) {
      double sum = stiffness_[stride_ * i + l];
      for (std::size_t chunk = 0; chunk < chunks; ++chunk) sum += partial_[stride_ * (n * chunk + i) + l];
      stiffness_[stride_ * i + l] = sum;
      matrix_[stride_ * i + l] = gram_[stride_ * i + l] + friction_.time_step * sum;
    }
  }
}

/// False where the last direction is one of the others, to rounding.
bool ReducedStep::factor_gram() {
  constexpr double rounding = 1e-10;
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = gram_[stride_ * i + j];
      for (std::size_t k = 0; k < j; ++k) sum -= lower_[stride_ * i + k] * lower_[stride_ * j + k];
      if (i == j) {
        if (!(sum > rounding * gram_[stride_ * i + i])) return false;
        lower_[stride_ * i + i] = std::sqrt(sum);
      } else {
        lower_[stride_ * i + j] = sum / lower_[stride_ * j + j];
      }
    }
  }
  return true;
}

/// Of F, by G^-1: the energy of the step that F asks for.
double ReducedStep::norm(std::span<const double> f) {
  double square = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    double sum = f[i];
    for (std::size_t k = 0; k < i; ++k) sum -= lower_[stride_ * i + k] * solved_[k];
    solved_[i] = sum / lower_[stride_ * i + i];
    square += solved_[i] * solved_[i];
  }
  return std::sqrt(square);
}

/// matrix_ step = f, by Gauss with row exchange; false where it is singular.
bool ReducedStep::solve_linear(std::span<const double> f, std::vector<double>& step) {
  const std::size_t n = size_;
  double* m = matrix_.data();
  std::copy(f.begin(), f.begin() + static_cast<std::ptrdiff_t>(n), step.begin());
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i) {
      if (std::abs(m[stride_ * i + k]) > std::abs(m[stride_ * pivot + k])) pivot = i;
    }
    if (!(std::abs(m[stride_ * pivot + k]) > 0.0)) return false;
    if (pivot != k) {
      for (std::size_t j = k; j < n; ++j) std::swap(m[stride_ * k + j], m[stride_ * pivot + j]);
      std::swap(step[k], step[pivot]);
    }
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = m[stride_ * i + k] / m[stride_ * k + k];
      if (factor == 0.0) continue;
      for (std::size_t j = k + 1; j < n; ++j) m[stride_ * i + j] -= factor * m[stride_ * k + j];
      step[i] -= factor * step[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) step[k] -= m[stride_ * k + j] * step[j];
    step[k] /= m[stride_ * k + k];
  }
  return true;
}

/// One step with the true derivatives; false, and nothing has changed, where |F| does not fall.
bool ReducedStep::step_newton(const parallel::Threads& threads) {
  constexpr int halvings = 4;
  constexpr double enough = 0.3;
  assemble(threads, false);
  if (!solve_linear(f_, step_)) return false;
  double share = 1.0;
  for (int i = 0; i < halvings; ++i, share *= 0.5) {
    for (std::size_t k = 0; k < size_; ++k) trial_c_[k] = c_[k] + share * step_[k];
    std::fill(trial_c_.begin() + static_cast<std::ptrdiff_t>(size_), trial_c_.end(), 0.0);
    evaluate(threads, trial_c_, false, trial_velocities_, trial_forces_, trial_f_);
    const double found = norm(trial_f_);
    if (!(found < (1.0 - enough * share) * size_of_f_)) continue;
    std::swap(c_, trial_c_);
    std::swap(velocities_, trial_velocities_);
    std::swap(forces_, trial_forces_);
    std::swap(f_, trial_f_);
    size_of_f_ = found;
    return true;
  }
  return false;
}

/// Along step_ from c, with the bounds of friction as they are: falls with the share.
double ReducedStep::slope(const parallel::Threads& threads, double share) {
  for (std::size_t k = 0; k < size_; ++k) trial_c_[k] = c_[k] + share * step_[k];
  std::fill(trial_c_.begin() + static_cast<std::ptrdiff_t>(size_), trial_c_.end(), 0.0);
  evaluate(threads, trial_c_, true, trial_velocities_, trial_forces_, trial_f_);
  double sum = 0.0;
  for (std::size_t k = 0; k < size_; ++k) sum += step_[k] * trial_f_[k];
  return sum;
}

/// Minimises the convex function that the bounds of friction at c give; false where that moves nothing.
bool ReducedStep::step_convex(const parallel::Threads& threads) {
  constexpr int most_steps = 8;
  constexpr int halvings = 8;
  constexpr double furthest = 64.0;
  for (std::size_t k = 0; k < laws_.size(); ++k)
    bounds_[k] = friction_.coefficient * contact_force(laws_[k], friction_, velocities_[k]).normal;
  evaluate(threads, c_, true, velocities_, forces_, f_);
  const double first = norm(f_);
  for (int i = 0; i < most_steps && norm(f_) > flat * first; ++i) {
    assemble(threads, true);
    if (!solve_linear(f_, step_)) break;
    double at_start = 0.0;
    for (std::size_t k = 0; k < size_; ++k) at_start += step_[k] * f_[k];
    if (!(at_start > 0.0)) break;
    double low = 0.0;
    double high = 1.0;
    double at_high = slope(threads, high);
    while (high < furthest && at_high > flat * at_start) {
      low = high;
      high *= 2.0;
      at_high = slope(threads, high);
    }
    for (int k = 0; k < halvings && std::abs(at_high) > flat * at_start; ++k) {
      const double middle = 0.5 * (low + high);
      const double at_middle = slope(threads, middle);
      if (at_middle > flat * at_start) {
        low = middle;
      } else {
        high = middle;
        at_high = at_middle;
      }
    }
    for (std::size_t k = 0; k < size_; ++k) c_[k] += high * step_[k];
    evaluate(threads, c_, true, velocities_, forces_, f_);
  }
  evaluate(threads, c_, false, velocities_, forces_, f_);
  const double found = norm(f_);
  const bool moved = found != size_of_f_;
  size_of_f_ = found;
  return moved;
}

bool ReducedStep::solve(const parallel::Threads& threads) {
  std::ranges::copy(c_, change_.begin());
  const bool independent = factor_gram();
  if (!independent) {
    --size_;
    c_[size_] = 0.0;
    forget_stiffness();
  }
  if (independent) {
    project(threads, c_, forces_, f_);
    size_of_f_ = norm(f_);
    const double enough = reduction * size_of_f_;
    for (int round = 0; round < most_rounds && size_of_f_ > enough; ++round) {
      if (!step_newton(threads) && !step_convex(threads)) break;
    }
  }
  for (std::size_t i = 0; i < change_.size(); ++i) change_[i] = c_[i] - change_[i];
  return independent;
}

}  // namespace palpate::fem
