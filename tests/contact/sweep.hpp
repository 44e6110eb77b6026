#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>
#include <cstdio>
#include <cstdlib>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"

namespace palpate::test {

/// How much a contact changed from one step of a sweep to the next.
struct Jump {
  int step = 0;
  Index point = -1;
  Index body = -1;
  double size = 0.0;
};

/// What a sweep met: jumps of contacts that were there in two steps in a row.
struct SweepReport {
  int steps = 0;
  std::size_t pairs = 0;     ///< contacts compared
  double largest_motion = 0.0;  ///< of a point in one step
  double deepest = 0.0;
  Jump depth;      ///< largest change of a depth
  Jump direction;  ///< largest change of a direction, degrees
  std::size_t fallbacks = 0;
  DetectionTimes times;
};

/// Moves the points of `bodies` by `place(step)` and compares each step's contacts with those of the last.
/// `counts(c)`: whether contact c of a detector is looked at.
inline SweepReport sweep(const Bodies& bodies, Detector& detector, int steps,
                         const std::function<void(int, std::vector<Vec3>&)>& place) {
  SweepReport report;
  report.steps = steps;
  std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
  std::vector<Vec3> last_x;
  Contacts last;
  DetectionCounts last_counts;
  for (int step = 0; step < steps; ++step) {
    place(step, x);
    detector.detect(x);
    const Contacts& now = detector.contacts();
    report.times.contacts += detector.times().contacts;
    report.times.crossings += detector.times().crossings;
    report.times.depth += detector.times().depth;
    report.fallbacks += detector.counts().depth_fallbacks;
    for (std::size_t i = 0; i < last_x.size(); ++i) {
      report.largest_motion = std::max(report.largest_motion, length(x[i] - last_x[i]));
    }
    std::size_t l = 0;
    for (std::size_t c = 0; c < now.size(); ++c) {
      report.deepest = std::max(report.deepest, now.depth[c]);
      const auto key = std::pair(now.point[c], now.body[c]);
      while (l < last.size() && std::pair(last.point[l], last.body[l]) < key) ++l;
      if (l == last.size() || std::pair(last.point[l], last.body[l]) != key) continue;
      ++report.pairs;
      const double jump = std::abs(now.depth[c] - last.depth[l]);
      if (jump > report.depth.size) report.depth = {step, key.first, key.second, jump};
      if (getenv("SWEEP_DEBUG") && jump > 8 * length(x[0]-last_x[0]) + 8 * length(x.back()-last_x.back())) {
        std::printf("  step %d point %d body %d d %.4f -> %.4f  r (%.2f %.2f %.2f) -> (%.2f %.2f %.2f) regions %zu -> %zu raised %zu contacts %zu->%zu nocross %zu border %zu\n", step, key.first, key.second, last.depth[l], now.depth[c], last.direction[l].x,last.direction[l].y,last.direction[l].z, now.direction[c].x,now.direction[c].y,now.direction[c].z, last_counts.regions_without_border, detector.counts().regions_without_border, detector.counts().raised_depths, last.size(), now.size(), detector.counts().border_edges_without_crossing, detector.counts().border_edges);
      }
      const double half = std::min(1.0, 0.5 * length(now.direction[c] - last.direction[l]));
      const double turn = 2.0 * std::asin(half) * 57.29577951308232;
      if (turn > report.direction.size) report.direction = {step, key.first, key.second, turn};
    }
    last = now;
    last_counts = detector.counts();
    last_x = x;
  }
  return report;
}

}  // namespace palpate::test
