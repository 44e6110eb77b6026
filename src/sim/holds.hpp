#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

namespace palpate {

/// A tie, and where in its tet it acts.
struct HeldTie {
  Tie tie{};
  std::array<double, 4> weights{};  ///< in the order of the corners; also outside of the tet
};

/// Constraints of bodies and points, apart from the motions (ModelChange). Each array has its full length.
struct Holds {
  std::vector<std::uint8_t> obstacles;     ///< (n_bodies) 1: rigid
  std::vector<std::uint8_t> absent;        ///< (n_bodies) 1: not there
  std::vector<std::uint8_t> fixed_points;  ///< (n_points)
  std::vector<std::uint8_t> fixed_axes;    ///< (n_points)
  std::vector<Index> motion_of_point;      ///< (n_points) or -1
  std::vector<Vec3> prescribed_start;      ///< (n_points) where prescribed points are without their motion
  std::vector<HeldTie> ties;
};

/// Those of a model, without ties. Throws Error on arrays of another length than the bodies have.
[[nodiscard]] Holds holds_of(const Model& model);

/// (n_bodies) 1: all points are fixed or prescribed, and nothing deforms.
[[nodiscard]] std::vector<std::uint8_t> rigid_bodies(const Holds& holds);
/// (n_points) 1: fixed, prescribed, or of an absent body.
[[nodiscard]] std::vector<std::uint8_t> unfree_points(const Holds& holds, const Bodies& bodies);
/// (n_points) the motion of each point, -1 for those of absent bodies.
[[nodiscard]] std::vector<Index> motions_of_present(const Holds& holds, const Bodies& bodies);
/// Settings by which absent bodies touch nothing.
[[nodiscard]] DetectionSettings without_absent(DetectionSettings settings,
                                               std::span<const std::uint8_t> absent);

/// What a simulation is held by, to be changed.
struct HeldModel {
  Holds holds;
  std::vector<Motion> motions;
};

/// Changes it, but for loads. Throws Error on an index out of range, and where ModelChange asks for what is
/// no change: a body inserted that is there, one removed that is not, points of an absent body held.
/// \param positions  (n_points x 3) now
void apply_change(const ModelChange& change, const Bodies& bodies, std::span<const Vec3> positions,
                  HeldModel& held);

}  // namespace palpate
