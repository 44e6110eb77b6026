#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include <palpate/settings.hpp>

namespace palpate {

/// The remaining budget of one detection. Queries check before each chunk whether they may continue.
///
/// A budget in tests is deterministic: queries spend the number of tests that they made. A budget in time
/// reads the clock, and reserves time for the work that each find causes later: `seconds_per_find` for each.
class Allowance {
 public:
  using Clock = std::chrono::steady_clock;

  /// An allowance of tests, or of seconds from now on.
  static Allowance of_tests(std::uint64_t tests) {
    Allowance allowance;
    allowance.tests_ = tests;
    return allowance;
  }
  static Allowance of_seconds(double seconds) {
    Allowance allowance;
    allowance.seconds_ = seconds;
    return allowance;
  }
  Allowance() = default;
  Allowance(const Allowance& other)
      : start_(other.start_), seconds_(other.seconds_), tests_(other.tests_), kept_back_(other.kept_back_) {}
  Allowance& operator=(const Allowance& other) {
    start_ = other.start_;
    seconds_ = other.seconds_;
    tests_ = other.tests_;
    kept_back_ = other.kept_back_;
    finds_.store(0);
    return *this;
  }

  [[nodiscard]] bool timed() const { return seconds_.has_value(); }

  /// From now on, reserves `seconds` for each find, and a fixed time.
  void keep_back(double seconds, double seconds_per_find) {
    kept_back_ = seconds;
    seconds_per_find_ = seconds_per_find;
    finds_.store(0);
  }
  /// Counts the finds of a chunk. Call once for each chunk, from any thread.
  void add_finds(std::size_t finds) { finds_.fetch_add(finds, std::memory_order_relaxed); }
  /// Whether a chunk may begin, when this fraction of the budget may be spent.
  [[nodiscard]] bool time_left(double fraction) const {
    const auto finds = static_cast<double>(finds_.load(std::memory_order_relaxed));
    return kept_back_ + seconds_per_find_ * finds < seconds_left(fraction);
  }
  /// Time left of a fraction of the budget, without regard to reserves.
  [[nodiscard]] double seconds_left(double fraction) const {
    const double spent = std::chrono::duration<double>(Clock::now() - start_).count();
    return fraction * seconds_.value_or(std::numeric_limits<double>::infinity()) - spent;
  }

  [[nodiscard]] std::uint64_t tests() const { return tests_; }
  void grant(std::uint64_t tests) { tests_ += tests; }
  void spend(std::uint64_t tests) { tests_ -= tests < tests_ ? tests : tests_; }

 private:
  Clock::time_point start_ = Clock::now();
  std::optional<double> seconds_;
  std::uint64_t tests_ = std::numeric_limits<std::uint64_t>::max();
  double kept_back_ = 0.0;
  double seconds_per_find_ = 0.0;
  std::atomic<std::size_t> finds_{0};
};

}  // namespace palpate
