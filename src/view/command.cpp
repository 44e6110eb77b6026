#include "view/command.hpp"

#include <array>
#include <limits>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "scene/fields.hpp"
#include "scene/reader.hpp"
#include "scene/suggest.hpp"
#include "scene/writer.hpp"
#include "view/colour_field.hpp"

namespace palpate::view {
namespace {

using scene_format::Context;
using scene_format::Limits;
using namespace nlohmann::literals;

const std::string source = "message from the page";
constexpr std::size_t most_fields = 4;

/// Names of fields that a page can colour by.
struct ColourNames {
  std::vector<std::string> names;
};
void decode(const Context& context, const std::string& path, const nlohmann::json& json, ColourNames& value,
            const Limits& limits) {
  if (!json.is_array()) scene_format::fail(context, path, describe_json(json), "an array of names of fields");
  value.names.resize(json.size());
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string here = element_path(path, i);
    decode(context, here, json[i], value.names[i], limits);
    if (find_colour_field(value.names[i]) != nullptr) continue;
    std::vector<std::string_view> known;
    for (const ColourField& field : colour_fields()) known.push_back(field.name);
    scene_format::fail(context, here, describe_json(json[i]), expected_name(value.names[i], known));
  }
}

/// The settings of a simulation that can change while it runs.
struct LiveSettings {
  SimulationSettings& settings;
};

template <class Visitor>
void describe(Visitor& v, LiveSettings& live) {
  v.field("gravity", live.settings.gravity);
  scene_format::ContactBlock contact{live.settings.detection, live.settings.response};
  v.object("contact", contact);
}

}  // namespace

template <class Visitor>
void describe(Visitor& v, Play& play) {
  v.required("on", play.on);
}
template <class Visitor>
void describe(Visitor& /*v*/, StepOnce& /*step*/) {}
template <class Visitor>
void describe(Visitor& /*v*/, Reset& /*reset*/) {}
template <class Visitor>
void describe(Visitor& v, SetSpeed& speed) {
  v.word_or_number("speed", speed.speed, "max", scene_format::above(0));
}
template <class Visitor>
void describe(Visitor& v, Pull& pull) {
  v.required("vertex", pull.vertex, scene_format::at_least(0));
  v.required("target", pull.target);
  v.field("strength", pull.strength, scene_format::within(1e-3, 1e3));
}
template <class Visitor>
void describe(Visitor& v, MovePull& pull) {
  v.required("target", pull.target);
}
template <class Visitor>
void describe(Visitor& /*v*/, LetGo& /*pull*/) {}
template <class Visitor>
void describe(Visitor& v, DriveMotion& command) {
  v.required("motion", command.motion, scene_format::at_least(0));
  v.optional("time", command.time);
  v.optional("offset", command.offset);
}
template <class Visitor>
void describe(Visitor& v, ResumeMotion& command) {
  v.required("motion", command.motion, scene_format::at_least(0));
}
template <class Visitor>
void describe(Visitor& v, Seek& seek) {
  v.required("frame", seek.frame, scene_format::at_least(0));
}
template <class Visitor>
void describe(Visitor& v, DisplayOptions& display) {
  v.field("contacts", display.contacts);
  v.field("borders", display.borders);
  v.field("cells", display.cells);
  v.field("inside", display.inside);
  v.field("forces", display.forces);
  ColourNames names{display.fields};
  v.field("fields", names);
  v.rule(names.names.size() <= most_fields, "fields", std::to_string(names.names.size()),
         "at most " + std::to_string(most_fields));
  display.fields = std::move(names.names);
}
template <class Visitor>
void describe(Visitor& v, Shown& shown) {
  constexpr double largest_exact = 9007199254740992.0;  // 2^53
  v.required("frame", shown.frame, scene_format::within(0, largest_exact));
}
/// Throws Error for values that no simulation accepts, so that the page gets an answer immediately.
void decode(const Context& /*context*/, const std::string& /*path*/, const nlohmann::json& json,
            Change& change, const Limits& /*limits*/) {
  static_cast<void>(changed({}, json));
  change.settings = json;
}

Command parse_command(std::string_view text) {
  constexpr std::array<std::string_view, std::variant_size_v<Command>> names{
      "play",   "step",         "reset",         "speed", "change", "pull", "move_pull",
      "let_go", "drive_motion", "resume_motion", "seek",  "look",   "shown"};
  const nlohmann::json json = parse_json(text, source);
  Context context{source};
  scene_format::Reader reader(context, "", json);
  Command command;
  reader.one_of(command, names);
  reader.finish();
  return command;
}

nlohmann::ordered_json settings_json(const SimulationSettings& settings) {
  SimulationSettings copy =
      settings;  // the functions are also used for reading, so they take non-const references
  LiveSettings live{copy};
  scene_format::Writer writer("");
  describe(writer, live);
  return writer.take();
}

SimulationSettings changed(const SimulationSettings& settings, const nlohmann::json& change) {
  SimulationSettings copy = settings;
  nlohmann::json named = change;
  // A scene has no value for "no budget": it omits the key, which here means "unchanged".
  if (named.contains("/contact/budget"_json_pointer) && named["contact"]["budget"].is_null()) {
    copy.detection.budget.reset();
    named["contact"].erase("budget");
  }
  LiveSettings live{copy};
  Context context{source};
  scene_format::Reader reader(context, "", named);
  describe(reader, live);
  reader.finish();
  return copy;
}

}  // namespace palpate::view
