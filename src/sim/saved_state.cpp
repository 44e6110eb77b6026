#include "sim/saved_state.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "geometry/vector.hpp"
#include "number_text.hpp"
#include "sim/state_hash.hpp"

namespace palpate {

// serialize() of the data of fingerprints; the archive finds these functions by argument-dependent lookup.

template <class Archive>
void serialize(Archive& archive, Fibres& f) {
  archive(f.direction, f.stiffness, f.exponent, f.active_stress, f.activation);
}

template <class Archive>
void serialize(Archive& archive, Viscosity& v) {
  archive(v.fractions, v.times);
}

template <class Archive>
void serialize(Archive& archive, Material& m) {
  archive(m.young_modulus, m.poisson_ratio, m.density, m.mass_damping, m.stiffness_damping, m.plastic_yield,
          m.plastic_creep, m.plastic_maximum, m.model, m.mooney_fraction, m.elements, m.fibres, m.viscosity);
}

template <class Archive>
void serialize(Archive& archive, InterestRegion& region) {
  archive(region.center, region.radius);
}

template <class Archive>
void serialize(Archive& archive, Budget& budget) {
  archive(budget.tests, budget.milliseconds, budget.region);
}

template <class Archive>
void serialize(Archive& archive, SimulationSettings& s) {
  archive(s.time_step, s.time_integration, s.gravity, s.detection.cells_per_primitive,
          s.detection.self_collision, s.detection.budget, s.detection.ignored_pairs,
          s.detection.edge_contacts, s.detection.continuous);
  archive(s.response.stiffness, s.response.damping, s.response.friction);
  archive(s.solver.tolerance, s.solver.tolerance_of, s.solver.preconditioner, s.solver.max_iterations,
          s.solver.fixed_iterations, s.solver.max_solves, s.solver.max_substeps);
  archive(s.rest.speed, s.rest.time, s.limits.max_speed, s.limits.inverted_time);
}

namespace {

constexpr const char* saved_state_name = "saved state";

/// Works on copies, since an archive takes non-const references.
template <class... Parts>
std::uint64_t hash_of(Parts... parts) {
  ArchiveWriter writer;
  (writer(parts), ...);
  return fnv1a(writer.take());
}

template <class T>
std::vector<T> copy_of(std::span<const T> values) {
  return {values.begin(), values.end()};
}

void check_length(const char* name, std::size_t found, std::size_t expected) {
  if (found != expected)
    throw Error(saved_state_name, name, std::to_string(found) + " values", std::to_string(expected));
}

void check_finite(const char* name, const Vec3& value) {
  if (!is_finite(value))
    throw Error(saved_state_name, name, "a number that is not finite", "three finite numbers");
}

void check_index(const char* name, Index found, Index low, std::size_t count) {
  if (found < low || (found >= 0 && static_cast<std::size_t>(found) >= count)) {
    throw Error(saved_state_name, name, std::to_string(found),
                std::to_string(low) + " to " + std::to_string(static_cast<std::int64_t>(count) - 1));
  }
}

void check_contacts(const ContactHistory& contacts, const Bodies& bodies) {
  const std::size_t n = contacts.point.size();
  const ContactStates& states = contacts.states;
  check_length("contact.body", contacts.body.size(), n);
  std::apply([&](const auto&... column) { (check_length("contacts", column.size(), n), ...); },
             states.columns());
  std::pair<Index, Index> last(-1, -1);
  for (std::size_t c = 0; c < n; ++c) {
    const std::pair key(contacts.point[c], contacts.body[c]);
    check_index("contact.point", key.first, 0, bodies.points_rest().size());
    check_index("contact.body", key.second, 0, bodies.bodies().size());
    if (key <= last) {
      throw Error(saved_state_name, "contacts", "contacts that are not sorted",
                  "contacts sorted by point, then body");
    }
    last = key;
    for (const Vec3& vector : {states.slip[c], states.force[c], states.direction[c], states.velocity[c]})
      check_finite("contact", vector);
    check_finite("contact", {states.stiffness[c], states.chatter_damping[c], 0.0});
  }
}

void check_kept(const std::vector<KeptContact>& contacts, const Bodies& bodies) {
  for (const KeptContact& c : contacts) {
    check_index("kept contact.point", c.point, 0, bodies.points_rest().size());
    check_index("kept contact.body", c.body, 0, bodies.bodies().size());
    check_index("kept contact.tet", c.tet, 0, bodies.tets().size());
    check_finite("kept contact", {c.distances[0], c.distances[1], c.distances[2]});
    check_finite("kept contact", {c.distances[3], c.foot[0], c.foot[1]});
    check_finite("kept contact", {c.foot[2], c.foot[3], c.stiffness});
  }
}

void check_ends(const std::vector<EdgeEnd>& ends, const Bodies& bodies) {
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const EdgeEnd& e = ends[i];
    check_index("end of edge.edge", e.edge, 0, bodies.edges().size());
    check_index("end of edge.body", e.body, 0, bodies.bodies().size());
    for (const Index point : e.points) check_index("end of edge", point, 0, bodies.points_rest().size());
    for (const Vec3& vector : {e.law.slip, e.law.direction, e.velocity}) check_finite("end of edge", vector);
    check_finite("end of edge", {e.coefficients[0], e.coefficients[1], e.coefficients[2]});
    check_finite("end of edge", {e.coefficients[3], e.coefficients[4], e.law.depth});
    check_finite("end of edge", {e.law.stiffness, e.chatter_damping, 0.0});
    if (i > 0 && e.key() <= ends[i - 1].key()) {
      throw Error(saved_state_name, "ends of edges", "ends that are not sorted",
                  "ends sorted by edge, body and end");
    }
  }
}

void check_acting(const std::vector<ActedContact>& contacts, const Bodies& bodies) {
  for (const ActedContact& c : contacts) {
    for (const Index point : std::span(c.points).first(c.of_edge ? c.all_points() : c.points.size()))
      check_index("acting contact", point, 0, bodies.points_rest().size());
    if (tet_of(c, bodies) < 0) {
      throw Error(saved_state_name, "acting contact", "points that are not the corners of a tet",
                  "the corners of a tet");
    }
    for (const Vec3& vector : {c.direction, c.force}) check_finite("acting contact", vector);
    check_finite("acting contact", {c.coefficients[0], c.coefficients[1], c.coefficients[2]});
    check_finite("acting contact", {c.coefficients[3], c.coefficients[4], c.depth});
  }
}

void check_loads(const ChangedModel& changed, const Bodies& bodies) {
  for (const PointLoad& load : changed.point_loads)
    for (const Index point : load.points) check_index("load", point, 0, bodies.points_rest().size());
  for (const SurfaceLoad& load : changed.surface_loads)
    for (const Index triangle : load.triangles) check_index("load", triangle, 0, bodies.triangles().size());
}

void check_holds(const Holds& holds, std::size_t motions, const Bodies& bodies) {
  const std::size_t points = bodies.points_rest().size();
  check_length("obstacles", holds.obstacles.size(), bodies.bodies().size());
  check_length("absent", holds.absent.size(), bodies.bodies().size());
  check_length("fixed_points", holds.fixed_points.size(), points);
  check_length("fixed_axes", holds.fixed_axes.size(), points);
  check_length("motion_of_point", holds.motion_of_point.size(), points);
  check_length("rail_start", holds.prescribed_start.size(), points);
  for (const Index motion : holds.motion_of_point) check_index("motion_of_point", motion, -1, motions);
  for (const Vec3& start : holds.prescribed_start) check_finite("rail_start", start);
  for (const HeldTie& held : holds.ties) {
    check_index("tie.point", held.tie.point, 0, points);
    check_index("tie.tet", held.tie.tet, 0, bodies.tets().size());
    check_finite("tie", {held.weights[0], held.weights[1], held.weights[2]});
    check_finite("tie", {held.weights[3], held.tie.stiffness.value_or(1.0), 0.0});
  }
}

}  // namespace

Fingerprint fingerprint_of(const Model& model, const SimulationSettings& settings) {
  const Bodies& bodies = model.bodies;
  std::vector<Index> ends;
  for (const Body& body : bodies.bodies()) ends.push_back(body.points.end);
  return {{hash_of(ends, copy_of(bodies.points_rest()), copy_of(bodies.tets()), model.fixed_points,
                   model.fixed_axes, model.obstacles, model.absent),
           hash_of(model.materials, model.material_of_tet, model.fibre_of_tet),
           hash_of(model.motions, model.motion_of_point, model.ties),
           hash_of(model.point_loads, model.surface_loads, model.gravity_of_body), hash_of(settings)}};
}

std::vector<std::byte> bytes_of(const SimulationSettings& settings) {
  ArchiveWriter writer;
  SimulationSettings copy = settings;  // an archive takes non-const references
  writer(copy);
  return writer.take();
}

SimulationSettings with_bytes(SimulationSettings settings, std::span<const std::byte> bytes) {
  ArchiveReader reader(bytes, saved_state_name);
  reader(settings);
  reader.finish();
  return settings;
}

void check_saved(const SavedState& saved, const Bodies& bodies) {
  const std::size_t points = bodies.points_rest().size();
  if (!saved.forces.empty()) check_length("forces", saved.forces.size(), points);
  for (const Vec3& force : saved.forces) check_finite("forces", force);
  check_length("contact_forces", saved.contact_forces.size(), bodies.bodies().size());
  if (!saved.pressures.empty()) check_length("pressures", saved.pressures.size(), bodies.triangles().size());
  for (const double pressure : saved.pressures) check_finite("pressures", {pressure, 0.0, 0.0});
  if (!saved.reactions.empty()) check_length("reactions", saved.reactions.size(), points);
  for (const Vec3& force : saved.reactions) check_finite("reactions", force);
  for (const Vec3& force : saved.tie_forces) check_finite("tie_forces", force);
  check_acting(saved.acting_contacts, bodies);
  if (saved.changed) {
    check_holds(saved.changed->holds, saved.motions.size(), bodies);
    check_loads(*saved.changed, bodies);
  }
  for (const HeldGrab& held : saved.grabs) {
    check_index("grab.point", held.grab.point, -1, points);
    check_finite("grab", held.grab.target);
    check_finite("grab", {held.grab.stiffness, 0.0, 0.0});
  }
  check_contacts(saved.contacts, bodies);
  check_kept(saved.kept_contacts, bodies);
  check_ends(saved.edge_ends, bodies);
  constexpr std::int64_t most_steps = std::int64_t{1} << 53;  // exact as a double
  if (saved.metrics.step < 0 || saved.metrics.step > most_steps || saved.slow_steps < 0 ||
      saved.slow_steps > saved.metrics.step) {
    throw Error(saved_state_name, "step", std::to_string(saved.metrics.step), "a number of steps");
  }
  if (!std::isfinite(saved.last_length) || saved.last_length <= 0.0)
    throw Error(saved_state_name, "last_length", number_text(saved.last_length), "a finite number > 0");
}

}  // namespace palpate
