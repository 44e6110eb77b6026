#include "fem/coupling.hpp"

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

void CouplingSystem::set(std::span<const Coupling> couplings, double time_step, Index point_count) {
  couplings_ = couplings;
  resize_with_room(weights_, couplings.size());
  resize_with_room(products_, couplings.size());
  begin_.assign(static_cast<std::size_t>(point_count) + 1, 0);
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    weights_[c] = time_step * (couplings[c].damping + time_step * couplings[c].stiffness);
    for (const Index point : couplings[c].points) {
      assert(point < point_count);
      if (point >= 0) ++at(begin_, point + 1);
    }
  }
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  next_.assign(begin_.begin(), begin_.end() - 1);
  resize_with_room(entries_, static_cast<std::size_t>(begin_.back()));
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    for (std::size_t k = 0; k < 5; ++k) {
      const Index point = couplings[c].points[k];
      if (point >= 0)
        at(entries_, at(next_, point)++) = {static_cast<Index>(c), couplings[c].coefficients[k]};
    }
  }
}

void CouplingSystem::multiply(const parallel::Threads& threads, std::span<const Vec3> x) {
  parallel::for_each(threads, couplings_.size(), coupling_grain,
                     [&](std::size_t c) { products_[c] = weights_[c] * relative(couplings_[c], x); });
}

std::span<const CouplingSystem::Entry> CouplingSystem::entries(Index point) const {
  const Index first = at(begin_, point);
  return {entries_.data() + first, static_cast<std::size_t>(at(begin_, point + 1) - first)};
}

Vec3 CouplingSystem::row_product(Index point) const {
  Vec3 sum;
  for (const Entry& entry : entries(point)) sum += entry.coefficient * at(products_, entry.coupling);
  return sum;
}

SymmetricMatrix3 CouplingSystem::diagonal_block(Index point) const {
  SymmetricMatrix3 sum;
  for (const Entry& entry : entries(point)) {
    sum = sum + (entry.coefficient * entry.coefficient) * at(weights_, entry.coupling);
  }
  return sum;
}

Vec3 CouplingSystem::start_force(Index point) const {
  Vec3 sum;
  for (const Entry& entry : entries(point)) sum += entry.coefficient * at(couplings_, entry.coupling).force;
  return sum;
}

}  // namespace palpate::fem
