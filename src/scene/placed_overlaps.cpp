#include "scene/placed_overlaps.hpp"

#include <algorithm>
#include <utility>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"
#include "scene/overlaps.hpp"
#include "scene/selector.hpp"

namespace palpate {
namespace {

/// The mesh of a body at its current positions.
TetMesh mesh_now(const Simulation& simulation, Index body) {
  const Body& range = at(simulation.bodies().bodies(), body);
  TetMesh mesh;
  for (Index p = range.points.begin; p < range.points.end; ++p)
    mesh.points.push_back(at(simulation.positions(), p));
  for (Index t = range.tets.begin; t < range.tets.end; ++t) {
    Tet tet = at(simulation.bodies().tets(), t);
    for (Index& corner : tet) corner -= range.points.begin;
    mesh.tets.push_back(tet);
  }
  return mesh;
}

bool all_points_move(const Simulation& simulation, Index body) {
  const Range points = at(simulation.bodies().bodies(), body).points;
  for (Index p = points.begin; p < points.end; ++p) {
    if (at(simulation.motion_of_points(), p) < 0) return false;
  }
  return true;
}

/// Of these pairs of bodies the ones of `ids`, as their places in `ids`. The ids are in increasing order.
std::vector<std::array<Index, 2>> pairs_among(const std::vector<std::array<Index, 2>>& pairs,
                                              const std::vector<Index>& ids) {
  const auto place = [&](Index id) { return std::ranges::lower_bound(ids, id); };
  std::vector<std::array<Index, 2>> among;
  for (const auto& [a, b] : pairs) {
    if (!std::ranges::binary_search(ids, a) || !std::ranges::binary_search(ids, b)) continue;
    among.push_back({static_cast<Index>(place(a) - ids.begin()), static_cast<Index>(place(b) - ids.begin())});
  }
  return among;
}

}  // namespace

PlacedOverlaps::PlacedOverlaps(const Scene& scene, const Bodies& bodies)
    : ignored_(scene.settings.detection.ignored_pairs) {
  rigid_.resize(bodies.bodies().size());
  placed_.resize(rigid_.size());
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    rigid_[b] = is_rigid(scene.bodies[b]) ? 1 : 0;
    placed_[b] = scene.bodies[b].motion ? 1 : 0;
  }
  const auto place = [&](const std::string& name) { at(placed_, body_named(scene, name, "stages", -1)) = 1; };
  for (const Stage& stage : scene.stages) {
    std::ranges::for_each(stage.insert.names, place);
    for (const StageMove& move : stage.move) {
      if (!move.part) place(move.body);
    }
  }
}

std::vector<PlacedOverlap> PlacedOverlaps::find(const Simulation& simulation) const {
  std::vector<Index> ids;
  Bodies held;
  bool any = false;
  for (Index b = 0; b < simulation.bodies().body_count(); ++b) {
    const bool is_held = at(rigid_, b) != 0 || (at(placed_, b) != 0 && all_points_move(simulation, b));
    if (!simulation.is_present(b) || !is_held) continue;
    any = any || at(placed_, b) != 0;
    ids.push_back(b);
    held.add(at(simulation.bodies().bodies(), b).name, mesh_now(simulation, b));
  }
  if (!any || ids.size() < 2) return {};
  DetectionSettings settings;
  settings.ignored_pairs = pairs_among(ignored_, ids);
  Detector detector(held, settings, {}, 1);
  detector.detect(held.points_rest());
  const auto mean_edge = [&](Index body) {
    return mesh_statistics(held, held.points_rest(), body).edge_length.mean;
  };
  constexpr double touching = 0.01;
  std::vector<PlacedOverlap> list;
  for (const Overlap& overlap : overlaps(held, detector)) {
    Index first = at(ids, overlap.first);
    Index second = at(ids, overlap.second);
    if (at(placed_, first) == 0) std::swap(first, second);
    if (at(placed_, first) == 0) continue;
    if (overlap.deepest <= touching * std::min(mean_edge(overlap.first), mean_edge(overlap.second))) continue;
    list.push_back({first, second, overlap.contacts, overlap.deepest});
  }
  std::ranges::sort(list, {}, [](const PlacedOverlap& o) { return std::pair(o.placed, o.other); });
  return list;
}

}  // namespace palpate
