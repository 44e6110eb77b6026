#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "contact/cost_spread.hpp"

namespace palpate {

/// Linear cost model, seconds = a + b work: a fixed cost and a cost per unit, fitted to the last 32 samples.
/// The fitted line is then raised above all samples but the two highest, so that it is seldom too low. It is
/// raised by at most a factor of 1.5 over the median, so that samples during which the system suspended the
/// thread do not matter.
///
/// A cost per unit alone would not be enough: after samples with little work the unit cost seems high, and
/// then even less work would be planned.
class CostLine {
 public:
  /// \param units  assumed ratio of the fixed cost to the cost of a unit, while all samples have about the
  ///               same work
  explicit CostLine(double units) : units_(units) {}

  void add(double work, double seconds) {
    last_[next_++ % last_.size()] = {work, seconds};
    fit();
  }
  [[nodiscard]] bool known() const { return next_ > 0; }
  [[nodiscard]] double fixed() const { return fixed_; }  ///< s
  [[nodiscard]] double each() const { return each_; }    ///< s
  [[nodiscard]] double of(double work) const { return fixed_ + each_ * work; }
  /// The fitted line before it was raised.
  [[nodiscard]] double usual(double work) const { return of(work) / raised_; }

 private:
  struct Sample {
    double work = 0.0;
    double seconds = 0.0;
  };
  static constexpr std::size_t most = 32;

  /// Spread of the ratio of the cost of samples to an expectation.
  template <class Expected>
  [[nodiscard]] CostSpread ratios(std::size_t count, Expected&& expected) const {
    std::array<double, most> ratio{};
    for (std::size_t i = 0; i < count; ++i) ratio[i] = last_[i].seconds / expected(last_[i].work);
    return spread_of(std::span(ratio).first(count));
  }

  void fit() {
    constexpr double most_raised = 2.0;
    // Samples whose work differs by less do not determine the fixed cost.
    constexpr double alike = 0.05;
    const std::size_t count = std::min(next_, most);
    const auto n = static_cast<double>(count);
    const auto plain = [&](double work) { return work + units_; };
    const double middle = ratios(count, plain).middle;
    const double middle_seconds = ratios(count, [](double) { return 1.0; }).middle;
    double mean_work = 0.0;
    double mean_seconds = 0.0;
    const auto seconds = [&](const Sample& sample) {
      return std::min(sample.seconds, most_of_middle * std::max(middle * plain(sample.work), middle_seconds));
    };
    for (std::size_t i = 0; i < count; ++i) {
      mean_work += last_[i].work / n;
      mean_seconds += seconds(last_[i]) / n;
    }
    if (!(mean_seconds > 0.0)) return;
    // The line through the mean of the samples. The more similar their work, the closer is its fixed cost to
    // `units`.
    const double expected = mean_seconds / plain(mean_work);
    double square = alike * alike * plain(mean_work) * plain(mean_work);
    double product = square * expected;
    for (std::size_t i = 0; i < count; ++i) {
      const double work = last_[i].work - mean_work;
      square += work * work / n;
      product += work * (seconds(last_[i]) - mean_seconds) / n;
    }
    constexpr double least_each = 0.25;
    const double slope =
        std::clamp(product / square, least_each * expected, mean_seconds / std::max(mean_work, 1.0));
    const double base = mean_seconds - slope * mean_work;
    const CostSpread spread =
        ratios(count, [&](double work) { return std::max(base + slope * work, alike * mean_seconds); });
    raised_ = std::clamp(std::min(spread.high, most_of_middle * spread.middle), 1.0, most_raised);
    fixed_ = raised_ * std::max(0.0, base);
    each_ = raised_ * slope;
  }

  double units_;
  std::array<Sample, most> last_{};
  std::size_t next_ = 0;
  double raised_ = 1.0;
  double fixed_ = 0.0;
  double each_ = 0.0;
};

}  // namespace palpate
