#include "scene/coarse_pairs.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "contact/local_thickness.hpp"
#include "contact/surface_clusters.hpp"
#include "geometry/vector.hpp"

namespace palpate {
namespace {

/// Edge over thickness up to which a mesh is fine enough. It is about one where both bodies have a single
/// layer of regular tets. Of organs of unlike resolution, the finer one has points enough for both.
constexpr double fine_enough = 3.0;

double mean_surface_edge(const Bodies& bodies, const Range& triangles) {
  double sum = 0.0;
  for (Index t = triangles.begin; t < triangles.end; ++t) {
    const Triangle& corners = at(bodies.triangles(), t);
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3& p = at(bodies.points_rest(), corners[c]);
      sum += length(at(bodies.points_rest(), corners[(c + 1) % 3]) - p);
    }
  }
  return triangles.size() > 0 ? sum / (3.0 * triangles.size()) : 0.0;
}

/// What a tenth of the values are below.
double lowest_tenth(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::infinity();
  const auto tenth = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 10);
  std::ranges::nth_element(values, tenth);
  return *tenth;
}

}  // namespace

std::vector<CoarsePair> coarse_pairs(const Bodies& bodies, std::span<const std::uint8_t> immovable) {
  const LocalThickness thickness(bodies, SurfaceClusters(bodies).clusters);
  std::vector<double> edges;
  std::vector<double> thin;
  for (const Body& body : bodies.bodies()) {
    const auto first = thickness.of_triangle.begin();
    edges.push_back(mean_surface_edge(bodies, body.triangles));
    thin.push_back(lowest_tenth({first + body.triangles.begin, first + body.triangles.end}));
  }
  std::vector<CoarsePair> pairs;
  const auto is_coarse = [&](Index a, Index b) { return at(edges, a) > fine_enough * at(thin, b); };
  for (Index a = 0; a < bodies.body_count(); ++a) {
    for (Index b = a + 1; b < bodies.body_count(); ++b) {
      if (!immovable.empty() && at(immovable, a) != 0 && at(immovable, b) != 0) continue;
      if (is_coarse(a, b) && is_coarse(b, a))
        pairs.push_back({{a, b}, {at(edges, a), at(edges, b)}, {at(thin, a), at(thin, b)}});
    }
  }
  std::ranges::stable_sort(pairs, std::ranges::greater{}, [](const CoarsePair& p) {
    constexpr double least = 1e-150;
    return std::min(p.edges[0] / std::max(p.thickness[1], least),
                    p.edges[1] / std::max(p.thickness[0], least));
  });
  return pairs;
}

}  // namespace palpate
