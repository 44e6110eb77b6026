#include "fem/linear_system.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fem/grains.hpp"
#include "fem/matrix.hpp"
#include "fem/padded_vectors.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
LinearSystem::LinearSystem(const BlockMatrix& blocks, CouplingSystem& couplings,
                           std::vector<std::uint8_t> free)
    : blocks_(&blocks),
      couplings_(&couplings),
      free_(std::move(free)),
      body_of_point_(blocks.body_of_point()),
      inverse_masses_(blocks.row_count(), 0.0F),
      diagonal_(simd::slice_symmetric * blocks.slice_count()),
      inverse_diagonal_(diagonal_.size()),
      partial_(parallel::chunk_count(blocks.slice_count(), slice_grain)) {
  for (std::size_t i = 0; i < free_.size(); ++i) {
    if (blocks.elements_of_point()[static_cast<Index>(i)].empty()) body_of_point_[i] = -1;
    if (body_of_point_[i] < 0) continue;
    if (bodies_.empty() || body_of_point_[bodies_.back().begin] != body_of_point_[i])
      bodies_.push_back({.begin = i});
    bodies_.back().end = i + 1;
  }
  changes_.resize(bodies_.size());
}

bool LinearSystem::needs_exact_products(const parallel::Threads& threads) {
  constexpr float largest = 1e7F;  // stiffness over mass: a float has seven digits
  constexpr std::size_t n = simd::slice_rows;
  const auto blocks = blocks_->diagonal_blocks();
  const auto masses = blocks_->masses();
  parallel::for_chunks(threads, blocks_->slice_count(), slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         bool stiff = false;
                         for (std::size_t slice = begin; slice < end; ++slice) {
                           const float* block = &blocks[simd::slice_symmetric * slice];
                           for (std::size_t lane = 0; lane < n; ++lane) {
                             const float trace = block[lane] + block[n + lane] + block[2 * n + lane];
                             stiff = stiff || trace > 3.0F * largest * masses[n * slice + lane];
                           }
                         }
                         partial_[chunk] = stiff ? 1.0 : 0.0;
                       });
  return std::ranges::find(partial_, 1.0) != partial_.end();
}

/// The part of one body in rigid_change().
LinearSystem::RigidChange LinearSystem::rigid_change(const PointRange& points,
                                                     std::span<const simd::Padded3> residual,
                                                     std::span<const Vec3> positions) const {
  const auto masses = blocks_->diagonal();
  bool is_free = true;
  RigidChange change;
  Vec3 center;
  for (std::size_t i = points.begin; i < points.end; ++i) {
    if (body_of_point_[i] < 0) continue;
    is_free = is_free && free_[i] != 0;
    if (free_[i] == 0) continue;
    change.mass += masses[i];
    center += masses[i] * positions[i];
  }
  if (!is_free) return change;
  center = (1.0 / change.mass) * center;
  Vec3 force;
  Vec3 torque;
  Matrix3 inertia;
  for (std::size_t i = points.begin; i < points.end; ++i) {
    if (body_of_point_[i] < 0) continue;
    const Vec3 r = unpadded(residual[i]);
    const Vec3 arm = positions[i] - center;
    force += r;
    torque += cross(arm, r);
    add_outer(inertia, -masses[i], arm, arm);
    for (int k = 0; k < 3; ++k) inertia(k, k) += masses[i] * squared_length(arm);
  }
  change.squared_velocity =
      (squared_length(force) / change.mass + std::max(0.0, dot(torque, inverse(inertia) * torque))) /
      change.mass;
  return change;
}

double LinearSystem::rigid_change(const parallel::Threads& threads, std::span<const simd::Padded3> residual,
                                  std::span<const Vec3> positions) {
  parallel::for_each(threads, bodies_.size(), 1,
                     [&](std::size_t b) { changes_[b] = rigid_change(bodies_[b], residual, positions); });
  RigidChange whole;
  for (const RigidChange& change : changes_) {
    whole.mass += change.mass;
    whole.squared_velocity = std::max(whole.squared_velocity, change.squared_velocity);
  }
  return std::sqrt(whole.mass * whole.squared_velocity);
}

void LinearSystem::update_preconditioner(const parallel::Threads& threads) {
  couplings_->order(threads, blocks_->row_of_point(), blocks_->row_count());
  const auto rows = blocks_->point_of_row();
  parallel::for_chunks(
      threads, blocks_->slice_count(), slice_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        const auto own = [&](auto&& list, std::size_t width) {
          return list.subspan(width * begin, width * (end - begin));
        };
        std::ranges::copy(own(blocks_->diagonal_blocks(), simd::slice_symmetric),
                          own(std::span(diagonal_), simd::slice_symmetric).begin());
        for (std::size_t row = simd::slice_rows * begin; row < std::min(simd::slice_rows * end, rows.size());
             ++row) {
          if (rows[row] < 0) continue;
          inverse_masses_[row] = 1.0F / blocks_->masses()[row];
          if (!couplings_->holds(rows[row])) continue;
          const SymmetricMatrix3 block = couplings_->diagonal_block(rows[row]);
          float* place =
              diagonal_.data() + simd::slice_symmetric * (row / simd::slice_rows) + row % simd::slice_rows;
          const std::array entries{block.xx, block.yy, block.zz, block.xy, block.xz, block.yz};
          for (std::size_t k = 0; k < 6; ++k) place[simd::slice_rows * k] += static_cast<float>(entries[k]);
        }
        simd::invert_slices(diagonal_.data(), inverse_diagonal_.data(), begin, end);
      });
}

void LinearSystem::multiply_exactly(const parallel::Threads& threads, std::span<const simd::Padded3> x,
                                    std::span<simd::Padded3> y) {
  couplings_->multiply(threads, x);
  add_blocks(threads, x, y, [&](Index point) { return couplings_->product(point); });
}

void LinearSystem::multiply_blocks_exactly(const parallel::Threads& threads, std::span<const simd::Padded3> x,
                                           std::span<simd::Padded3> y) {
  add_blocks(threads, x, y, [](Index) { return Vec3{}; });
}

/// y = B x, plus what `of_point` returns for a free point.
template <class OfPoint>
void LinearSystem::add_blocks(const parallel::Threads& threads, std::span<const simd::Padded3> x,
                              std::span<simd::Padded3> y, OfPoint&& of_point) {
  const auto products = blocks_->elements().multiply(threads, x);
  parallel::for_each(threads, size(), point_grain, [&](std::size_t i) {
    if (free_[i] == 0) {
      y[i] = {};
      return;
    }
    const double m = blocks_->diagonal()[i];
    Vec3 sum{m * x[i].x + products[i].x, m * x[i].y + products[i].y, m * x[i].z + products[i].z};
    sum += of_point(static_cast<Index>(i));
    y[i] = {sum.x, sum.y, sum.z, 0.0};
  });
}

double LinearSystem::multiply(const parallel::Threads& threads, std::span<const simd::Quad> x,
                              std::span<float> y) {
  couplings_->multiply(threads, x);
  const simd::SlicedRows blocks = blocks_->rows();
  const simd::CouplingRows couplings = couplings_->rows();
  parallel::for_chunks(threads, blocks_->slice_count(), slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         partial_[chunk] =
                             simd::multiply_slices(blocks, couplings, x.data(), y.data(), begin, end);
                       });
  double sum = 0.0;
  for (const double part : partial_) sum += part;
  return sum;
}

}  // namespace palpate::fem
