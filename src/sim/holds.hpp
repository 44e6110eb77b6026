#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

namespace palpate {

/// A tie and its position in the tet.
struct HeldTie {
  Tie tie{};
  std::array<double, 4>
      weights{};  ///< in the order of the corners; the position may be slightly outside the tet
};

/// Constraints of bodies and points that a ModelChange can change. Arrays have their full length.
struct Holds {
  std::vector<std::uint8_t> obstacles;     ///< (n_bodies) 1: rigid
  std::vector<std::uint8_t> absent;        ///< (n_bodies) 1: absent from the scene
  std::vector<std::uint8_t> fixed_points;  ///< (n_points)
  std::vector<std::uint8_t> fixed_axes;    ///< (n_points)
  std::vector<Index> motion_of_point;      ///< (n_points) the motion of each point, or -1
  std::vector<Vec3>
      prescribed_start;  ///< (n_points) positions of prescribed points before their motion is applied
  std::vector<HeldTie> ties;
};

/// The constraints of a model, without ties. Throws Error if the length of an array does not match the
/// bodies.
[[nodiscard]] Holds holds_of(const Model& model);

/// (n_bodies) 1: all points are fixed or prescribed, and nothing deforms.
[[nodiscard]] std::vector<std::uint8_t> rigid_bodies(const Holds& holds);
/// (n_bodies) 1: rigid, present, and without a motion.
[[nodiscard]] std::vector<std::uint8_t> bodies_at_rest(const Holds& holds, const Bodies& bodies);
/// (n_points) 1: fixed, prescribed, or part of an absent body.
[[nodiscard]] std::vector<std::uint8_t> constrained_points(const Holds& holds, const Bodies& bodies);
/// (n_points) the motion of each point, -1 for those of absent bodies.
[[nodiscard]] std::vector<Index> motions_of_present(const Holds& holds, const Bodies& bodies);
/// The detection settings, in which absent bodies have no contacts.
[[nodiscard]] DetectionSettings without_absent(DetectionSettings settings,
                                               std::span<const std::uint8_t> absent);

/// The constraints of a simulation, which a ModelChange changes.
struct HeldModel {
  Holds holds;
  std::vector<Motion> motions;
};

/// Applies a change, without its loads. Throws Error on an index out of range, and for impossible changes:
/// inserting a present body, removing an absent one, constraining points of an absent one.
/// \param positions  (n_points x 3) now
void apply_change(const ModelChange& change, const Bodies& bodies, std::span<const Vec3> positions,
                  HeldModel& held);

}  // namespace palpate
