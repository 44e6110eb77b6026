#include "fem/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr double long_ago = 1e-4;

}  // namespace

void ErrorEstimate::clear(std::size_t enough) {
  enough_ = enough;
  constexpr std::size_t usual_iterations = 1024;
  if (decreases_.capacity() == 0) {
    decreases_.reserve(usual_iterations);
    tails_.reserve(usual_iterations);
  }
  decreases_.clear();
  tails_.clear();
  error_ = std::numeric_limits<double>::infinity();
}

void ErrorEstimate::add(double decrease) {
  decreases_.push_back(decrease);
  tails_.push_back(0.0);
  for (double& tail : tails_) tail += decrease;
  if (decreases_.size() < enough_) return;
  std::size_t first = decreases_.size() - 1;
  while (first > 0 && decrease > long_ago * tails_[first]) --first;
  ratio_ = 1.0;
  for (std::size_t l = first; l < tails_.size(); ++l) ratio_ = std::max(ratio_, tails_[l] / decreases_[l]);
  // Decreases go up and down on their way; the largest of late says more than the last.
  const std::size_t late = std::max(enough_, decreases_.size() / 4);
  error_ = std::sqrt(
      ratio_ * *std::max_element(decreases_.end() - static_cast<std::ptrdiff_t>(late), decreases_.end()));
}

void ErrorEstimate::look_ahead(double next_decrease) {
  constexpr double safety = 2.0;
  if (decreases_.size() >= enough_) error_ = std::sqrt(safety * ratio_ * next_decrease);
}

}  // namespace palpate::fem
