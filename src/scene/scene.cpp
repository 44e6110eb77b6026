#include "scene/scene.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include <palpate/error.hpp>

#include "io/file_bytes.hpp"
#include "number_text.hpp"
#include "scene/changes.hpp"
#include "scene/key_lister.hpp"
#include "scene/reader.hpp"
#include "scene/scene_check.hpp"
#include "scene/selector.hpp"
#include "scene/writer.hpp"

namespace palpate {
namespace scene_format {

void Reader::refuse_alternatives(const std::vector<std::string_view>& there,
                                 std::span<const std::string_view> keys) const {
  if (there.size() > 1) {
    fail(context_, key_path(path_, there[1]), "this key together with '" + std::string(there[0]) + "'",
         "only one of the two");
  }
  for (const auto& item : object_.items()) {
    const auto near = nearest_name(item.key(), keys);
    if (near) fail(context_, key_path(path_, item.key()), "unknown key", "'" + std::string(*near) + "'");
  }
  fail(context_, path_, "none of the keys of which one is required", expected_name("", keys));
}

void Reader::refuse_units() const {
  const BrokenRule& first = wrong_units_.front();
  std::string expected = first.expected;
  for (std::size_t i = 1; i < wrong_units_.size(); ++i) {
    const BrokenRule& wrong = wrong_units_[i];
    expected += "; " + wrong.path + ": found " + wrong.found + ", expected " + wrong.expected;
  }
  fail(context_, first.path, first.found, expected);
}

KeyLister::Keys list_scene_keys() {
  KeyLister::Keys keys;
  KeyLister lister("", keys);
  Scene scene;
  describe(lister, scene);
  return keys;
}

}  // namespace scene_format

namespace {

/// Gives bodies without a name the name "body I", and throws Error if two bodies have the same name.
void name_bodies(Scene& scene) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    std::string& name = scene.bodies[i].name;
    if (name.empty()) name = "body " + std::to_string(i);
    if (!names.insert(name).second) {
      throw Error(scene.source, element_path("bodies", i) + ".name", "'" + name + "' for the second time",
                  "a name that no other has");
    }
  }
}

/// Checks that views have different names and show existing bodies.
void check_views(const Scene& scene) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.output.views.size(); ++i) {
    const View& view = scene.output.views[i];
    const std::string path = element_path("output.views", i);
    if (!names.insert(view.name).second) {
      throw Error(scene.source, path + ".name", "'" + view.name + "' for the second time",
                  "a name that no other has");
    }
    check_known(scene, view.bodies, path + ".bodies");
    if (view.cut) check_known(scene, view.cut->bodies, path + ".cut.bodies");
    if (view.displacement) check_known(scene, view.displacement->bodies, path + ".displacement.bodies");
    if (view.field) check_known(scene, view.field->bodies, path + ".field.bodies");
  }
}

/// Checks that pairs with columns in forces.csv are different and consist of existing bodies.
void check_pairs(const Scene& scene) {
  std::set<std::vector<std::string>> pairs;
  for (std::size_t i = 0; i < scene.output.pairs.size(); ++i) {
    const std::vector<std::string>& names = scene.output.pairs[i].bodies.names;
    const std::string path = element_path("output.pairs", i) + ".bodies";
    check_known(scene, scene.output.pairs[i].bodies, path);
    const auto body = std::ranges::find(scene.bodies, names[0], &SceneBody::name);
    if (names[0] == names[1] && !body->self_collision) {
      throw Error(scene.source, path, "'" + names[0] + "' twice, a body without self_collision",
                  "two different bodies");
    }
    if (!pairs.insert(names).second) {
      throw Error(scene.source, path, "'" + names[0] + "' and '" + names[1] + "' for the second time",
                  "a pair that no other has");
    }
  }
}

/// The longest duration of all stages together.
double sum_of_limits(const Scene& scene) {
  double sum = 0.0;
  for (const Stage& stage : scene.stages) sum += stage.until.limit();
  return sum;
}

/// Computes the duration of a run with stages.
void set_duration(Scene& scene, const nlohmann::json& json) {
  if (scene.stages.empty()) return;
  const double sum = sum_of_limits(scene);
  if (json.contains("duration") && scene.duration != sum) {
    throw Error(scene.source, "duration", number_text(scene.duration) + " together with 'stages'",
                "no 'duration', or the sum of the limits of the stages, " + number_text(sum));
  }
  scene.duration = sum;
}

/// Copies the properties of bodies that detection needs.
void copy_self_collision_flags(Scene& scene) {
  std::vector<std::uint8_t>& flags = scene.settings.detection.self_collision;
  flags.clear();
  for (const SceneBody& body : scene.bodies) flags.push_back(body.self_collision ? 1 : 0);
}

/// Lists the pairs of bodies whose contacts are ignored.
void ignore_pairs(Scene& scene) {
  auto& pairs = scene.settings.detection.ignored_pairs;
  pairs.clear();
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const std::vector<std::string>& names = scene.bodies[b].no_contact.names;
    for (std::size_t n = 0; n < names.size(); ++n) {
      const auto body = static_cast<Index>(b);
      const Index other = body_named(scene, names[n], element_path(path_of(b) + ".no_contact", n), body);
      pairs.push_back({std::min(body, other), std::max(body, other)});
    }
  }
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
}

void fill(Scene& scene, const nlohmann::json& json) {
  scene_format::Context context{scene.source};
  scene_format::Reader reader(context, "", json);
  describe(reader, scene);
  reader.finish();
  name_bodies(scene);
  check_views(scene);
  check_pairs(scene);
  set_duration(scene, json);
  check_stages(scene);
  check_outcomes(scene);
  copy_self_collision_flags(scene);
  ignore_pairs(scene);
}

/// A change of a scene by its text, and the path of the changed value in the reader's errors.
struct AppliedChange {
  const std::string& text;
  std::string path;
};

/// The change that gave the value at a key path; null if there is none.
const AppliedChange* change_at(const std::string& where, const std::vector<AppliedChange>& changes) {
  const auto gave = [&](const AppliedChange& change) {
    const std::size_t end = change.path.size();
    return where.starts_with(change.path) && (where.size() == end || where[end] == '.' || where[end] == '[');
  };
  const auto last = std::find_if(changes.rbegin(), changes.rend(), gave);
  return last == changes.rend() ? nullptr : &*last;
}

}  // namespace

Scene read_scene_text(std::string_view text, std::string source_name, std::filesystem::path base_folder,
                      std::span<const std::string> changes) {
  nlohmann::json json = parse_json(text, source_name);
  std::vector<AppliedChange> applied;
  for (const std::string& change : changes)
    applied.push_back({change, apply_change(json, parse_scene_change(change))});
  Scene scene;
  scene.source = std::move(source_name);
  scene.folder = std::move(base_folder);
  try {
    fill(scene, json);
  } catch (const Error& error) {
    const AppliedChange* const change = change_at(error.where(), applied);
    if (change == nullptr) throw;
    throw Error("--set " + change->text, error.where(), error.found(), error.expected());
  }
  return scene;
}

Scene read_scene(const std::filesystem::path& file, std::span<const std::string> changes) {
  return read_scene_text(io::read_file(file, "a scene file"), file.string(), file.parent_path(), changes);
}

namespace {

nlohmann::ordered_json scene_json(const Scene& scene, const nlohmann::ordered_json* defaults = nullptr) {
  scene_format::Writer writer("", defaults, defaults != nullptr);
  // The same functions are used for reading and writing, so they take non-const references.
  Scene copy = scene;
  describe(writer, copy);
  return writer.take();
}

}  // namespace

std::string write_scene(const Scene& scene) {
  return format_json(scene_json(scene));
}

std::string write_brief_scene(const Scene& scene) {
  if (scene.units != Units{}) return write_scene(scene);
  const auto defaults = scene_json(Scene{});
  return format_json(scene_json(scene, &defaults));
}

}  // namespace palpate
