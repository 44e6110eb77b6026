#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <string>
#include <string_view>

#include <palpate/tissues.hpp>

#include "number_text.hpp"
#include "scene/alternatives.hpp"
#include "scene/generators.hpp"
#include "scene/limits.hpp"
#include "scene/output_fields.hpp"
#include "scene/scene.hpp"
#include "scene/stage_fields.hpp"

/// The definition of the scene format: the keys of each object, the members that they set, and their limits.
/// The reader, the writer and the list of keys are visitors of these functions (values.hpp lists the
/// functions of a visitor).
namespace palpate::scene_format {

template <class Visitor>
void describe(Visitor& v, Units& units) {
  v.unit("length", units.length, length_units);
  v.unit("mass", units.mass, mass_units);
  v.unit("time", units.time, time_units);
}

template <class Visitor>
void describe(Visitor& v, BoxGenerator& box) {
  v.required("cells", box.cells, within(1, 1024));
  v.required("size", box.size, above(0));
}

template <class Visitor>
void describe(Visitor& v, BallGenerator& ball) {
  v.required("radius", ball.radius, above(0));
  v.required("resolution", ball.resolution, within(1, most_ball_resolution));
}

template <class Visitor>
void describe(Visitor& v, Rotation& rotate) {
  v.optional("quaternion", rotate.quaternion);
  v.rule(!rotate.quaternion || !(v.given("axis") || v.given("angle")), "quaternion",
         "'quaternion' together with 'axis' or 'angle'", "either 'quaternion' or 'axis' and 'angle'");
  const auto is_zero = [](const auto& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double x) { return x == 0.0; });
  };
  v.rule(!rotate.quaternion || !is_zero(*rotate.quaternion), "quaternion", "zero",
         "[w, x, y, z], not all zero");
  if (rotate.quaternion) return;
  v.field("axis", rotate.axis);
  v.field("angle", rotate.angle);
  v.rule(!is_zero(std::array{rotate.axis.x, rotate.axis.y, rotate.axis.z}), "axis", "a zero vector",
         "a direction");
}

template <class Visitor>
void describe(Visitor& v, Fibres& fibres) {
  v.field("direction", fibres.direction);
  const Vec3& d = fibres.direction;
  v.rule(d.x != 0.0 || d.y != 0.0 || d.z != 0.0, "direction", "a zero vector", "a direction");
  std::optional<std::string> field;
  if (!fibres.field.empty()) field = fibres.field;
  v.optional("field", field);
  fibres.field = field.value_or("");
  v.field("stiffness", fibres.stiffness, at_least(0).in(dimension::pressure));
  v.field("exponent", fibres.exponent, at_least(0));
  v.field("active_stress", fibres.active_stress, at_least(0).in(dimension::pressure));
  std::optional<Ramp> activation;
  if (!fibres.activation.times.empty()) activation = fibres.activation;
  v.optional("activation", activation);
  fibres.activation = activation.value_or(Ramp{});
}

template <class Visitor>
void describe(Visitor& v, Viscosity& viscosity) {
  v.required("fractions", viscosity.fractions, within(0, 1));
  v.required("times", viscosity.times, above(0));
  v.rule(!viscosity.fractions.empty() && viscosity.times.size() == viscosity.fractions.size(), "times",
         std::to_string(viscosity.times.size()), "as many as fractions, one or more");
  const double sum = std::accumulate(viscosity.fractions.begin(), viscosity.fractions.end(), 0.0);
  v.rule(sum < 1.0, "fractions", "a sum of " + number_text(sum), "a sum < 1: the rest never relaxes");
}

template <class Visitor>
void describe(Visitor& v, Material& material) {
  const std::optional<Tissue> before = material.tissue;
  v.preset("tissue", material.tissue, tissue_names);
  if (material.tissue && material.tissue != before) material = tissue_material(*material.tissue);
  v.field("young_modulus", material.young_modulus, above(0).in(dimension::pressure));
  v.field("poisson_ratio", material.poisson_ratio, strictly_within(-1, 0.5));
  v.field("density", material.density, above(0).in(dimension::density));
  v.field("mass_damping", material.mass_damping, at_least(0));
  v.field("stiffness_damping", material.stiffness_damping, at_least(0));
  v.optional("plastic_yield", material.plastic_yield, at_least(0));
  v.field("plastic_creep", material.plastic_creep, at_least(0));
  v.optional("plastic_maximum", material.plastic_maximum, at_least(0));
  v.choice("model", material.model, material_model_names);
  v.choice("elements", material.elements, element_kind_names);
  v.field("mooney_fraction", material.mooney_fraction, within(0, 1));
  std::optional<Fibres> fibres;
  if (material.fibres.any()) fibres = material.fibres;
  v.optional("fibres", fibres);
  material.fibres = fibres.value_or(Fibres{});
  std::optional<Viscosity> viscosity;
  if (material.viscosity.any()) viscosity = material.viscosity;
  v.optional("viscosity", viscosity);
  material.viscosity = viscosity.value_or(Viscosity{});
  const bool linear = material.model == MaterialModel::corotational;
  const bool smoothed = material.elements == ElementKind::smoothed;
  v.rule(!smoothed || material.poisson_ratio >= 0.0, "poisson_ratio", "a number < 0",
         "a number >= 0 with smoothed elements");
  v.rule(!smoothed || !material.plastic_yield, "plastic_yield", "plasticity with smoothed elements",
         "linear elements");
  v.rule(!linear || !fibres, "fibres", "fibres with the model corotational", "a hyperelastic 'model'");
  v.rule(linear || !material.plastic_yield, "plastic_yield", "plasticity with a hyperelastic model",
         "the model corotational, the only one that can yield");
  v.rule(!material.plastic_yield || v.given("plastic_creep"), "plastic_creep", "nothing",
         "a number >= 0, since 'plastic_yield' is given");
}

template <class Visitor>
void describe(Visitor& v, BoxSelection& box) {
  v.required("lower", box.lower);
  v.required("upper", box.upper);
  const bool ordered = box.lower.x <= box.upper.x && box.lower.y <= box.upper.y && box.lower.z <= box.upper.z;
  v.rule(ordered, "upper", "a value below 'lower'", "upper >= lower on each axis");
}

template <class Visitor>
void describe(Visitor& v, SphereSelection& sphere) {
  v.required("center", sphere.center);
  v.required("radius", sphere.radius, at_least(0));
}

template <class Visitor>
void describe(Visitor& v, NearSelection& near) {
  v.required("body", near.body);
  v.required("distance", near.distance, at_least(0));
  v.optional("box", near.box);
}

/// Whether a text names one to three different axes.
inline bool names_axes(std::string_view axes) {
  const auto counted = [&](char axis) { return std::ranges::count(axes, axis); };
  return !axes.empty() && std::ranges::all_of(axes, [](char c) { return 'x' <= c && c <= 'z'; }) &&
         counted('x') <= 1 && counted('y') <= 1 && counted('z') <= 1;
}

template <class Visitor>
void describe(Visitor& v, Fixation& fixation) {
  describe_points(v, fixation.points);
  v.field("axes", fixation.axes);
  v.rule(names_axes(fixation.axes), "axes", "'" + fixation.axes + "'",
         "one or more of the letters x, y and z, such as \"xz\"");
}

template <class Visitor>
void describe(Visitor& v, PointPart& part) {
  describe_points(v, part.points);
}

template <class Visitor>
void describe(Visitor& v, FibreEnds& ends) {
  v.list("from", ends.from);
  v.list("to", ends.to);
  v.rule(!ends.from.empty(), "from", "none", "one or more");
  v.rule(!ends.to.empty(), "to", "none", "one or more");
}

template <class Visitor>
void describe(Visitor& v, Region& region) {
  v.one_of(region.tets, {"box", "sphere", "tets", "label"});
  v.required("material", region.material);
  v.optional("color", region.color, within(0, 1));
}

template <class Visitor>
void describe(Visitor& v, SceneKeyframe& key) {
  v.required("time", key.time);
  v.field("translate", key.translate);
  v.object("rotate", key.rotate);
}

template <class Visitor>
void describe(Visitor& v, SceneMotion& motion) {
  v.field("center", motion.center);
  v.choice("interpolation", motion.interpolation, interpolation_names);
  v.list("keyframes", motion.keyframes);
  v.rule(!motion.keyframes.empty(), "keyframes", "none", "one or more");
  const auto late = std::adjacent_find(motion.keyframes.begin(), motion.keyframes.end(),
                                       [](const auto& a, const auto& b) { return b.time <= a.time; });
  v.rule(late == motion.keyframes.end(), "keyframes", "times that do not increase",
         "each time later than the one before");
  const auto far = std::adjacent_find(motion.keyframes.begin(), motion.keyframes.end(),
                                      [](const auto& a, const auto& b) { return turns_too_far(a, b); });
  v.rule(far == motion.keyframes.end(), "keyframes", "rotations about one axis by more than 180 degrees",
         "at most 180 degrees from one keyframe to the next, since rotations take the shorter arc");
}

template <class Visitor>
void describe(Visitor& v, Prescription& prescription) {
  describe_points(v, prescription.points);
  v.required("motion", prescription.motion);
}

template <class Visitor>
void describe(Visitor& v, Attachment& attachment) {
  v.required("to", attachment.to);
  describe_points(v, attachment.points);
  v.word_or_number("stiffness", attachment.stiffness, "auto", above(0));
}

template <class Visitor>
void describe(Visitor& v, Ramp& ramp) {
  v.required("times", ramp.times);
  v.required("factors", ramp.factors);
  v.rule(!ramp.times.empty() && ramp.times.size() == ramp.factors.size(), "factors",
         std::to_string(ramp.factors.size()), "as many as times, one or more");
  v.rule(std::ranges::adjacent_find(ramp.times, std::greater_equal()) == ramp.times.end(), "times",
         "times that do not increase", "each time later than the one before");
}

template <class Visitor>
void describe(Visitor& v, Load& load) {
  v.optional("force", load.force);
  v.optional("pressure", load.pressure);
  v.optional("traction", load.traction);
  v.optional("ramp", load.ramp);
  describe_points(v, load.points);
  require_one(v, {{{"force", load.force.has_value()},
                   {"pressure", load.pressure.has_value()},
                   {"traction", load.traction.has_value()}}});
}

template <class Visitor>
void describe(Visitor& v, SceneGrab& grab) {
  v.required("from", grab.from);
  v.required("target", grab.target);
  v.required("stiffness", grab.stiffness, above(0));
}

/// Whether `test` is true for the fibres of any material of a body.
template <class Test>
bool has_fibres(const SceneBody& body, Test test) {
  return (body.material && test(body.material->fibres)) ||
         std::ranges::any_of(body.regions,
                             [&](const Region& region) { return test(region.material.fibres); });
}

template <class Visitor>
void describe(Visitor& v, SceneBody& body) {
  v.field("name", body.name);
  v.one_of(body.source, {"mesh", "box", "ball"});
  v.scale("scale", body.transform.scale, above(0));
  v.object("rotate", body.transform.rotate);
  v.field("translate", body.transform.translate);
  v.field("velocity", body.velocity);
  v.field("angular_velocity", body.angular_velocity);
  v.optional("gravity", body.gravity);
  v.optional("material", body.material);
  v.list("regions", body.regions);
  v.optional("fibre_ends", body.fibre_ends);
  v.list("fixed", body.fixed);
  v.list("prescribed", body.prescribed);
  v.field("absent", body.absent);
  v.field("obstacle", body.obstacle);
  v.field("self_collision", body.self_collision);
  v.field("no_contact", body.no_contact);
  v.optional("motion", body.motion);
  v.list("attached", body.attached);
  v.list("loads", body.loads);
  v.list("grabs", body.grabs);
  v.optional("color", body.color, within(0, 1));
  v.rule(!is_rigid(body) || !body.self_collision, "self_collision", "true for a rigid body",
         "false: a rigid body has one shape");
  v.rule(!is_rigid(body) || body.velocity == Vec3{}, "velocity", "this key in a rigid body",
         "a body that deforms (an obstacle is moved by its motion)");
  v.rule(!is_rigid(body) || body.angular_velocity == Vec3{}, "angular_velocity", "this key in a rigid body",
         "a body that deforms (an obstacle is moved by its motion)");
  v.rule(!body.motion || body.fixed.empty(), "fixed", "'fixed' in a body with a 'motion'",
         "only one of the two");
  v.rule(is_rigid(body) || body.material, "material", "nothing",
         "the material of a body that is neither an obstacle nor has a motion");
  const auto only_soft = [&](const auto& list, const char* key) {
    v.rule(list.empty() || !is_rigid(body), key, "this key in a rigid body", "a body that deforms");
  };
  only_soft(body.regions, "regions");
  only_soft(body.prescribed, "prescribed");
  only_soft(body.attached, "attached");
  only_soft(body.loads, "loads");
  only_soft(body.grabs, "grabs");
  v.rule(!body.fibre_ends || has_fibres(body, [](const Fibres& fibres) { return fibres.any(); }),
         "fibre_ends", "'fibre_ends' in a body without fibres",
         "'fibres' in its material or that of a region");
  v.rule(!body.fibre_ends || !has_fibres(body, [](const Fibres& fibres) { return !fibres.field.empty(); }),
         "fibre_ends", "'fibre_ends' together with 'fibres.field'", "only one of the two");
}

template <class Visitor>
void describe(Visitor& v, InterestRegion& region) {
  v.required("center", region.center);
  v.required("radius", region.radius, above(0));
}

template <class Visitor>
void describe(Visitor& v, Budget& budget) {
  v.optional("tests", budget.tests, at_least(1));
  v.optional("milliseconds", budget.milliseconds, above(0));
  v.optional("region", budget.region);
  const char* const found = budget.tests ? "both tests and milliseconds" : "neither tests nor milliseconds";
  v.rule(budget.tests.has_value() != budget.milliseconds.has_value(), "milliseconds", found,
         "exactly one of tests and milliseconds");
}

/// The contact block of a scene: settings of detection and of contact forces.
struct ContactBlock {
  DetectionSettings& detection;
  ResponseSettings& response;
};

template <class Visitor>
void describe(Visitor& v, ContactBlock& contact) {
  v.choice("structure", contact.detection.structure, structure_names);
  v.choice("order", contact.detection.order, order_names);
  v.choice("sort", contact.detection.sort, sort_names);
  v.words_or_number("cell_size", contact.detection.cell_size, cell_size_rule_names, above(0));
  v.word_or_number("cells_per_primitive", contact.detection.cells_per_primitive, "exact", within(1, 27));
  v.field("edge_contacts", contact.detection.edge_contacts);
  v.field("coherence", contact.detection.coherence);
  v.choice("continuous", contact.detection.continuous, continuous_detection_names);
  v.optional("budget", contact.detection.budget);
  v.rule(!contact.detection.budget ||
             (contact.detection.structure == Structure::compact && !contact.detection.cells_per_primitive),
         "budget", "a budget with another structure, or with cells_per_primitive",
         "the structure compact without cells_per_primitive");
  v.word_or_number("stiffness", contact.response.stiffness, "auto", above(0));
  v.field("damping", contact.response.damping, at_least(0));
  v.field("friction", contact.response.friction, at_least(0));
}

template <class Visitor>
void describe(Visitor& v, SolverSettings& solver) {
  v.field("tolerance", solver.tolerance, strictly_within(0, 1));
  v.choice("tolerance_of", solver.tolerance_of, tolerance_of_names);
  v.choice("preconditioner", solver.preconditioner, preconditioner_names);
  v.field("max_iterations", solver.max_iterations, at_least(1));
  v.word_or_number("fixed_iterations", solver.fixed_iterations, "none", at_least(1));
  v.field("max_solves", solver.max_solves, at_least(1));
  v.field("max_substeps", solver.max_substeps, within(1, SolverSettings::most_substeps));
}

template <class Visitor>
void describe(Visitor& v, RestSettings& rest) {
  v.field("speed", rest.speed, above(0).in(dimension::speed));
  v.field("time", rest.time, above(0).in(dimension::time));
}

template <class Visitor>
void describe(Visitor& v, LimitSettings& limits) {
  v.word_or_number("max_speed", limits.max_speed, "auto", above(0));
  v.word_or_number("inverted_time", limits.inverted_time, "none", above(0));
}

template <class Visitor>
void describe(Visitor& v, RelaxSettings& relax) {
  v.field("depth", relax.depth, above(0));
  v.field("max_steps", relax.max_steps, at_least(1));
}

/// Whether a text has one letter of each of the pairs left/right, anterior/posterior, superior/inferior.
inline bool names_three_sides(std::string_view axes) {
  const auto counted = [&](std::string_view pair) {
    return std::ranges::count_if(axes, [&](char c) { return pair.find(c) != std::string_view::npos; });
  };
  return axes.size() == 3 && counted("LR") == 1 && counted("AP") == 1 && counted("SI") == 1;
}

template <class Visitor>
void describe(Visitor& v, Scene& scene) {
  v.ignored("$schema");  // for editors
  v.field("name", scene.name);
  v.object("units", scene.units);
  v.set_units(scene.units);
  v.optional("axes", scene.axes);
  v.rule(!scene.axes || names_three_sides(*scene.axes), "axes", scene.axes.value_or(""),
         "three letters, one of each pair L or R, A or P, S or I, as \"LPS\"");
  v.field("time_step", scene.settings.time_step, above(0).in(dimension::time));
  v.choice("time_integration", scene.settings.time_integration, time_integration_names);
  v.field("duration", scene.duration, above(0).in(dimension::time));
  v.field("gravity", scene.settings.gravity, any.in(dimension::acceleration));
  ContactBlock contact{scene.settings.detection, scene.settings.response};
  v.object("contact", contact);
  v.object("solver", scene.settings.solver);
  v.object("rest", scene.settings.rest);
  v.optional("relax", scene.relax);
  v.object("limits", scene.settings.limits);
  v.object("output", scene.output);
  v.list("bodies", scene.bodies);
  v.list("stages", scene.stages);
  v.list("outcomes", scene.outcomes);
  v.rule(!scene.bodies.empty(), "bodies", "no body", "one or more");
}

}  // namespace palpate::scene_format
