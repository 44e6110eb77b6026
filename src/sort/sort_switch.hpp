#pragma once

#include <cstddef>

namespace palpate {

/// The switch of the paper (5, "Parallel sorting"): repair while few references change their cell, a full
/// sort while many do. Two thresholds (hysteresis), so that a fraction near one of them does not switch in
/// each frame. The paper uses the last frames; here the movers of this frame are known before the sort.
class SortSwitch {
 public:
  /// Fractions of movers at which repair costs as much as a full sort, and at which it is clearly cheaper;
  /// measured (docs/benchmarks-sorts.md, "The switch").
  static constexpr double upper_fraction = 0.14;
  static constexpr double lower_fraction = 0.10;

  /// Whether to repair a frame with `movers` changes among `words`.
  bool repairs(std::size_t movers, std::size_t words);
  /// The result of the last repairs(): the state of the switch.
  [[nodiscard]] bool repairing() const { return repairing_; }
  void set_repairing(bool repairing) { repairing_ = repairing; }

 private:
  bool repairing_ = true;
};

}  // namespace palpate
