#pragma once

#include <string>

#include "scene/alternatives.hpp"
#include "scene/limits.hpp"
#include "scene/scene.hpp"
#include "scene/scene_motion.hpp"

/// Stages and outcomes: the part of fields.hpp under "stages" and "outcomes".
namespace palpate::scene_format {

template <class Visitor>
void describe(Visitor& v, SceneMotion& motion);
template <class Visitor>
void describe(Visitor& v, Load& load);

template <class Visitor>
void describe(Visitor& v, PointPart& part);

template <class Visitor>
void describe(Visitor& v, StageBody& body) {
  v.required("body", body.body);
  v.optional("part", body.part);
}

template <class Visitor>
void describe(Visitor& v, StageMove& move) {
  v.required("body", move.body);
  v.optional("part", move.part);
  v.required("motion", move.motion);
  const std::vector<SceneKeyframe>& keys = move.motion.keyframes;
  v.rule(keys.empty() || keys.front().time >= 0.0, "motion", "a keyframe before the start of the stage",
         "times >= 0, which count from the start of the stage");
  v.rule(keys.empty() || !turns_too_far({}, keys.front()), "motion",
         "a first rotation by more than 180 degrees",
         "at most 180 degrees, since rotations take the shorter arc");
}

template <class Visitor>
void describe(Visitor& v, StageTie& tie) {
  v.required("body", tie.body);
  v.required("to", tie.to);
  v.word_or_number("stiffness", tie.stiffness, "auto", above(0));
  describe_points(v, tie.points);
}

/// Two different names.
template <class Visitor>
void require_two(Visitor& v, BodyNames& bodies) {
  v.required("bodies", bodies);
  const bool two = bodies.names.size() == 2;
  v.rule(two, "bodies", std::to_string(bodies.names.size()), "two names");
  v.rule(!two || bodies.names[0] != bodies.names[1], "bodies", "the same name twice",
         "the names of two different bodies");
}

template <class Visitor>
void describe(Visitor& v, StageCut& cut) {
  require_two(v, cut.bodies);
}

template <class Visitor>
void describe(Visitor& v, StageLoads& loads) {
  v.required("body", loads.body);
  v.list("loads", loads.loads);
}

template <class Visitor>
void describe(Visitor& v, ForceReached& force) {
  v.required("body", force.body);
  v.optional("from", force.from);
  v.rule(!force.from || *force.from != force.body, "from", "the body itself", "another body, or nothing");
  v.required("at_least", force.at_least, above(0));
}

template <class Visitor>
void describe(Visitor& v, StageEnd& end) {
  v.optional("time", end.time, above(0));
  v.optional("rest", end.rest);
  v.optional("force", end.force);
  v.optional("most", end.most, above(0));
  require_one(
      v,
      {{{"time", end.time.has_value()}, {"rest", end.rest.has_value()}, {"force", end.force.has_value()}}});
  v.rule(end.rest.value_or(true), "rest", "false", "true, or another condition");
  v.rule(end.time.has_value() != end.most.has_value(), "most",
         end.time ? "'most' together with 'time'" : "nothing",
         end.time ? "only one of the two" : "the time after which the stage ends in any case");
}

/// A name that is also the name of a file and a column.
template <class Visitor>
void require_plain_name(Visitor& v, std::string& name) {
  v.required("name", name);
  const auto plain = [](char c) {
    return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == '-' || c == '_';
  };
  v.rule(!name.empty() && std::ranges::all_of(name, plain), "name", "'" + name + "'",
         "letters, digits, '-' and '_'");
}

template <class Visitor>
void describe(Visitor& v, Stage& stage) {
  require_plain_name(v, stage.name);
  v.field("insert", stage.insert);
  v.field("remove", stage.remove);
  v.list("release", stage.release);
  v.list("fix", stage.fix);
  v.list("move", stage.move);
  v.list("untie", stage.untie);
  v.list("tie", stage.tie);
  v.list("loads", stage.loads);
  v.optional("gravity", stage.gravity);
  v.required("until", stage.until);
  v.field("checkpoint", stage.checkpoint);
}

template <class Visitor>
void describe(Visitor& v, ScenePoint& point) {
  v.required("body", point.body);
  v.required("at", point.at);
}

template <class Visitor>
void require_direction(Visitor& v, std::string_view key, const std::optional<Vec3>& direction) {
  v.rule(!direction || *direction != Vec3{}, key, "a zero vector", "a direction");
}

template <class Visitor>
void describe(Visitor& v, DisplacementOutcome& of) {
  v.required("body", of.body);
  v.optional("at", of.at);
  v.optional("along", of.along);
  require_direction(v, "along", of.along);
}

template <class Visitor>
void describe(Visitor& v, RotationOutcome& of) {
  v.required("body", of.body);
  v.optional("about", of.about);
  require_direction(v, "about", of.about);
}

template <class Visitor>
void describe(Visitor& v, DistanceOutcome& of) {
  v.required("from", of.from);
  v.required("to", of.to);
}

template <class Visitor>
void describe(Visitor& v, ScenePlane& plane) {
  v.required("point", plane.point);
  v.required("normal", plane.normal);
  v.rule(plane.normal != Vec3{}, "normal", "a zero vector", "a direction");
}

template <class Visitor>
void describe(Visitor& v, VolumeOutcome& of) {
  v.required("body", of.body);
  v.list("beyond", of.beyond);
  v.optional("within", of.within);
  v.rule(!of.within || *of.within != of.body, "within", "the body itself", "another body, or nothing");
}

template <class Visitor>
void describe(Visitor& v, CavityOutcome& of) {
  v.required("body", of.body);
  v.list("walls", of.walls);
  v.rule(!of.walls.empty(), "walls", "none", "one or more");
}

template <class Visitor>
void describe(Visitor& v, GapOutcome& of) {
  require_two(v, of.bodies);
}

template <class Visitor>
void describe(Visitor& v, ContactAreaOutcome& of) {
  require_two(v, of.bodies);
}

template <class Visitor>
void describe(Visitor& v, StressOutcome& of) {
  v.required("body", of.body);
}

template <class Visitor>
void describe(Visitor& v, ForceOutcome& of) {
  v.required("body", of.body);
  v.optional("from", of.from);
  v.rule(!of.from || *of.from != of.body, "from", "the body itself", "another body, or nothing");
  v.optional("along", of.along);
  require_direction(v, "along", of.along);
}

template <class Visitor>
void describe(Visitor& v, SceneOutcome& outcome) {
  require_plain_name(v, outcome.name);
  v.one_of(outcome.of, {"displacement", "rotation", "distance", "volume", "cavity", "gap", "contact_area",
                        "stress", "force"});
}

}  // namespace palpate::scene_format
