// The parts of a detection after the query of contacts, frame by frame; and border edges against triangles,
// compared with Embree.
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

DetectionSettings settings_of(const measure::QueryScene& scene, bool coherence) {
  DetectionSettings settings;
  settings.self_collision = scene.self_collision;
  settings.coherence = coherence;
  return settings;
}

/// Contacts, border edges, crossings and depths, with and without coherence: medians in ms.
Json whole_detection(const measure::QueryScene& scene, std::uint32_t frames) {
  Json result{{"name", scene.name}, {"frames", frames}};
  for (const bool coherence : {false, true}) {
    Detector detector(scene.bodies, settings_of(scene, coherence), {}, 1);
    std::vector<double> all;
    std::vector<double> contacts;
    std::vector<Vec3> positions;
    for (std::uint32_t frame = 0; frame < handling_warm_up + frames; ++frame) {
      scene.place(frame, positions);
      const double start = processor_time();
      detector.detect(positions);
      if (frame < handling_warm_up) continue;
      all.push_back(processor_time() - start);
      contacts.push_back(detector.times().grid + detector.times().contacts);
    }
    result[coherence ? "coherent" : "clustered"] = {{"all_ms", 1e3 * median(all)},
                                                    {"contacts_ms", 1e3 * median(contacts)}};
    result["counts"] = {{"contacts", detector.counts().contacts},
                        {"border_edges", detector.counts().border_edges},
                        {"crossings", detector.counts().crossings}};
  }
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
  return {"handling",
          {{"border edges", 1e4, [=] { return border_edges(scene(), frames); }},
           {"whole detection", 1e4,
            [=] { return whole_detection(scene(), static_cast<std::uint32_t>(frames)); }}},
          handling_rows};
}

}  // namespace palpate::bench
