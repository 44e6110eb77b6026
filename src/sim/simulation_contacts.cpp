// Where the contacts of a step are computed.
#include <algorithm>

#include "contact/detector_steps.hpp"
#include "geometry/vector.hpp"
#include "sim/simulation_state.hpp"

namespace palpate {

/// Whether contacts of a body are computed where its frame rotates it. Not for larger angles, since there the
/// motion without contact forces says little.
bool Simulation::State::rotates(Index body) const {
  constexpr double most = 0.1;  // rad
  const double angle = dynamics.frame_angle(body);
  return angle > 0.0 && angle <= most;
}

/// Whether such a body touches another.
bool Simulation::State::rotates_in_contact() const {
  if (!dynamics.has_frames()) return false;
  const Contacts& contacts = detector.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c)
    if (rotates(contacts.body[c]) || rotates(at(bodies.body_of_point(), contacts.point[c]))) return true;
  return false;
}

/// Rotates bodies with their frames, and moves them so that the depths of their contacts change least.
void Simulation::State::find_places() {
  constexpr double weak = 0.01;  // of all contacts: a direction of fewer does not count
  const Contacts& contacts = detector.contacts();
  touched.assign(bodies.bodies().size(), {});
  const auto add = [&](Index body, const Vec3& r, const Vec3& displacement) {
    fem::add_outer(at(touched, body).directions, 1.0, r, r);
    at(touched, body).deeper += dot(r, displacement) * r;
  };
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Vec3& r = contacts.direction[c];
    const Index point = contacts.point[c];
    add(at(bodies.body_of_point(), point), r, dynamics.frame_displacement(point));
    Vec3 displacement;
    for (std::size_t k = 0; k < 4; ++k) {
      displacement +=
          contacts.weights[c][k] * dynamics.frame_displacement(at(bodies.tets(), contacts.tet[c])[k]);
    }
    add(contacts.body[c], r, displacement);
  }
  places.assign(dynamics.positions().begin(), dynamics.positions().end());
  for (Index body = 0; body < bodies.body_count(); ++body) {
    auto& [directions, deeper] = at(touched, body);
    if (!rotates(body)) continue;
    Vec3 path;
    if (const double sum = trace(directions); sum > 0.0) {
      for (int k = 0; k < 3; ++k) directions(k, k) += weak * sum;
      path = -(inverse(directions) * deeper);
    }
    const Range points = at(bodies.bodies(), body).points;
    for (Index i = points.begin; i < points.end; ++i) at(places, i) += dynamics.frame_displacement(i) + path;
  }
}

/// Whether all contacts of rotated bodies are shallow at these positions. If not, they would lead out on
/// another side, or act before the bodies meet.
bool Simulation::State::places_are_shallow() const {
  constexpr double most = 0.25;  // of the thickness there
  const Contacts& contacts = detector.contacts();
  const LocalThickness& thickness = swept.thickness();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Index point = contacts.point[c];
    if (!rotates(at(bodies.body_of_point(), point)) && !rotates(contacts.body[c])) continue;
    const double least = std::min(at(thickness.of_point, point), thickness.of_contact(bodies, contacts, c));
    if (contacts.depth[c] > most * least) return false;
  }
  return true;
}

/// Returns the positions at which the contacts of the step are computed. Where the step is solved in rotated
/// frames, forces act at arms in the rotated bodies, so their directions must be those of the surfaces there:
/// with those of the start, a ball in a socket would drive itself. So if such bodies touch others, contacts
/// are searched for there. They may differ from those at the start.
std::span<const Vec3> Simulation::State::find_contacts() {
  progress.searched = can_predict() && rotates_in_contact();
  if (!progress.searched) return dynamics.positions();
  find_places();
  detect(places, false);
  ++metrics.detections;
  if (places_are_shallow()) return places;
  progress.searched = false;
  DetectorSteps::swap_back(detector);
  DetectorSteps::hold(detector);
  return dynamics.positions();
}

}  // namespace palpate
