#include "fem/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr double long_ago = 1e-4;
constexpr std::size_t few_changes = 2;  // changes before there is an estimate of their rate
constexpr std::size_t usual_iterations = 1024;
constexpr std::size_t enough_iterations = 4;  // iterations before there is an estimate

void clear_lists(std::vector<double>& values, std::vector<double>& tails) {
  if (values.capacity() == 0) {
    values.reserve(usual_iterations);
    tails.reserve(usual_iterations);
  }
  values.clear();
  tails.clear();
}

}  // namespace

void ErrorEstimate::clear() {
  clear_lists(decreases_, tails_);
  error_ = std::numeric_limits<double>::infinity();
}

void ErrorEstimate::add(double decrease) {
  decreases_.push_back(decrease);
  tails_.push_back(0.0);
  for (double& tail : tails_) tail += decrease;
  if (decreases_.size() < enough_iterations) return;
  std::size_t first = decreases_.size() - 1;
  while (first > 0 && decrease > long_ago * tails_[first]) --first;
  double ratio = 1.0;
  for (std::size_t l = first; l < tails_.size(); ++l) ratio = std::max(ratio, tails_[l] / decreases_[l]);
  // Decreases oscillate, so use the largest of the last few.
  const std::size_t late = std::max(enough_iterations, decreases_.size() / 4);
  error_ = std::sqrt(
      ratio * *std::max_element(decreases_.end() - static_cast<std::ptrdiff_t>(late), decreases_.end()));
}

void ChangeEstimate::begin(std::size_t window) {
  window_ = window;
  clear_lists(sizes_, tails_);
  error_ = std::numeric_limits<double>::infinity();
}

void ChangeEstimate::add(double size) {
  constexpr double vanished = 1e-2;  // a smaller change gives no estimate of the convergence rate
  sizes_.push_back(size);
  tails_.push_back(0.0);
  for (double& tail : tails_) tail += size;
  if (sizes_.size() < std::max(few_changes, window_)) return;
  size = *std::max_element(sizes_.end() - static_cast<std::ptrdiff_t>(window_), sizes_.end());
  std::size_t first = sizes_.size() - 1;
  while (first > 0 && size > vanished * tails_[first]) --first;
  ratio_ = 1.0;
  for (std::size_t l = first; l < tails_.size(); ++l) ratio_ = std::max(ratio_, tails_[l] / sizes_[l]);
  error_ = ratio_ * size;
}

double ChangeEstimate::before(double size) const {
  return sizes_.size() < few_changes ? std::numeric_limits<double>::infinity() : ratio_ * size;
}

}  // namespace palpate::fem
