#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <palpate/model.hpp>

#include "fem/linear_system.hpp"
#include "parallel/parallel.hpp"

namespace palpate::bench {

/// Times the product of a scene's matrix with a vector: the unit that the work of its steps is counted in.
///
/// The matrix is assembled from the elements at rest, without contacts; it is stored as in a simulation,
/// so that a product costs the same. Takes as much memory as the one of the simulation.
class ProductClock {
 public:
  /// \param model  checked by a Simulation before
  ProductClock(const Model& model, double time_step, int threads);
  /// Takes the time of some products.
  void run();
  /// Least time of a product so far, s; of one thread its processor time.
  [[nodiscard]] double seconds() const { return least_; }

 private:
  std::vector<std::uint8_t> free_;
  parallel::Threads threads_;
  fem::Elements elements_;
  fem::BlockMatrix matrix_;
  fem::CouplingSystem couplings_;
  fem::LinearSystem system_;
  simd::AlignedVector<simd::Quad> x_;
  simd::AlignedVector<float> y_;
  double least_ = std::numeric_limits<double>::infinity();
};

}  // namespace palpate::bench
