#include <array>
#include <cmath>

#include <palpate/mesh.hpp>

#include "measure/paper.hpp"

namespace palpate::measure {
namespace {

struct PaperCounts {
  const char* scene;
  std::array<double, 4> counts;  ///< points, edges, triangles, tets
};
constexpr std::array<PaperCounts, 3> table_1{{{"stacking", {4840, 19620, 9600, 10000}},
                                              {"eye", {3167, 16248, 6472, 9819}},
                                              {"skull", {8293, 38352, 13592, 23225}}}};
constexpr std::array<const char*, 4> kinds{"points", "edges", "triangles", "tets"};

}  // namespace

double parallel_fraction(double speed_up, int threads) {
  return threads < 2 ? 0.0 : (1.0 - 1.0 / speed_up) / (1.0 - 1.0 / threads);
}

Section scene_statistics(const std::vector<PaperScene>& scenes) {
  Section section{.id = "table-1",
                  .title = "Table 1: scene statistics",
                  .paper = "Stacking, eye and skull with 10000, 9819 and 23225 tetrahedra.",
                  .ours =
                      "The same stack; eye and skull are other meshes of the same organs, made to the "
                      "paper's counts (tets within 5 %, the rest within 20 %).",
                  .table = {{"scene", "kind", "paper", "ours", "difference in %"}, {}}};
  bool close = true;
  for (const PaperScene& scene : scenes) {
    const MeshStatistics ours = mesh_statistics(scene.model.bodies, scene.model.bodies.points_rest());
    const std::array<double, 4> counts{static_cast<double>(ours.points), static_cast<double>(ours.edges),
                                       static_cast<double>(ours.triangles), static_cast<double>(ours.tets)};
    for (const PaperCounts& paper : table_1) {
      if (scene.name != paper.scene) continue;
      for (std::size_t k = 0; k < kinds.size(); ++k) {
        const double difference = 100.0 * (counts[k] / paper.counts[k] - 1.0);
        close = close && std::abs(difference) <= (k == 3 ? 5.0 : 20.0);
        section.table.rows.push_back({scene.name, kinds[k], paper.counts[k], counts[k], difference});
      }
    }
  }
  section.verdict = close ? Verdict::agrees : Verdict::differs;
  section.why = close ? "all counts are within our own bounds" : "a count is outside our own bounds";
  return section;
}

}  // namespace palpate::measure
