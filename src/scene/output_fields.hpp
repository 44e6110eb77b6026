#pragma once

#include <algorithm>
#include <string>

#include "scene/field_list.hpp"
#include "scene/limits.hpp"
#include "scene/scene.hpp"
#include "scene/suggest.hpp"

/// The output of a run: the part of fields.hpp under "output".
namespace palpate::scene_format {

template <class Visitor>
void describe(Visitor& v, Camera& camera) {
  v.optional("position", camera.position);
  v.optional("target", camera.target);
  v.rule(!camera.position || !camera.target || *camera.position != *camera.target, "target",
         "the camera's position", "another point");
}

template <class Visitor>
void describe(Visitor& v, Picture& picture) {
  v.field("size", picture.size, within(16, 16384));
  v.object("camera", picture.camera);
}

template <class Visitor>
void describe(Visitor& v, Cut& cut) {
  v.required("point", cut.point);
  v.required("normal", cut.normal);
  v.field("bodies", cut.bodies);
  v.rule(cut.normal != Vec3{}, "normal", "a zero vector", "a direction");
}

template <class Visitor>
void describe(Visitor& v, DisplacementMap& map) {
  v.required("most", map.most, above(0));
  v.field("bodies", map.bodies);
}

template <class Visitor>
void describe(Visitor& v, FieldMap& map) {
  v.required("name", map.name);
  v.field("least", map.least);
  v.word_or_number("most", map.most, "auto", any);
  v.field("bodies", map.bodies);
  v.rule(!map.most || *map.most > map.least, "most", "a value not above 'least'", "a larger one");
  const FieldInfo* const info = find_field(map.name);
  v.rule(map.name.empty() || (info != nullptr && info->components <= 3), "name", "'" + map.name + "'",
         info != nullptr ? "a field of one or three components" : expected_name(map.name, field_names()));
}

template <class Visitor>
void describe(Visitor& v, BodyPair& pair) {
  v.required("bodies", pair.bodies);
  v.rule(pair.bodies.names.size() == 2, "bodies", std::to_string(pair.bodies.names.size()), "two names");
}

template <class Visitor>
void describe(Visitor& v, View& view) {
  v.required("name", view.name);
  v.field("size", view.size, within(16, 16384));
  v.object("camera", view.camera);
  v.choice("when", view.when, view_time_names);
  v.field("bodies", view.bodies);
  v.optional("cut", view.cut);
  v.optional("displacement", view.displacement);
  v.optional("field", view.field);
  v.rule(!view.displacement || !view.field, "field", "'field' together with 'displacement'",
         "only one of the two");
  v.field("contacts", view.contacts);
  const auto plain = [](char c) {
    return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == '-' || c == '_';
  };
  v.rule(std::ranges::all_of(view.name, plain) && view.name != "picture", "name", "'" + view.name + "'",
         "letters, digits, '-' and '_', and not 'picture'");
}

template <class Visitor>
void describe(Visitor& v, OutputSettings& output) {
  v.field("every", output.every, at_least(1));
  v.field("fields", output.fields);
  v.list("pairs", output.pairs);
  v.object("picture", output.picture);
  v.list("views", output.views);
  v.field("report", output.report);
}

}  // namespace palpate::scene_format
