#pragma once

#include <span>
#include <utility>
#include <vector>

#include <palpate/model.hpp>

#include "fem/coupling.hpp"

namespace palpate {

/// A grab and its force; point -1: released.
struct HeldGrab {
  Grab grab;
  Vec3 force{};  ///< over the last step, N
};

/// The springs that pull on points, by number; numbers of released grabs are reused.
class Grabs {
 public:
  explicit Grabs(Index point_count) : point_count_(point_count) {}

  /// Throw Error as Simulation's functions of the same names do.
  Index add(const Grab& grab);
  void move(Index number, const Vec3& target);
  void release(Index number);
  [[nodiscard]] const HeldGrab& held(Index number) const;

  /// Appends a coupling for each active grab, in order of their numbers: stiffness k and damping 2 sqrt(k m)
  /// in all directions, implicit in the solver.
  void append(std::span<const Vec3> positions, std::span<const double> masses,
              std::vector<fem::Coupling>& couplings) const;
  /// Copies the forces of the step.
  /// \param couplings  exactly those of append()
  void collect_forces(std::span<const fem::Coupling> couplings, double time_step,
                      std::span<const Vec3> velocities_end);

  /// All grabs by number, including released ones: part of the saved state.
  [[nodiscard]] const std::vector<HeldGrab>& all() const { return held_; }
  void set_all(std::vector<HeldGrab> held) { held_ = std::move(held); }

 private:
  void check(Index number) const;
  static void check_target(const Vec3& target);

  Index point_count_;
  std::vector<HeldGrab> held_;  ///< by number
};

}  // namespace palpate
