#include "fem/reduced_step.hpp"

#include <algorithm>
#include <cmath>

#include "room.hpp"

namespace palpate::fem {
namespace {

/// Contacts per chunk. The bits of the result depend on it.
constexpr std::size_t reduced_grain = 64;
/// Contacts per chunk if each chunk has a matrix of sums.
constexpr std::size_t reduced_matrix_grain = 512;

std::size_t padded(std::size_t n) {
  return (n + simd::direction_lanes - 1) / simd::direction_lanes * simd::direction_lanes;
}

}  // namespace

void ReducedStep::set_capacity(std::size_t capacity) {
  capacity_ = capacity;
  stride_ = padded(capacity);
  for (auto* matrix : {&lower_, &matrix_, &stiffness_}) matrix->assign(stride_ * stride_, 0.0);
  for (auto* vector : {&change_, &trial_f_, &trial_c_, &step_, &solved_}) vector->assign(stride_, 0.0);
  f_.resize(stride_, 0.0);
}

void ReducedStep::begin(std::size_t capacity) {
  size_ = 0;
  at_base_ = true;
  set_capacity(capacity);
  gram_.assign(stride_ * stride_, 0.0);
  for (auto* vector : {&g_, &c_}) vector->assign(stride_, 0.0);
}

void ReducedStep::increase_capacity(std::size_t capacity) {
  const std::size_t before = stride_;
  set_capacity(capacity);
  // Backwards, so that no row overwrites one that is not moved yet.
  const auto spread = [&](auto& rows, std::size_t count) {
    make_room(rows, stride_ * count);
    rows.resize(stride_ * count);
    for (std::size_t i = count; i-- > 0;) {
      const auto from = rows.begin() + static_cast<std::ptrdiff_t>(before * i);
      const auto to = rows.begin() + static_cast<std::ptrdiff_t>(stride_ * i);
      std::copy_backward(from, from + static_cast<std::ptrdiff_t>(before),
                         to + static_cast<std::ptrdiff_t>(before));
      std::fill(to + static_cast<std::ptrdiff_t>(before), to + static_cast<std::ptrdiff_t>(stride_), 0);
    }
  };
  spread(gram_, before);
  gram_.resize(stride_ * stride_, 0.0);
  spread(rates_, 3 * laws_.size());
  for (auto* vector : {&g_, &c_}) vector->resize(stride_, 0.0);
  clear_stiffness();
}

void ReducedStep::set_contacts(std::span<const ContactLaw> laws, const StepFriction& friction) {
  laws_ = laws;
  friction_ = friction;
  forces_help_ = true;
  constexpr std::size_t lanes = simd::law_lanes;
  const std::size_t whole_groups = (laws.size() + lanes - 1) / lanes * lanes;
  for (auto* list : {&base_velocities_, &base_forces_, &velocities_, &forces_, &trial_velocities_,
                     &trial_forces_, &step_velocities_})
    assign_with_room(*list, whole_groups, Vec3{});
  resize_with_room(rates_, 3 * stride_ * laws.size());
  assign_with_room(bounds_, whole_groups, 0.0);
  resize_with_room(weights_, whole_groups);
  resize_with_room(changes_, whole_groups);
  make_room(partial_, std::max(2 * parallel::chunk_count(laws.size(), reduced_grain),
                               parallel::chunk_count(laws.size(), reduced_matrix_grain) * stride_) *
                          stride_);
  put_in_rows(laws, friction.time_step, law_rows_);
  clear_stiffness();
}

void ReducedStep::clear_stiffness() {
  assembled_ = 0;
  std::ranges::fill(stiffness_, 0.0);
  std::ranges::fill(weights_, Matrix3{});
}

simd::ContactRates ReducedStep::rates() const {
  return {.values = rates_.data(), .stride = stride_, .n = padded(size_)};
}

void ReducedStep::update(const parallel::Threads& threads) {
  std::ranges::fill(c_, 0.0);
  at_base_ = true;
  parallel::for_each(threads, laws_.size(), reduced_grain, [&](std::size_t k) {
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

void ReducedStep::add(std::span<const double> row, double residual, double work) {
  double f = residual + friction_.time_step * work;
  for (std::size_t i = 0; i <= size_; ++i) {
    gram_[stride_ * size_ + i] = row[i];
    gram_[stride_ * i + size_] = row[i];
    if (i < size_) f -= row[i] * c_[i];
  }
  f_[size_] = f;
  g_[size_] = residual;
  c_[size_] = 0.0;
  ++size_;
}

double ReducedStep::set_rate(std::size_t contact, std::size_t direction, const Vec3& rate) {
  float* j = rates_.data() + 3 * stride_ * contact + direction;
  j[0] = static_cast<float>(rate.x);
  j[stride_] = static_cast<float>(rate.y);
  j[2 * stride_] = static_cast<float>(rate.z);
  const Vec3 rounded{static_cast<double>(j[0]), static_cast<double>(j[stride_]),
                     static_cast<double>(j[2 * stride_])};
  return dot(rounded, forces_[contact]);
}

void ReducedStep::compress(const parallel::Threads& threads, std::span<const double> a, std::size_t kept) {
  const std::size_t first = size_ - kept;
  std::vector<double>& row = trial_c_;  // a^T G
  for (std::size_t j = 0; j < size_; ++j) {
    row[j] = 0.0;
    for (std::size_t i = 0; i < size_; ++i) row[j] += a[i] * gram_[stride_ * i + j];
  }
  double square = 0.0;
  for (std::size_t j = 0; j < size_; ++j) square += a[j] * row[j];
  parallel::for_each(threads, 3 * laws_.size(), 3 * reduced_grain, [&](std::size_t k) {
    float* j = rates_.data() + stride_ * k;
    double sum = 0.0;
    for (std::size_t i = 0; i < size_; ++i) sum += a[i] * static_cast<double>(j[i]);
    std::copy(j + first, j + size_, j + 1);
    j[0] = static_cast<float>(sum);
  });
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
  clear_stiffness();
}

/// f = F at c. The forces are relative to those at c = 0.
void ReducedStep::project(const parallel::Threads& threads, std::span<const double> c,
                          std::span<const Vec3> forces, std::vector<double>& f) {
  const std::size_t chunks = parallel::chunk_count(laws_.size(), reduced_grain);
  assign_with_room(partial_, chunks * stride_, 0.0);
  parallel::for_chunks(
      threads, laws_.size(), reduced_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
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

/// Computes J step_ once, so that a search along step_ needs no further product with J.
void ReducedStep::find_step_velocities(const parallel::Threads& threads) {
  std::fill(step_.begin() + static_cast<std::ptrdiff_t>(size_), step_.end(), 0.0);
  parallel::for_chunks(threads, laws_.size(), reduced_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::combine_rates(rates(), step_.data(), step_velocities_.data(), begin, end);
                       });
}

simd::ContactLawRows ReducedStep::law_rows(bool with_bounds) const {
  return {.values = law_rows_.data(),
          .friction = friction_.coefficient,
          .bounds = with_bounds ? bounds_.data() : nullptr};
}

/// Forces at these velocities minus those at c = 0: by Coulomb's law, or with the friction bounds held fixed.
void ReducedStep::find_forces(const parallel::Threads& threads, const std::vector<Vec3>& velocities,
                              bool with_bounds, std::vector<Vec3>& forces) const {
  parallel::for_chunks(threads, laws_.size(), reduced_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::contact_forces(law_rows(with_bounds), velocities.data(), base_forces_.data(),
                                              forces.data(), begin, end);
                       });
}

/// Computes trial velocities and forces at a fraction of step_.
void ReducedStep::try_step(const parallel::Threads& threads, double step_length, bool with_bounds) {
  parallel::for_each(threads, laws_.size(), reduced_grain, [&](std::size_t k) {
    trial_velocities_[k] = velocities_[k] + step_length * step_velocities_[k];
  });
  find_forces(threads, trial_velocities_, with_bounds, trial_forces_);
  for (std::size_t k = 0; k < size_; ++k) trial_c_[k] = c_[k] + step_length * step_[k];
}

void ReducedStep::accept_trial() {
  std::swap(c_, trial_c_);
  std::swap(velocities_, trial_velocities_);
  std::swap(forces_, trial_forces_);
  std::fill(c_.begin() + static_cast<std::ptrdiff_t>(size_), c_.end(), 0.0);
}

/// Adds rows and columns of new directions to stiffness_, with its current weights.
void ReducedStep::assemble_new(const parallel::Threads& threads) {
  const std::size_t chunks = parallel::chunk_count(laws_.size(), reduced_grain);
  for (; assembled_ < size_; ++assembled_) {
    assign_with_room(partial_, 2 * chunks * stride_, 0.0);
    parallel::for_chunks(threads, laws_.size(), reduced_grain,
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

/// On entry changes_ holds the present -df/du of a contact. Replaces it by the change since weights_ was set,
/// and updates weights_. Small changes, such as a slow rotation of the sliding direction, are set to zero:
/// Newton's method does not need them.
void ReducedStep::take_change(std::size_t contact) {
  constexpr double small = 0.03;
  Matrix3& change = changes_[contact];
  const Matrix3 now = change;
  change = now - weights_[contact];
  if (inner(change, change) <= small * small * inner(now, now)) {
    change = {};
  } else {
    weights_[contact] = now;
  }
}

/// Assembles -dF/dc at the current c. Only contacts whose derivative has changed cost O(directions^2).
void ReducedStep::assemble(const parallel::Threads& threads, bool with_bounds) {
  assemble_new(threads);
  const std::size_t chunks = parallel::chunk_count(laws_.size(), reduced_matrix_grain);
  const std::size_t n = padded(size_);
  assign_with_room(partial_, chunks * stride_ * n, 0.0);
  parallel::for_chunks(threads, laws_.size(), reduced_matrix_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         simd::contact_derivatives(law_rows(with_bounds), velocities_.data(),
                                                   changes_.front().values.data(), begin, end);
                         for (std::size_t k = begin; k < end; ++k) take_change(k);
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

}  // namespace palpate::fem
