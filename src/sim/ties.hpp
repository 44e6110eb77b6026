#pragma once

#include <span>
#include <vector>

#include <palpate/model.hpp>

#include "fem/coupling.hpp"
#include "sim/response.hpp"

namespace palpate {

/// The springs that hold points of one body to tets of another.
class Ties {
 public:
  Ties() = default;
  /// \param start     (n_points) positions that all ties are at rest at
  /// \param masses    (n_points), kg
  /// \param moves     (n_points), 1 where a point can move
  /// \param response  gives ties without a stiffness that of a contact between the two bodies
  /// Throws Error naming the tie: an index out of range, a tet of the point's own body or without volume, a
  /// stiffness that is not a finite number > 0.
  Ties(const std::vector<Tie>& ties, const Bodies& bodies, std::span<const Vec3> start,
       std::span<const double> masses, std::span<const std::uint8_t> moves, const ContactResponse& response);

  /// Appends a coupling for each tie: stiffness k and the critical damping of the reduced mass, in all
  /// directions, implicit in the solver. O(ties).
  void append(std::span<const Vec3> positions, std::vector<fem::Coupling>& couplings) const;

 private:
  std::vector<fem::Coupling> couplings_;  ///< without force
};

}  // namespace palpate
