#include "scene/outcome_probe.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numbers>
#include <utility>
#include <variant>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "scene/json_text.hpp"
#include "scene/pair_force.hpp"
#include "scene/selector.hpp"
#include "scene/surface_load.hpp"

namespace palpate {

/// Resolves the names in an outcome.
struct OutcomeReader {
  const Scene& scene;
  const Bodies& bodies;
  std::string path;
  OutcomeInfo& info;
  OutcomeProbe::Of& of;

  void operator()(const DisplacementOutcome& o) const {
    tell("displacement", dimension::length, true);
    name(0, o.body);
    if (o.at) mark(0, *o.at, ".displacement.at");
    rotate(o.along);
  }
  void operator()(const RotationOutcome& o) const {
    tell("rotation", dimension::none, true);
    info.degrees = true;
    name(0, o.body);
    rotate(o.about);
  }
  void operator()(const DistanceOutcome& o) const {
    tell("distance", dimension::length, false);
    name(0, o.from.body);
    name(1, o.to.body);
    mark(0, o.from.at, ".distance.from.at");
    mark(1, o.to.at, ".distance.to.at");
  }
  void operator()(const VolumeOutcome& o) const {
    tell("volume", dimension::volume, false);
    name(0, o.body);
    if (o.within) name(1, *o.within);
    for (const ScenePlane& plane : o.beyond) of.spaces.push_back({plane.point, plane.normal});
  }
  void operator()(const CavityOutcome& o) const {
    tell("cavity", dimension::volume, false);
    name(0, o.body);
    const Range range = at(bodies.bodies(), of.bodies[0]).points;
    const auto points = bodies.points_rest().subspan(static_cast<std::size_t>(range.begin),
                                                     static_cast<std::size_t>(range.size()));
    const std::string where = path + ".cavity.walls";
    const std::vector<Index> walls = Selector{scene, bodies, of.bodies[0], points, "point"}(o.walls, where);
    try {
      of.cavity = cavity(bodies, triangles_of(bodies, of.bodies[0], walls));
    } catch (const Error& error) {
      throw Error(scene.source, where, error.found(), error.expected());
    }
  }
  void operator()(const GapOutcome& o) const {
    tell("gap", dimension::length, false);
    for (std::size_t i = 0; i < 2; ++i) name(i, o.bodies.names[i]);
  }
  void operator()(const ContactAreaOutcome& o) const {
    tell("contact_area", dimension::area, false);
    for (std::size_t i = 0; i < 2; ++i) name(i, o.bodies.names[i]);
  }
  void operator()(const StressOutcome& o) const {
    tell("stress", dimension::pressure, false);
    name(0, o.body);
  }
  void operator()(const ForceOutcome& o) const {
    tell("force", dimension::force, true);
    name(0, o.body);
    if (o.from) name(1, *o.from);
    rotate(o.along);
  }

 private:
  void tell(const char* kind, const Dimension& dimension, bool has_vector) const {
    info.kind = kind;
    info.dimension = dimension;
    info.has_vector = has_vector;
  }
  void name(std::size_t i, const std::string& body) const {
    of.bodies[i] = body_named(scene, body, path, -1);
  }
  void mark(std::size_t i, const Vec3& place, const char* key) const {
    try {
      of.marks[i] = landmark(bodies, of.bodies[i], place);
    } catch (const Error& error) {
      throw Error(scene.source, path + key, error.found(), error.expected());
    }
  }
  void rotate(const std::optional<Vec3>& direction) const {
    if (direction) of.direction = normalized(*direction);
  }
};

/// Computes one outcome.
struct OutcomeTeller {
  const Simulation& simulation;
  const OutcomeProbe::Of& of;
  const std::vector<double>& stresses;  ///< (n_bodies) largest von Mises stress; empty if no outcome needs it

  OutcomeValue operator()(const DisplacementOutcome& o) const {
    if (!o.at) return vector(center(positions()) - center(bodies().points_rest()));
    return vector(place_of(bodies(), of.marks[0], positions()) -
                  place_of(bodies(), of.marks[0], bodies().points_rest()));
  }
  OutcomeValue operator()(const RotationOutcome&) const {
    const Vec3 rotate = rotation_of(bodies(), of.bodies[0], positions(), simulation.point_masses());
    return vector((180.0 / std::numbers::pi) * rotate);
  }
  OutcomeValue operator()(const DistanceOutcome&) const {
    return {
        length(place_of(bodies(), of.marks[1], positions()) - place_of(bodies(), of.marks[0], positions()))};
  }
  OutcomeValue operator()(const VolumeOutcome&) const {
    if (of.bodies[1] < 0) return {volume_in(bodies(), of.bodies[0], positions(), of.spaces)};
    return {volume_within(bodies(), of.bodies[0], of.bodies[1], positions(), of.spaces)};
  }
  OutcomeValue operator()(const CavityOutcome&) const {
    return {volume_of(of.cavity, bodies(), positions())};
  }
  OutcomeValue operator()(const GapOutcome&) const {
    if (touch()) return {0.0};
    return {distance_of(bodies(), of.bodies[0], of.bodies[1], positions())};
  }
  OutcomeValue operator()(const ContactAreaOutcome&) const {
    return {contact_area(simulation, of.bodies[0], of.bodies[1])};
  }
  OutcomeValue operator()(const StressOutcome&) const { return {at(stresses, of.bodies[0])}; }
  OutcomeValue operator()(const ForceOutcome&) const {
    return vector(of.bodies[1] < 0 ? at(simulation.contact_forces(), of.bodies[0])
                                   : force_by(simulation, of.bodies[0], of.bodies[1]));
  }

 private:
  [[nodiscard]] const Bodies& bodies() const { return simulation.bodies(); }
  [[nodiscard]] std::span<const Vec3> positions() const { return simulation.positions(); }
  /// Centre of mass.
  [[nodiscard]] Vec3 center(std::span<const Vec3> points) const {
    Vec3 sum;
    double mass = 0.0;
    const Range range = at(bodies().bodies(), of.bodies[0]).points;
    for (Index p = range.begin; p < range.end; ++p) {
      sum += at(simulation.point_masses(), p) * at(points, p);
      mass += at(simulation.point_masses(), p);
    }
    return (1.0 / mass) * sum;
  }
  [[nodiscard]] OutcomeValue vector(const Vec3& v) const {
    return {of.direction ? dot(v, *of.direction) : length(v), v};
  }
  [[nodiscard]] bool touch() const {
    const auto ours = [&](Index a, Index b) {
      return (a == of.bodies[0] && b == of.bodies[1]) || (a == of.bodies[1] && b == of.bodies[0]);
    };
    const Contacts& contacts = simulation.detector().contacts();
    for (std::size_t c = 0; c < contacts.size(); ++c)
      if (ours(at(bodies().body_of_point(), contacts.point[c]), contacts.body[c])) return true;
    const EdgeContacts& edges = simulation.detector().edge_contacts();
    for (std::size_t c = 0; c < edges.size(); ++c)
      if (ours(bodies().body_of(at(bodies().edges(), edges.edge[c])), edges.body[c])) return true;
    return false;
  }
};

namespace {

std::vector<double> largest_stresses(const Simulation& simulation) {
  const Bodies& bodies = simulation.bodies();
  const TissueState tissue = simulation.tissue();
  std::vector<double> largest(bodies.bodies().size(), 0.0);
  for (std::size_t t = 0; t < tissue.size(); ++t) {
    double& most = at(largest, bodies.body_of(bodies.tets()[t]));
    if (tissue.von_mises[t] > most) most = tissue.von_mises[t];
  }
  return largest;
}

}  // namespace

OutcomeProbe::OutcomeProbe(const Scene& scene, const Bodies& bodies)
    : units_(scene.units), outcomes_(scene.outcomes) {
  for (std::size_t i = 0; i < outcomes_.size(); ++i) {
    OutcomeInfo& info = infos_.emplace_back();
    info.name = outcomes_[i].name;
    std::visit(OutcomeReader{scene, bodies, element_path("outcomes", i), info, of_.emplace_back()},
               outcomes_[i].of);
  }
}

std::vector<OutcomeValue> OutcomeProbe::values(const Simulation& simulation) const {
  const bool stress = std::ranges::any_of(
      outcomes_, [](const SceneOutcome& o) { return std::holds_alternative<StressOutcome>(o.of); });
  const std::vector<double> stresses = stress ? largest_stresses(simulation) : std::vector<double>();
  std::vector<OutcomeValue> values;
  for (std::size_t i = 0; i < outcomes_.size(); ++i)
    values.push_back(std::visit(OutcomeTeller{simulation, of_[i], stresses}, outcomes_[i].of));
  return values;
}

std::string OutcomeProbe::unit(std::size_t outcome) const {
  return infos_[outcome].degrees ? "deg" : unit_name(units_, infos_[outcome].dimension);
}

std::string OutcomeProbe::in_words(std::size_t outcome, double value) const {
  const Dimension& d = infos_[outcome].dimension;
  if (infos_[outcome].degrees) return fmt::format("{:.4g} deg", value);
  if (d == dimension::volume) return fmt::format("{:.4g} ml", 1e6 * to_si(value, units_, d));
  if (d == dimension::area) return fmt::format("{:.4g} mm^2", 1e6 * to_si(value, units_, d));
  return palpate::in_words(value, units_, d);
}

}  // namespace palpate
