// The parts of a detection after the query of contacts, frame by frame; and border edges against triangles,
// compared with Embree.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "measure/query_scenes.hpp"
#include "peers/contest.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

constexpr std::uint32_t handling_warm_up = 4;
constexpr int handling_frames = 41;

/// A method of detection. All of them take turns with each frame.
struct Method {
  const char* name;
  bool coherence;
  bool edge_contacts = true;
};

struct Times {
  std::vector<double> all;
  std::vector<double> contacts;
  [[nodiscard]] Json medians() const {
    return {{"all_ms", 1e3 * median(all)}, {"contacts_ms", 1e3 * median(contacts)}};
  }
};

/// Contacts, border edges, crossings and depths by each method: medians in ms.
Json detections(const measure::QueryScene& scene, std::span<const Method> methods, std::uint32_t frames) {
  std::vector<Detector> detectors;
  for (const Method& method : methods) {
    DetectionSettings settings;
    settings.self_collision = scene.self_collision;
    settings.coherence = method.coherence;
    settings.edge_contacts = method.edge_contacts;
    detectors.emplace_back(scene.bodies, settings, std::vector<std::uint8_t>{}, 1);
  }
  std::vector<Times> times(methods.size());
  std::vector<Vec3> positions;
  for (std::uint32_t frame = 0; frame < handling_warm_up + frames; ++frame) {
    scene.place(frame, positions);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const double start = processor_time();
      detectors[m].detect(positions);
      const double taken = processor_time() - start;
      if (frame < handling_warm_up) continue;
      times[m].all.push_back(taken);
      times[m].contacts.push_back(detectors[m].times().grid + detectors[m].times().contacts);
    }
  }
  Json result;
  for (std::size_t m = 0; m < methods.size(); ++m) result[methods[m].name] = times[m].medians();
  const DetectionCounts& counts = detectors.front().counts();
  result["counts"] = {
      {"contacts", counts.contacts}, {"border_edges", counts.border_edges}, {"crossings", counts.crossings}};
  return result;
}

Json whole_detection(const measure::QueryScene& scene, std::uint32_t frames) {
  constexpr std::array methods{Method{"clustered", false}, Method{"coherent", true},
                               Method{"points alone", false, false}};
  Json result{{"name", scene.name}, {"frames", frames}};
  result.update(detections(scene, methods, frames));
  return result;
}

/// Points move by up to a ten thousandth of what they move by in the other cases: less than any margin within
/// which candidates are kept.
Json detection_at_rest(measure::QueryScene scene, std::uint32_t frames) {
  constexpr std::array methods{Method{"clustered", false}, Method{"coherent", true}};
  scene.tremble *= 1e-4;
  scene.shift = 0.0;
  Json result{{"name", scene.name}, {"frames", frames}};
  result["at_rest"] = detections(scene, methods, frames);
  return result;
}

/// Border edges against triangles, by us and by the fastest mode of Embree.
Json border_edges(const measure::QueryScene& scene, int frames) {
  const Course course{scene, scene.immovable(), Task::edges_on_triangles};
  std::vector<Entrant> entrants;
  add_ours(course, {1}, entrants);
  add_embree(course, {1}, entrants);
  // A contest takes as many frames as it has time for, 3 to 41.
  const ContestResult result = run_contest(course, std::move(entrants), {.seconds = frames < 41 ? 0.0 : 1e3});
  Json json{{"name", scene.name}, {"frames", result.frames}, {"edges", result.edges}};
  for (const Performance& p : result.performances) {
    if (p.name == "Palpate") {
      json["border_edges"]["ms"] = median(p.milliseconds);
    } else {
      json["border_edges"]["embree_ms"] = median(p.milliseconds);
      json["border_edges"]["embree_mode"] = p.mode;
    }
  }
  return json;
}

}  // namespace

Part handling_part(const SpeedEffort& effort) {
  const int frames = effort.frames_or(handling_frames);
  const auto scene = [] { return measure::stacking_scene(10); };
  return {
      "handling",
      {{"border edges", 1e4, [=] { return border_edges(scene(), frames); }},
       {"whole detection", 1e4, [=] { return whole_detection(scene(), static_cast<std::uint32_t>(frames)); }},
       {"detection at rest", 1e4,
        [=] { return detection_at_rest(scene(), static_cast<std::uint32_t>(frames)); }}},
      handling_rows};
}

}  // namespace palpate::bench
