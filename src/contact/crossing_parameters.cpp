#include "contact/crossing_parameters.hpp"

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "simd/crossing_parameters.hpp"

namespace palpate {

void find_parameters(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     const BorderEdgeView& border, std::span<const EdgeInTriangle> found,
                     std::span<Crossing> crossings) {
  const simd::CrossedTriangles all{positions, border.points(), border.edges(), bodies.triangles()};
  parallel::for_chunks(threads, found.size(), 1024, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) crossings[i] = {found[i].border_edge, found[i].triangle, 0.0};
    const std::span<Crossing> own = crossings.subspan(begin, end - begin);
    if (simd::find_parameters(all, own)) return;
    for (auto& [edge, triangle, parameter] : own) {
      if (parameter >= 0.0) continue;
      const auto [in, out] = border.ends(edge);
      const auto& [t0, t1, t2] = at(bodies.triangles(), triangle);
      parameter = crossing_parameter(at(positions, in), at(positions, out), at(positions, t0),
                                     at(positions, t1), at(positions, t2));
    }
  });
}

}  // namespace palpate
