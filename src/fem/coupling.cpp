#include "fem/coupling.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t coupling_grain = 256;

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

void CouplingSystem::set(std::span<const Coupling> couplings, double time_step,
                         std::span<const std::uint8_t> free) {
  couplings_ = couplings;
  resize_with_room(terms_, couplings.size());
  resize_with_room(products_, couplings.size());
  begin_.assign(free.size() + 1, 0);
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    const Coupling& coupling = couplings[c];
    const SymmetricMatrix3 w = time_step * (coupling.damping + time_step * coupling.stiffness);
    terms_[c].weights = {w.xx, w.xy, w.xz, 0.0, w.xy, w.yy, w.yz, 0.0, w.xz, w.yz, w.zz, 0.0};
    for (std::size_t k = 0; k < 5; ++k) {
      const Index point = coupling.points[k];
      assert(point < static_cast<Index>(free.size()));
      terms_[c].coefficients[k] = point >= 0 ? coupling.coefficients[k] : 0.0;
      terms_[c].points[k] = std::max(point, 0);
      if (point >= 0 && at(free, point) != 0) ++at(begin_, point + 1);
    }
  }
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  next_.assign(begin_.begin(), begin_.end() - 1);
  resize_with_room(entries_, static_cast<std::size_t>(begin_.back()));
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    for (std::size_t k = 0; k < 5; ++k) {
      const Index point = couplings[c].points[k];
      if (point >= 0 && at(free, point) != 0)
        at(entries_, at(next_, point)++) = {static_cast<Index>(c), couplings[c].coefficients[k]};
    }
  }
}

void CouplingSystem::multiply(const parallel::Threads& threads, std::span<const simd::Padded3> x) {
  parallel::for_chunks(threads, couplings_.size(), coupling_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::coupling_products(terms_.data(), x.data(), products_.data(), begin, end);
                       });
}

simd::CouplingRows CouplingSystem::rows() const {
  return {.begin = begin_.data(), .entries = entries_.data(), .products = products_.data()};
}

std::span<const simd::CouplingEntry> CouplingSystem::entries(Index point) const {
  const Index first = at(begin_, point);
  return {entries_.data() + first, static_cast<std::size_t>(at(begin_, point + 1) - first)};
}

SymmetricMatrix3 CouplingSystem::weight(std::size_t coupling) const {
  const auto& w = terms_[coupling].weights;
  return {w[0], w[5], w[10], w[1], w[2], w[6]};
}

SymmetricMatrix3 CouplingSystem::diagonal_block(Index point) const {
  SymmetricMatrix3 sum;
  for (const simd::CouplingEntry& entry : entries(point)) {
    const double square = entry.coefficient * entry.coefficient;
    sum = sum + square * weight(static_cast<std::size_t>(entry.coupling));
  }
  return sum;
}

Vec3 CouplingSystem::start_force(Index point) const {
  Vec3 sum;
  for (const simd::CouplingEntry& entry : entries(point))
    sum += entry.coefficient * at(couplings_, entry.coupling).force;
  return sum;
}

}  // namespace palpate::fem
