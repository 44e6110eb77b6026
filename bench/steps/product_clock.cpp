#include "steps/product_clock.hpp"

#include <algorithm>

#include "fem/lumping.hpp"
#include "sim/model_check.hpp"
#include "steps/clock.hpp"

namespace palpate::bench {
namespace {

Materials materials_of(const Model& model) {
  return {model.materials, model.material_of_tet};
}

std::vector<std::uint8_t> free_points(const Model& model) {
  std::vector<std::uint8_t> free = constrained_points(model);
  const std::vector<std::uint8_t> rigid = rigid_bodies(model);
  const std::vector<double> masses = fem::lumped_masses(model.bodies, materials_of(model));
  for (std::size_t p = 0; p < free.size(); ++p) {
    const bool held = free[p] != 0 || rigid[static_cast<std::size_t>(model.bodies.body_of_point()[p])] != 0;
    free[p] = held || masses[p] == 0.0 ? 0 : 1;
  }
  return free;
}

}  // namespace

ProductClock::ProductClock(const Model& model, double time_step, int threads)
    : free_(free_points(model)),
      threads_(threads),
      elements_(model.bodies, materials_of(model), rigid_bodies(model)),
      matrix_(elements_, free_),
      system_(matrix_, couplings_, free_),
      x_(matrix_.row_count(), simd::Quad{}),
      y_(simd::slice_values * matrix_.slice_count(), 0.0F) {
  elements_.set_factors(
      std::vector<double>(static_cast<std::size_t>(elements_.size()), time_step * time_step));
  elements_.update(threads_, model.bodies.points_rest());
  std::vector<double> masses = fem::lumped_masses(model.bodies, materials_of(model));
  for (double& mass : masses) mass = std::max(mass, 1e-12);
  matrix_.assemble(threads_, masses);
  couplings_.set(parallel::Threads(1), {}, time_step, free_);
  system_.update_preconditioner(threads_);
  // 1 where there is a row: products of zeros would cost the same, but those of tiny numbers more.
  for (const Index row : matrix_.row_of_point())
    if (row >= 0) x_[static_cast<std::size_t>(row)] = {1.0F, 1.0F, 1.0F, 0.0F};
}

void ProductClock::run() {
  constexpr int some = 5;
  for (int i = 0; i < some; ++i) {
    const Clock clock(threads_.count());
    system_.multiply(threads_, x_, y_);
    least_ = std::min(least_, clock.seconds());
  }
}

}  // namespace palpate::bench
