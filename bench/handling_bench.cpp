#include "handling_bench.hpp"

#include <vector>

#include <palpate/detection.hpp>

#include "timing.hpp"

namespace palpate::bench {
namespace {

constexpr std::uint32_t warm_up = 4;

DetectionSettings settings_of(const measure::QueryScene& scene, bool coherence) {
  DetectionSettings settings;
  settings.self_collision = scene.self_collision;
  settings.coherence = coherence;
  return settings;
}

}  // namespace

nlohmann::json measure_handling(const measure::QueryScene& scene, std::uint32_t frames) {
  nlohmann::json result;
  for (const bool coherence : {false, true}) {
    Detector detector(scene.bodies, settings_of(scene, coherence), {}, 1);
    std::vector<double> all;
    std::vector<double> contacts;
    std::vector<Vec3> positions;
    for (std::uint32_t frame = 0; frame < warm_up + frames; ++frame) {
      scene.place(frame, positions);
      const double start = processor_time();
      detector.detect(positions);
      if (frame < warm_up) continue;
      all.push_back(processor_time() - start);
      contacts.push_back(detector.times().grid + detector.times().contacts);
    }
    nlohmann::json& way = result[coherence ? "coherent" : "clustered"];
    way["all_ms"] = 1e3 * median(all);
    way["contacts_ms"] = 1e3 * median(contacts);
    result["contacts"] = detector.counts().contacts;
    result["border_edges"] = detector.counts().border_edges;
    result["crossings"] = detector.counts().crossings;
  }
  return result;
}

}  // namespace palpate::bench
