#include "fem/coupling.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "room.hpp"
#include "simd/gauss_seidel.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t coupling_grain = 256;
constexpr std::size_t coupled_point_grain = 1024;

}  // namespace

Vec3 relative(const Coupling& coupling, std::span<const Vec3> values) {
  Vec3 sum;
  for (std::size_t k = 0; k < 5; ++k) {
    if (coupling.points[k] >= 0) sum += coupling.coefficients[k] * at(values, coupling.points[k]);
  }
  return sum;
}

Vec3 end_force(const Coupling& coupling, double time_step, std::span<const Vec3> velocities_end) {
  const SymmetricMatrix3 resistance = coupling.damping + time_step * coupling.stiffness;
  return coupling.force - resistance * relative(coupling, velocities_end);
}

/// Copies the stencils. Returns whether they have changed.
bool CouplingSystem::copy_stencils(const parallel::Threads& threads) {
  const bool as_many = stencils_.size() == couplings_.size();
  resize_with_room(stencils_, couplings_.size());
  assign_with_room(changed_, parallel::chunk_count(stencils_.size(), coupling_grain), std::uint8_t{0});
  parallel::for_chunks(threads, stencils_.size(), coupling_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         for (std::size_t c = begin; c < end; ++c) {
                           const Stencil now{couplings_[c].points, couplings_[c].coefficients};
                           if (as_many && now == stencils_[c]) continue;
                           stencils_[c] = now;
                           changed_[chunk] = 1;
                         }
                       });
  return !as_many || std::ranges::find(changed_, 1) != changed_.end();
}

/// Lists the couplings of each free point.
void CouplingSystem::list_entries(std::span<const std::uint8_t> free) {
  begin_.assign(free.size() + 1, 0);
  for (const Stencil& stencil : stencils_) {
    for (const Index point : stencil.points) {
      assert(point < static_cast<Index>(free.size()));
      if (point >= 0 && at(free, point) != 0) ++at(begin_, point + 1);
    }
  }
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  next_.assign(begin_.begin(), begin_.end() - 1);
  resize_with_room(entries_, static_cast<std::size_t>(begin_.back()));
  for (std::size_t c = 0; c < stencils_.size(); ++c) {
    for (std::size_t k = 0; k < 5; ++k) {
      const Index point = stencils_[c].points[k];
      if (point >= 0 && at(free, point) != 0)
        at(entries_, at(next_, point)++) = {static_cast<Index>(c), stencils_[c].coefficients[k]};
    }
  }
}

void CouplingSystem::set(const parallel::Threads& threads, std::span<const Coupling> couplings,
                         double time_step, std::span<const std::uint8_t> free) {
  couplings_ = couplings;
  if (copy_stencils(threads) || !is_listed_) {
    is_listed_ = is_ordered_ = false;
    list_entries(free);
    is_listed_ = true;
  }
  resize_with_room(weights_, couplings.size());
  resize_with_room(products_, couplings.size());
  parallel::for_each(threads, couplings.size(), coupling_grain, [&](std::size_t c) {
    weights_[c] = time_step * (couplings[c].damping + time_step * couplings[c].stiffness);
  });
}

void CouplingSystem::multiply(const parallel::Threads& threads, std::span<const simd::Padded3> x) {
  parallel::for_each(threads, couplings_.size(), coupling_grain, [&](std::size_t c) {
    const Coupling& coupling = couplings_[c];
    Vec3 sum;
    for (std::size_t k = 0; k < 5; ++k) {
      if (coupling.points[k] < 0) continue;
      const simd::Padded3& row = at(x, coupling.points[k]);
      sum += coupling.coefficients[k] * Vec3{row.x, row.y, row.z};
    }
    products_[c] = weights_[c] * sum;
  });
}

Vec3 CouplingSystem::product(Index point) const {
  Vec3 sum;
  for (const Entry& entry : entries(point)) sum += entry.coefficient * at(products_, entry.coupling);
  return sum;
}

/// Puts what does not depend on values into the order of rows.
void CouplingSystem::order_entries(const parallel::Threads& threads, std::span<const Index> row_of_point,
                                   std::size_t row_count) {
  resize_with_room(terms_, stencils_.size());
  resize_with_room(row_products_, stencils_.size());
  parallel::for_each(threads, stencils_.size(), coupling_grain, [&](std::size_t c) {
    for (std::size_t k = 0; k < 5; ++k) {
      const Index point = stencils_[c].points[k];
      const Index row = point >= 0 ? at(row_of_point, point) : -1;
      terms_[c].coefficients[k] = row >= 0 ? static_cast<float>(stencils_[c].coefficients[k]) : 0.0F;
      terms_[c].rows[k] = std::max(row, 0);
    }
  });
  assign_with_room(row_begin_, row_count + 1, 0);
  for (std::size_t point = 0; point < row_of_point.size(); ++point) {
    if (row_of_point[point] >= 0) at(row_begin_, row_of_point[point] + 1) = begin_[point + 1] - begin_[point];
  }
  for (std::size_t row = 0; row < row_count; ++row) row_begin_[row + 1] += row_begin_[row];
  resize_with_room(row_entries_, entries_.size());
  parallel::for_each(threads, row_of_point.size(), coupled_point_grain, [&](std::size_t point) {
    if (row_of_point[point] < 0) return;
    Index next = at(row_begin_, row_of_point[point]);
    for (const Entry& entry : entries(static_cast<Index>(point)))
      at(row_entries_, next++) = {entry.coupling, static_cast<float>(entry.coefficient)};
  });
  is_ordered_ = true;
}

void CouplingSystem::order(const parallel::Threads& threads, std::span<const Index> row_of_point,
                           std::size_t row_count) {
  if (!is_ordered_) order_entries(threads, row_of_point, row_count);
  parallel::for_each(threads, couplings_.size(), coupling_grain, [&](std::size_t c) {
    const SymmetricMatrix3& w = weights_[c];
    const auto column = [&](std::size_t k, double x, double y, double z) {
      terms_[c].weights[4 * k] = static_cast<float>(x);
      terms_[c].weights[4 * k + 1] = static_cast<float>(y);
      terms_[c].weights[4 * k + 2] = static_cast<float>(z);
    };
    column(0, w.xx, w.xy, w.xz);
    column(1, w.xy, w.yy, w.yz);
    column(2, w.xz, w.yz, w.zz);
  });
}

void CouplingSystem::multiply(const parallel::Threads& threads, std::span<const simd::Quad> x) {
  parallel::for_chunks(threads, couplings_.size(), coupling_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::coupling_products(terms_.data(), x.data(), row_products_.data(), begin, end);
                       });
}

void CouplingSystem::multiply_listed(const parallel::Threads& threads, std::span<const simd::Quad> x,
                                     std::span<const std::uint32_t> list) {
  parallel::for_chunks(threads, list.size(), coupling_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::listed_products(terms_.data(), x.data(), row_products_.data(),
                                               list.data() + begin, end - begin);
                       });
}

simd::CouplingRows CouplingSystem::rows() const {
  return {.begin = row_begin_.data(), .entries = row_entries_.data(), .products = row_products_.data()};
}

std::span<const CouplingSystem::Entry> CouplingSystem::entries(Index point) const {
  const Index first = at(begin_, point);
  return {entries_.data() + first, static_cast<std::size_t>(at(begin_, point + 1) - first)};
}

SymmetricMatrix3 CouplingSystem::weight(std::size_t coupling) const {
  return weights_[coupling];
}

SymmetricMatrix3 CouplingSystem::diagonal_block(Index point) const {
  SymmetricMatrix3 sum;
  for (const Entry& entry : entries(point)) {
    const double square = entry.coefficient * entry.coefficient;
    sum = sum + square * weight(static_cast<std::size_t>(entry.coupling));
  }
  return sum;
}

Vec3 CouplingSystem::added(Vec3 start, Index point, std::span<const Vec3> values, std::size_t first) const {
  for (const Entry& entry : entries(point)) {
    const auto coupling = static_cast<std::size_t>(entry.coupling);
    if (coupling >= first) start += entry.coefficient * values[coupling - first];
  }
  return start;
}

Vec3 CouplingSystem::start_force(Index point) const {
  Vec3 sum;
  for (const Entry& entry : entries(point)) sum += entry.coefficient * at(couplings_, entry.coupling).force;
  return sum;
}

}  // namespace palpate::fem
