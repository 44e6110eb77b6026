#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/model.hpp>
#include <palpate/simulation.hpp>

#include "measure/section.hpp"

/// Detections of recorded positions, for benchmarks; methods alternate on each frame.
namespace palpate::measure {

/// Bodies, and their positions after each step of a simulation.
struct Recording {
  Bodies bodies{};
  std::vector<std::uint8_t> rigid;        ///< per body
  std::vector<std::vector<Vec3>> frames;  ///< (frames x n_points), the first is the start
};

/// Simulates `steps` steps and keeps the positions of all. Throws what Simulation throws.
Recording record(Model model, const SimulationSettings& settings, int steps, int threads);

/// A method of contact detection.
struct Method {
  std::string name;
  DetectionSettings settings;
  int threads = 1;
};

/// Times of a method for each frame and phase: the smallest of several rounds.
struct MethodTimes {
  std::vector<DetectionTimes> of_frame;
  DetectionCounts last_counts;
  std::size_t structure_bytes = 0;
  std::size_t contacts = 0;  ///< sum over all frames
  std::uint64_t hash =
      0;  ///< of the contacts of all frames; empty but for the first method: all have the same
  double cell_size = 0.0;
  /// Median over the frames without the first, s: of the total, of the update (grid), and of the query (the
  /// rest).
  [[nodiscard]] double median_total() const;
  [[nodiscard]] double median_update() const;
  [[nodiscard]] double median_query() const;
  [[nodiscard]] double median_crossings() const;
};

/// Sum of the phases, s.
double total(const DetectionTimes& times);

/// Runs the methods on each frame one after the other, in rotating order, so that disturbances of the machine
/// affect all; `rounds` times from the start, each time with new detectors. Throws Error if an exact
/// method finds other contacts, depths or directions than the first one.
std::vector<MethodTimes> replay(const Recording& recording, const std::vector<Method>& methods, int rounds);

/// Continues a hash (fnv1a) with contacts: points, bodies, tets, depths and directions.
std::uint64_t hash_of(const Contacts& contacts, std::uint64_t hash);
/// The same with all columns of edge contacts.
std::uint64_t hash_of(const EdgeContacts& contacts, std::uint64_t hash);

/// Adds to the section the times of the methods, without the first frame, and the hash of their contacts.
void add_measures(Section& section, const std::string& scene, const std::vector<Method>& methods,
                  const std::vector<MethodTimes>& times);

}  // namespace palpate::measure
