// The directions of ContactSolver: dropped, and turned with the bodies.
#include <algorithm>
#include <array>

#include "fem/contact_solver_run.hpp"
#include "fem/grains.hpp"
#include "simd/direction_rows.hpp"

namespace palpate::fem {
namespace {

using ChunkOfRows = std::array<float, simd::slice_values * slice_grain>;

}  // namespace

/// Makes room for new directions: keeps the last step and the last few directions.
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
  reduced_.compress(run.threads, change, kept);
  project_guess(run);
}

/// Moves the last step to the first place and the last directions after it, with their products. The residual
/// becomes that at c = 0.
void ContactSolver::move_directions(const Run& run, std::size_t kept) {
  const auto change = reduced_.change();
  const std::size_t size = reduced_.directions();
  for (std::size_t d = 0; d < size; ++d) scaled_[d] = -static_cast<float>(change[d]);
  const std::size_t slices = values_ / simd::slice_values;
  parallel::for_chunks(
      run.threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        const std::size_t from = simd::slice_values * begin;
        const std::size_t count = simd::slice_values * (end - begin);
        std::copy_n(&residual_[from], count, &base_residual_[from]);
        alignas(64) ChunkOfRows sum;
        for (float* list : {directions_.data(), products_.data()}) {
          const auto part = [&](std::size_t d) { return list + values_ * d + from; };
          sum.fill(0.0F);
          simd::subtract_combination({part(0), values_, size}, scaled_.data(), sum.data(), count);
          std::copy_n(sum.data(), count, part(0));
          for (std::size_t k = 0; k < kept; ++k) std::copy_n(part(size - kept + k), count, part(k + 1));
        }
      });
}

void ContactSolver::rotate_directions(const parallel::Threads& threads, std::span<const Index> point_of_row,
                                      std::span<const Index> body_of_point, const BodyRotations& rotations) {
  const std::size_t count = reduced_.directions();
  parallel::for_each(threads, point_of_row.size(), simd::slice_rows * slice_grain, [&](std::size_t row) {
    if (point_of_row[row] < 0) return;
    const Index body = at(body_of_point, point_of_row[row]);
    if (!rotations.has_rotated(body)) return;
    const Quaternion& change = rotations.frame_change(body);
    for (float* list : {directions_.data(), products_.data()}) {
      for (std::size_t d = 0; d < count; ++d) {
        const std::span<float> vector(list + d * values_, values_);
        set_row(vector, row, rotated(change, get_row(vector, row)));
      }
    }
  });
}

}  // namespace palpate::fem
