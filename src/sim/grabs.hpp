#pragma once

#include <span>
#include <vector>

#include <palpate/model.hpp>

#include "fem/coupling.hpp"

namespace palpate {

/// The springs that pull on points, by number; numbers of released grabs are used again.
class Grabs {
 public:
  explicit Grabs(Index point_count) : point_count_(point_count) {}

  /// Throw Error as Simulation's functions of the same names say.
  Index add(const Grab& grab);
  void move(Index number, const Vec3& target);
  void release(Index number);
  /// Force over the last step, N.
  [[nodiscard]] Vec3 force(Index number) const;

  /// Appends a coupling for each grab that is held, in order of their numbers: stiffness k and damping 2
  /// sqrt(k m) in all directions, implicit in the solver.
  void append(std::span<const Vec3> positions, std::span<const double> masses,
              std::vector<fem::Coupling>& couplings) const;
  /// Takes the forces of the step from the couplings that append() appended (only those).
  void take_forces(std::span<const fem::Coupling> couplings, double time_step,
                   std::span<const Vec3> velocities_end);

 private:
  struct Held {
    Grab grab;
    Vec3 force{};
  };
  void check(Index number) const;
  static void check_target(const Vec3& target);

  Index point_count_;
  std::vector<Held> held_;  ///< by number; point -1: released
};

}  // namespace palpate
