#include "fem/multigrid.hpp"

#include <algorithm>

#include "fem/grains.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t applied_node_grain = 16;
constexpr std::size_t fine_coupling_grain = 64;
constexpr int many = 20;                   // a solve with more iterations is slow
constexpr int few_iterations = 12;         // a solve with more iterations renews the couplings
constexpr int max_stale_iterations = 200;  // iterations of slow solves that cost as much as a new hierarchy

}  // namespace

bool Multigrid::is_current() const {
  return !levels_.empty() && std::ranges::equal(factors_, matrix_->elements().factors()) &&
         std::ranges::equal(diagonal_, matrix_->diagonal());
}

void Multigrid::count(int iterations) {
  if (iterations > many) stale_iterations_ += iterations;
  if (iterations > few_iterations) outdated_ = true;
}

void Multigrid::set_reference(std::span<const Vec3> reference, int stale_iterations) {
  stale_iterations_ = stale_iterations;
  if (std::ranges::equal(reference_, reference)) return;
  reference_.assign(reference.begin(), reference.end());
  levels_.clear();
}

void Multigrid::rotate(const parallel::Threads& threads, std::span<const Vec3> positions) {
  const auto points = matrix_->point_of_row();
  const Vec3 origin = at(positions, points[rows_.front()]);  // rounding of floats is smaller near zero
  parallel::for_each(threads, points.size(), simd::slice_rows * slice_grain, [&](std::size_t row) {
    if (points[row] < 0) return;
    const Vec3 p = at(positions, points[row]) - origin;
    positions_[row] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0.0F};
  });
  const simd::SlicedRows all = matrix_->rows();
  const simd::RotationRows edges{
      .slot_begin = all.slot_begin, .columns = all.columns, .edges = edges_.data()};
  parallel::for_chunks(threads, matrix_->slice_count(), slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::find_rotations(edges, positions_.data(), rotations_.data(), begin, end);
                       });
}

/// Computes V_c J_c R P of each coupling, with V_c of WeightRows. Open contacts have no stiffness and are
/// left out of coarse matrices.
void Multigrid::set_couplings(const parallel::Threads& threads, const CouplingSystem& couplings) {
  const auto row_of = matrix_->row_of_point();
  const auto row = [&](const Coupling& coupling, std::size_t k) {
    return coupling.points[k] >= 0 ? at(row_of, coupling.points[k]) : -1;
  };
  const auto all = couplings.couplings();
  resize_with_room(weights_, all.size());
  assign_with_room(block_limits_, all.size(), 0U);
  parallel::for_each(threads, all.size(), fine_coupling_grain, [&](std::size_t c) {
    weights_[c] = weight_rows(couplings.weight(c));
    if (weights_[c].count == 0) return;
    for (std::size_t k = 0; k < 5; ++k) {
      const Index r = row(all[c], k);
      if (r >= 0) block_limits_[c] += at(transfer_.begin, r + 1) - at(transfer_.begin, r);
    }
  });
  CouplingJacobians& jacobians = levels_.front().jacobians();
  jacobians.reset(all.size(), block_limits_);
  parallel::for_each(threads, all.size(), fine_coupling_grain, [&](std::size_t c) {
    const std::size_t rows = weights_[c].count;
    jacobians.rows[c] = weights_[c].count;
    for (std::size_t k = 0; rows > 0 && k < 5; ++k) {
      if (row(all[c], k) < 0) continue;
      const auto r = static_cast<std::size_t>(row(all[c], k));
      const float* rotation = &rotations_[simd::slot_values * (r / simd::slice_rows) + r % simd::slice_rows];
      Dense<3, 3> term{};  // coefficient V R
      for (std::size_t i = 0; i < 3 * rows; ++i) {
        for (std::size_t e = 0; e < 3; ++e) {
          term[i] += all[c].coefficients[k] * weights_[c].rows[i / 3 * 3 + e] *
                     static_cast<double>(rotation[simd::slice_rows * (3 * e + i % 3)]);
        }
      }
      for (std::uint32_t p = transfer_.begin[r]; p < transfer_.begin[r + 1]; ++p) {
        double* motion = jacobians.motions.data() +
                         simd::three_rows * std::size_t{jacobians.block(c, transfer_.columns[p])};
        const float* block = transfer_.blocks.data() + simd::three_by_six * p;
        for (std::size_t i = 0; i < rows; ++i) {
          for (std::size_t j = 0; j < 6; ++j) {
            for (std::size_t e = 0; e < 3; ++e)
              motion[simd::row_of_six * i + j] += term[3 * i + e] * static_cast<double>(block[4 * j + e]);
          }
        }
      }
    }
  });
}

void Multigrid::update(const parallel::Threads& threads, const LinearSystem& system,
                       std::span<const Vec3> positions) {
  if (stale_iterations_ >= max_stale_iterations && !std::ranges::equal(reference_, positions)) {
    set_reference(positions, 0);
  }
  if (!is_current()) {
    build(threads);
    rotated_at_.clear();
    outdated_ = true;
  }
  if (!std::ranges::equal(rotated_at_, positions)) {
    rotate(threads, positions);
    rotated_at_.assign(positions.begin(), positions.end());
    outdated_ = true;
  }
  smoother_.front().update(threads, system);
  if (!outdated_ && system.couplings().size() == taken_) return;
  outdated_ = false;
  taken_ = system.couplings().size();
  set_couplings(threads, system.couplings());
  for (std::size_t l = 0; l < levels_.size(); ++l)
    levels_[l].update(threads, l + 1 < levels_.size() ? &levels_[l + 1] : nullptr);
}

double Multigrid::apply(const parallel::Threads& threads, LinearSystem& system, std::span<const float> r,
                        std::span<float> z) {
  GaussSeidel& smoother = smoother_.front();
  const auto for_slices = [&](auto&& body) {
    parallel::for_chunks(
        threads, matrix_->slice_count(), slice_grain,
        [&](std::size_t begin, std::size_t end, std::size_t chunk) { body(begin, end, chunk); });
  };
  smoother.forward(threads, system, r, vector_);
  system.couplings().multiply(threads, vector_);
  const simd::SmootherRows rows = smoother.rows(system, rotations_.data());
  for_slices([&](std::size_t begin, std::size_t end, std::size_t) {
    simd::rotated_residual(rows, smoother.rest(), vector_.data(), rotated_.data(), begin, end);
  });
  CoarseLevel& coarse = levels_.front();
  parallel::for_chunks(threads, coarse.size(), applied_node_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::multiply_six_by_three(restriction_.rows(), rotated_.data(),
                                                     coarse.right_side().data(), begin, end);
                       });
  coarse.solve(threads, std::span(levels_).subspan(1));
  for_slices([&](std::size_t begin, std::size_t end, std::size_t) {
    simd::multiply_three_by_six(transfer_.rows(), coarse.solution().data(), rotated_.data(),
                                simd::slice_rows * begin, simd::slice_rows * end);
    simd::add_rotated(rows, rotated_.data(), vector_.data(), begin, end);
  });
  smoother.backward(threads, system, r, vector_);
  for_slices([&](std::size_t begin, std::size_t end, std::size_t chunk) {
    partial_[chunk] = simd::store_slices(vector_.data(), r.data(), z.data(), begin, end);
  });
  double sum = 0.0;
  for (const double part : partial_) sum += part;
  return sum;
}

}  // namespace palpate::fem
