#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include <palpate/settings.hpp>

namespace palpate {

/// The remaining budget of one detection. A query checks before each chunk of work whether it may continue.
///
/// A budget in tests is deterministic: queries subtract the number of tests that they made. A budget in time
/// reads the clock. It also reserves time for the later work that each pair found causes: `seconds_per_find`
/// for each.
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

  /// Sets the reserve from now on: `seconds` for each pair found, and a fixed time.
  void keep_back(double seconds, double seconds_per_find) {
    kept_back_ = seconds;
    seconds_per_find_ = seconds_per_find;
    finds_.store(0);
  }
  /// Adds the pairs found by a chunk. Call once for each chunk, from any thread.
  void add_finds(std::size_t finds) { finds_.fetch_add(finds, std::memory_order_relaxed); }
  /// Whether another chunk may begin if this fraction of the budget may be used.
  [[nodiscard]] bool time_left(double fraction) const {
    const auto finds = static_cast<double>(finds_.load(std::memory_order_relaxed));
    return kept_back_ + seconds_per_find_ * finds < seconds_left(fraction);
  }
  /// Time that is left of a fraction of the budget; reserves are not subtracted.
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
