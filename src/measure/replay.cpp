#include "measure/replay.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "sim/model_check.hpp"
#include "sim/state_hash.hpp"

namespace palpate::measure {
namespace {

double median(const std::vector<DetectionTimes>& frames,
              const std::function<double(const DetectionTimes&)>& of) {
  std::vector<double> values;
  for (std::size_t f = frames.size() > 1 ? 1 : 0; f < frames.size(); ++f) values.push_back(of(frames[f]));
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

void keep_least(DetectionTimes& least, const DetectionTimes& times) {
  for (double DetectionTimes::*phase :
       {&DetectionTimes::grid, &DetectionTimes::contacts, &DetectionTimes::border_edges,
        &DetectionTimes::crossings, &DetectionTimes::depth}) {
    least.*phase = std::min(least.*phase, times.*phase);
  }
}

void require_same(const Contacts& found, const Contacts& expected, const std::string& name,
                  std::size_t frame) {
  if (found.point == expected.point && found.body == expected.body && found.tet == expected.tet &&
      found.depth == expected.depth && found.direction == expected.direction)
    return;
  throw Error("benchmark", name + ", frame " + std::to_string(frame),
              std::to_string(found.size()) + " contacts, or the same contacts with other depths",
              "the contacts and depths of the first method, " + std::to_string(expected.size()));
}

}  // namespace

double total(const DetectionTimes& times) {
  return times.grid + times.contacts + times.border_edges + times.crossings + times.depth;
}

double MethodTimes::median_total() const {
  return median(of_frame, total);
}
double MethodTimes::median_update() const {
  return median(of_frame, [](const DetectionTimes& t) { return t.grid; });
}
double MethodTimes::median_query() const {
  return median(of_frame, [](const DetectionTimes& t) { return total(t) - t.grid; });
}
double MethodTimes::median_crossings() const {
  return median(of_frame, [](const DetectionTimes& t) { return t.crossings; });
}

Recording record(Model model, const SimulationSettings& settings, int steps, int threads) {
  Recording recording;
  recording.bodies = model.bodies;
  recording.rigid = rigid_bodies(model);
  Simulation simulation(std::move(model), settings, threads);
  for (int step = 0; step <= steps; ++step) {
    if (step > 0) simulation.step();
    recording.frames.emplace_back(simulation.positions().begin(), simulation.positions().end());
  }
  return recording;
}

std::uint64_t hash_of(const Contacts& contacts, std::uint64_t hash) {
  const auto add = [&](const auto& values) { hash = fnv1a(std::as_bytes(std::span(values)), hash); };
  add(contacts.point);
  add(contacts.body);
  add(contacts.tet);
  add(contacts.depth);
  add(contacts.direction);
  return hash;
}

std::uint64_t hash_of(const EdgeContacts& contacts, std::uint64_t hash) {
  const auto add = [&](const auto& values) { hash = fnv1a(std::as_bytes(std::span(values)), hash); };
  add(contacts.edge);
  add(contacts.body);
  add(contacts.triangles);
  add(contacts.parameters);
  add(contacts.depth);
  add(contacts.direction);
  return hash;
}

void add_measures(Section& section, const std::string& scene, const std::vector<Method>& methods,
                  const std::vector<MethodTimes>& times) {
  for (std::size_t w = 0; w < methods.size(); ++w) {
    std::vector<double> milliseconds;
    for (std::size_t f = 1; f < times[w].of_frame.size(); ++f)
      milliseconds.push_back(1e3 * total(times[w].of_frame[f]));
    if (!milliseconds.empty())
      section.measures.push_back(measure_of(scene + ", " + methods[w].name, std::move(milliseconds)));
  }
  // A section on several scenes has a hash of all their hashes.
  const std::string both = section.result_hash + hash_text(times.front().hash);
  section.result_hash = section.result_hash.empty() ? both : hash_text(fnv1a(std::as_bytes(std::span(both))));
}

std::vector<MethodTimes> replay(const Recording& recording, const std::vector<Method>& methods, int rounds) {
  std::vector<MethodTimes> results(methods.size());
  for (int round = 0; round < rounds; ++round) {
    std::vector<Detector> detectors;
    detectors.reserve(methods.size());
    for (const Method& method : methods) {
      DetectionSettings settings = method.settings;
      settings.coherence = false;      // structures are compared by the cost of a single frame
      settings.edge_contacts = false;  // the paper has none
      detectors.emplace_back(recording.bodies, settings, recording.rigid, method.threads);
    }
    for (std::size_t frame = 0; frame < recording.frames.size(); ++frame) {
      for (std::size_t place = 0; place < methods.size(); ++place) {
        const std::size_t w = (frame + place) % methods.size();
        detectors[w].detect(recording.frames[frame]);
        MethodTimes& result = results[w];
        if (round == 0) {
          result.of_frame.push_back(detectors[w].times());
          result.contacts += detectors[w].contacts().size();
        } else {
          keep_least(result.of_frame[frame], detectors[w].times());
        }
      }
      if (round == 0)
        results[0].hash = hash_of(detectors[0].contacts(), frame == 0 ? fnv1a({}) : results[0].hash);
      for (std::size_t w = 1; w < methods.size(); ++w) {
        if (!methods[w].settings.cells_per_primitive)
          require_same(detectors[w].contacts(), detectors.front().contacts(), methods[w].name, frame);
      }
    }
    for (std::size_t w = 0; w < methods.size(); ++w) {
      results[w].last_counts = detectors[w].counts();
      results[w].structure_bytes = detectors[w].structure_bytes();
      results[w].cell_size = detectors[w].counts().cell_size;
    }
  }
  return results;
}

}  // namespace palpate::measure
