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
constexpr int most_rounds = 2;
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
  constexpr std::size_t lanes = simd::law_lanes;
  const std::size_t whole_groups = (laws.size() + lanes - 1) / lanes * lanes;
  for (auto* list : {&base_velocities_, &base_forces_, &velocities_, &forces_, &trial_velocities_,
                     &trial_forces_, &step_velocities_})
    assign_with_room(*list, whole_groups, Vec3{});
  resize_with_room(rates_, 3 * stride_ * laws.size());
  assign_with_room(bounds_, whole_groups, 0.0);
  resize_with_room(weights_, whole_groups);
  resize_with_room(changes_, whole_groups);
  make_room(partial_, parallel::chunk_count(laws.size(), grain) * stride_ * stride_);
  const std::size_t numbers = simd::law_values / lanes * whole_groups;
  if (law_rows_.capacity() < numbers) law_rows_.reserve(numbers + numbers / 8);
  law_rows_.assign(numbers, 0.0);
  for (std::size_t k = 0; k < laws.size(); ++k) {
    const ContactLaw& law = laws[k];
    const Vec3& n = law.direction;
    const Vec3 pull = law.stiffness * law.slip;
    double* row = &law_rows_[simd::law_values * (k / lanes) + k % lanes];
    for (const double value : {law.stiffness * law.depth, law.resistance(friction.time_step), n.x, n.y, n.z,
                               pull.x, pull.y, pull.z}) {
      *row = value;
      row += lanes;
    }
  }
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
    base_forces_[k] = {};
    forces_[k] = {};
  });
  find_forces(threads, base_velocities_, false, trial_forces_);
  base_forces_.swap(trial_forces_);
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

/// J step_, so that a search along step_ needs no J.
void ReducedStep::find_step_velocities(const parallel::Threads& threads) {
  std::fill(step_.begin() + static_cast<std::ptrdiff_t>(size_), step_.end(), 0.0);
  parallel::for_chunks(threads, laws_.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::combine_rates(rates(), step_.data(), step_velocities_.data(), begin, end);
  });
}

simd::ContactLawRows ReducedStep::law_rows(bool with_bounds) const {
  return {.values = law_rows_.data(),
          .friction = friction_.coefficient,
          .bounds = with_bounds ? bounds_.data() : nullptr};
}

/// Forces at these velocities, less those at c = 0: by Coulomb's law, or with the bounds as they are.
void ReducedStep::find_forces(const parallel::Threads& threads, const std::vector<Vec3>& velocities,
                              bool with_bounds, std::vector<Vec3>& forces) const {
  parallel::for_chunks(threads, laws_.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::contact_forces(law_rows(with_bounds), velocities.data(), base_forces_.data(), forces.data(), begin,
                         end);
  });
}

/// Trial velocities and forces at that share of step_.
void ReducedStep::try_share(const parallel::Threads& threads, double share, bool with_bounds) {
  parallel::for_each(threads, laws_.size(), grain, [&](std::size_t k) {
    trial_velocities_[k] = velocities_[k] + share * step_velocities_[k];
  });
  find_forces(threads, trial_velocities_, with_bounds, trial_forces_);
  for (std::size_t k = 0; k < size_; ++k) trial_c_[k] = c_[k] + share * step_[k];
}

void ReducedStep::accept_trial() {
  std::swap(c_, trial_c_);
  std::swap(velocities_, trial_velocities_);
  std::swap(forces_, trial_forces_);
  std::fill(c_.begin() + static_cast<std::ptrdiff_t>(size_), c_.end(), 0.0);
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
  parallel::for_chunks(threads, laws_.size(), grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         simd::contact_derivatives(law_rows(with_bounds), velocities_.data(),
                                                   changes_.front().values.data(), begin, end);
                         for (std::size_t k = begin; k < end; ++k) {
                           const Matrix3 now = changes_[k];
                           changes_[k] = now - weights_[k];
                           weights_[k] = now;
                         }
                         simd::add_stiffness(rates(), changes_.front().values.data(),
                                             partial_.data() + stride_ * n * chunk, begin, end);
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
  find_step_velocities(threads);
  double share = 1.0;
  for (int i = 0; i < halvings; ++i, share *= 0.5) {
    try_share(threads, share, false);
    project(threads, trial_c_, trial_forces_, trial_f_);
    const double found = norm(trial_f_);
    if (!(found < (1.0 - enough * share) * size_of_f_)) continue;
    accept_trial();
    std::swap(f_, trial_f_);
    size_of_f_ = found;
    return true;
  }
  return false;
}

/// The share of step_ at which the convex function that the bounds of friction give is least, about; 0 where
/// it rises from the start. O(contacts) a trial.
double ReducedStep::search_line(const parallel::Threads& threads) {
  constexpr int halvings = 8;
  constexpr double furthest = 64.0;
  double constant = 0.0;
  double curvature = 0.0;
  for (std::size_t i = 0; i < size_; ++i) {
    double along_c = 0.0;
    double along_step = 0.0;
    for (std::size_t j = 0; j < size_; ++j) {
      along_c += gram_[stride_ * i + j] * c_[j];
      along_step += gram_[stride_ * i + j] * step_[j];
    }
    constant += step_[i] * (g_[i] - along_c);
    curvature += step_[i] * along_step;
  }
  // step^T F: how fast the function falls.
  const auto slope = [&](double share) {
    try_share(threads, share, true);
    const double work = parallel::sum(threads, laws_.size(), partial_, [&](std::size_t k) {
      return dot(step_velocities_[k], trial_forces_[k]);
    });
    return constant - share * curvature + friction_.time_step * work;
  };
  const double at_start = slope(0.0);
  if (!(at_start > 0.0)) return 0.0;
  double low = 0.0;
  double high = 1.0;
  double at_high = slope(high);
  while (high < furthest && at_high > flat * at_start) {
    low = high;
    high *= 2.0;
    at_high = slope(high);
  }
  for (int k = 0; k < halvings && std::abs(at_high) > flat * at_start; ++k) {
    const double middle = 0.5 * (low + high);
    const double at_middle = slope(middle);
    if (at_middle > flat * at_start) {
      low = middle;
    } else {
      high = middle;
      at_high = at_middle;
    }
  }
  return high;
}

/// Minimises the convex function that the bounds of friction at c give; false where that moves nothing.
bool ReducedStep::step_convex(const parallel::Threads& threads) {
  constexpr int most_steps = 8;
  parallel::for_each(threads, laws_.size(), grain, [&](std::size_t k) {
    bounds_[k] = friction_.coefficient * contact_force(laws_[k], friction_, velocities_[k]).normal;
  });
  find_forces(threads, velocities_, true, forces_);
  project(threads, c_, forces_, f_);
  const double first = norm(f_);
  for (int i = 0; i < most_steps && norm(f_) > flat * first; ++i) {
    assemble(threads, true);
    if (!solve_linear(f_, step_)) break;
    find_step_velocities(threads);
    const double share = search_line(threads);
    if (share == 0.0) break;
    try_share(threads, share, true);
    accept_trial();
    project(threads, c_, forces_, f_);
  }
  find_forces(threads, velocities_, false, forces_);
  project(threads, c_, forces_, f_);
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
