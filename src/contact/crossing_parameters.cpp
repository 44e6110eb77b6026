#include "contact/crossing_parameters.hpp"

#include <algorithm>

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "simd/crossing_parameters.hpp"

namespace palpate {

namespace {

/// Computes where border edges cross the triangles that they meet.
struct Finder {
  const Bodies& bodies;
  std::span<const Vec3> positions;
  BorderEdgeView border;

  [[nodiscard]] double parameter(const EdgeInTriangle& found) const {
    const auto [in, out] = border.ends(found.border_edge);
    const auto& [t0, t1, t2] = at(bodies.triangles(), found.triangle);
    return crossing_parameter(at(positions, in), at(positions, out), at(positions, t0), at(positions, t1),
                              at(positions, t2));
  }
  /// Computes at most as many parameters as there are lanes.
  void parameters(std::span<const EdgeInTriangle> found, simd::SegmentsInTriangles& segments,
                  std::span<Crossing> crossings) const {
    for (std::size_t lane = 0; lane < found.size(); ++lane) {
      const auto ends = border.ends(found[lane].border_edge);
      const Triangle& triangle = at(bodies.triangles(), found[lane].triangle);
      for (std::size_t k = 0; k < 2; ++k) segments.end[k][lane] = ends[k];
      for (std::size_t k = 0; k < 3; ++k) segments.corner[k][lane] = triangle[k];
    }
    simd::find_parameters(positions.data(), segments, found.size());
    for (std::size_t lane = 0; lane < found.size(); ++lane) {
      const double quick = segments.parameter[lane];
      crossings[lane] = {found[lane].border_edge, found[lane].triangle,
                         quick >= 0.0 ? quick : parameter(found[lane])};
    }
  }
};

}  // namespace

void find_parameters(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     const BorderEdgeView& border, std::span<const EdgeInTriangle> found,
                     std::span<Crossing> crossings) {
  constexpr std::size_t lanes = simd::SegmentsInTriangles::most;
  const Finder finder{bodies, positions, border};
  parallel::for_chunks(threads, found.size(), 16 * lanes,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::SegmentsInTriangles segments;
                         for (std::size_t i = begin; i < end; i += lanes) {
                           const std::size_t n = std::min(lanes, end - i);
                           finder.parameters(found.subspan(i, n), segments, crossings.subspan(i, n));
                         }
                       });
}

}  // namespace palpate
