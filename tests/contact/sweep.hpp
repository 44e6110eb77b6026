#pragma once

#include <algorithm>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"

namespace palpate::test {

/// A change of a contact from one step of a sweep to the next.
struct Jump {
  double size = 0.0;
  int step = 0;  ///< the later of the two
  Index point = -1;
  void take(double other, int at_step, Index of_point) {
    if (other > size) *this = {other, at_step, of_point};
  }
};

/// What a sweep met: the largest changes of contacts that were there in two steps in a row.
struct SweepReport {
  std::size_t pairs = 0;  ///< contacts compared
  double motion = 0.0;    ///< largest motion of a point in one step
  double deepest = 0.0;
  Jump depth;      ///< change of depth
  Jump direction;  ///< change of direction, times the smaller certainty and depth
  Jump swallowed;  ///< change of depth where the number of regions without border changed; not in `depth`
  Jump rotation;   ///< length of the change of direction
  std::size_t regions_without_border = 0;
  std::size_t fallbacks = 0;
};

/// Detects at positions(s) for s = first, first + stride, ... (n of them) and compares each with the last.
inline SweepReport sweep(Detector& detector, double first, double stride, int n,
                         const std::function<std::vector<Vec3>(double)>& positions) {
  SweepReport report;
  std::vector<Vec3> last_x;
  Contacts last;
  std::size_t last_regions = 0;
  for (int step = 0; step < n; ++step) {
    const std::vector<Vec3> x = positions(first + stride * step);
    detector.detect(x);
    const Contacts& now = detector.contacts();
    report.fallbacks += detector.counts().depth_fallbacks;
    report.regions_without_border += detector.counts().regions_without_border;
    for (std::size_t i = 0; i < last_x.size(); ++i)
      report.motion = std::max(report.motion, length(x[i] - last_x[i]));
    const auto key = [](const Contacts& c, std::size_t i) { return std::pair(c.point[i], c.body[i]); };
    std::size_t l = 0;
    for (std::size_t c = 0; c < now.size(); ++c) {
      report.deepest = std::max(report.deepest, now.depth[c]);
      while (l < last.size() && key(last, l) < key(now, c)) ++l;
      if (l == last.size() || key(last, l) != key(now, c)) continue;
      ++report.pairs;
      const bool steady = detector.counts().regions_without_border == last_regions;
      (steady ? report.depth : report.swallowed)
          .take(std::abs(now.depth[c] - last.depth[l]), step, now.point[c]);
      const double rotation = length(now.direction[c] - last.direction[l]);
      report.rotation.take(rotation, step, now.point[c]);
      report.direction.take(
          rotation * std::min(now.certainty[c], last.certainty[l]) * std::min(now.depth[c], last.depth[l]),
          step, now.point[c]);
    }
    last = now;
    last_x = x;
    last_regions = detector.counts().regions_without_border;
  }
  return report;
}

}  // namespace palpate::test
