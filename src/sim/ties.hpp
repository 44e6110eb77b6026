#pragma once

#include <array>
#include <span>
#include <vector>

#include <palpate/model.hpp>

#include "fem/coupling.hpp"
#include "sim/holds.hpp"
#include "sim/response.hpp"

namespace palpate {

/// Ties with zero force at these positions (n_points x 3). Throws Error naming the tie: an index out of
/// range, a tet of the point's own body or without volume, a stiffness that is not a finite number > 0.
[[nodiscard]] std::vector<HeldTie> held_ties(const std::vector<Tie>& ties, const Bodies& bodies,
                                             std::span<const Vec3> positions);

/// Points with the bodies to which they are tied at least as stiffly as a contact would hold them, ascending.
/// What such ties hold together does not touch: contacts would only push against them.
[[nodiscard]] std::vector<std::array<Index, 2>> tied_points(const std::vector<HeldTie>& ties,
                                                            const Bodies& bodies,
                                                            const ContactResponse& response);

/// The springs that hold points of one body to tets of another.
class Ties {
 public:
  Ties() = default;
  /// \param masses    (n_points), kg
  /// \param moves     (n_points), 1 where a point can move
  /// \param response  ties without a stiffness get that of a contact between the two bodies
  Ties(const std::vector<HeldTie>& ties, const Bodies& bodies, std::span<const double> masses,
       std::span<const std::uint8_t> moves, const ContactResponse& response);

  /// Appends a coupling for each tie: stiffness k and the critical damping of the reduced mass, in all
  /// directions, implicit in the solver. O(ties).
  void append(std::span<const Vec3> positions, std::vector<fem::Coupling>& couplings) const;

 private:
  std::vector<fem::Coupling> couplings_;  ///< without force
};

}  // namespace palpate
