#include "scene/scene_check.hpp"

#include <algorithm>
#include <set>
#include <string_view>
#include <variant>
#include <vector>

#include <palpate/error.hpp>

#include "scene/json_text.hpp"
#include "scene/suggest.hpp"

namespace palpate {
namespace {

template <class List>
void check_names(const Scene& scene, const List& list, const char* key) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (names.insert(list[i].name).second) continue;
    throw Error(scene.source, element_path(key, i) + ".name", "'" + list[i].name + "' for the second time",
                "a name that no other has");
  }
}

/// The body that each item of a list refers to.
template <class List>
void check_each(const Scene& scene, const List& list, const std::string& path) {
  for (std::size_t i = 0; i < list.size(); ++i)
    check_known(scene, list[i].body, element_path(path, i) + ".body");
}

void check_stage(const Scene& scene, const Stage& stage, const std::string& path) {
  check_known(scene, stage.insert, path + ".insert");
  check_known(scene, stage.remove, path + ".remove");
  check_each(scene, stage.release, path + ".release");
  check_each(scene, stage.fix, path + ".fix");
  check_each(scene, stage.move, path + ".move");
  check_each(scene, stage.tie, path + ".tie");
  check_each(scene, stage.loads, path + ".loads");
  for (std::size_t i = 0; i < stage.untie.size(); ++i)
    check_known(scene, stage.untie[i].bodies, element_path(path + ".untie", i) + ".bodies");
  if (!stage.until.force) return;
  check_known(scene, stage.until.force->body, path + ".until.force.body");
  if (stage.until.force->from) check_known(scene, *stage.until.force->from, path + ".until.force.from");
}

/// Checks the bodies that an outcome names.
struct OutcomeCheck {
  const Scene& scene;
  std::string path;

  void operator()(const DisplacementOutcome& of) const { one(of.body, ".displacement"); }
  void operator()(const RotationOutcome& of) const { one(of.body, ".rotation"); }
  void operator()(const DistanceOutcome& of) const {
    one(of.from.body, ".distance.from");
    one(of.to.body, ".distance.to");
  }
  void operator()(const VolumeOutcome& of) const {
    one(of.body, ".volume");
    if (of.within) check_known(scene, *of.within, path + ".volume.within");
  }
  void operator()(const CavityOutcome& of) const { one(of.body, ".cavity"); }
  void operator()(const GapOutcome& of) const { check_known(scene, of.bodies, path + ".gap.bodies"); }
  void operator()(const ContactAreaOutcome& of) const {
    check_known(scene, of.bodies, path + ".contact_area.bodies");
  }
  void operator()(const StressOutcome& of) const { one(of.body, ".stress"); }
  void operator()(const ForceOutcome& of) const {
    one(of.body, ".force");
    if (of.from) check_known(scene, *of.from, path + ".force.from");
  }

 private:
  void one(const std::string& body, const char* key) const { check_known(scene, body, path + key + ".body"); }
};

}  // namespace

void check_known(const Scene& scene, const std::string& body, const std::string& path) {
  std::vector<std::string_view> known;
  known.reserve(scene.bodies.size());
  for (const SceneBody& other : scene.bodies) known.emplace_back(other.name);
  if (std::ranges::count(known, body) > 0) return;
  throw Error(scene.source, path, "'" + body + "'", expected_name(body, known));
}

void check_known(const Scene& scene, const BodyNames& bodies, const std::string& path) {
  for (std::size_t i = 0; i < bodies.names.size(); ++i)
    check_known(scene, bodies.names[i], element_path(path, i));
}

void check_stages(const Scene& scene) {
  check_names(scene, scene.stages, "stages");
  for (std::size_t i = 0; i < scene.stages.size(); ++i)
    check_stage(scene, scene.stages[i], element_path("stages", i));
}

void check_outcomes(const Scene& scene) {
  check_names(scene, scene.outcomes, "outcomes");
  for (std::size_t i = 0; i < scene.outcomes.size(); ++i)
    std::visit(OutcomeCheck{scene, element_path("outcomes", i)}, scene.outcomes[i].of);
}

}  // namespace palpate
