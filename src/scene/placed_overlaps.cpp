#include "scene/placed_overlaps.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"
#include "scene/selector.hpp"

namespace palpate {
namespace {

/// The mesh of a body as it is now.
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

/// Which bodies a detection of held bodies is about: `ids[b]` is the number of its body b in the scene.
std::vector<PlacedOverlap> overlaps_of(const Detector& detector, const Bodies& bodies,
                                       const std::vector<Index>& ids,
                                       const std::vector<std::uint8_t>& placed) {
  std::map<std::pair<Index, Index>, PlacedOverlap> pairs;
  const auto add = [&](Index a, Index b, double depth) {
    Index first = at(ids, a);
    Index second = at(ids, b);
    if (at(placed, first) == 0) std::swap(first, second);
    if (at(placed, first) == 0) return;
    if (at(placed, second) != 0 && second < first) std::swap(first, second);
    const auto edge = [&](Index body) {
      return mesh_statistics(bodies, bodies.points_rest(), body).edge_length.mean;
    };
    constexpr double touching = 0.01;
    if (depth <= touching * std::min(edge(a), edge(b))) return;
    PlacedOverlap& overlap = pairs.try_emplace({first, second}, PlacedOverlap{first, second}).first->second;
    ++overlap.contacts;
    overlap.deepest = std::max(overlap.deepest, depth);
  };
  const Contacts& contacts = detector.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c)
    add(at(bodies.body_of_point(), contacts.point[c]), contacts.body[c], contacts.depth[c]);
  const EdgeContacts& edges = detector.edge_contacts();
  for (std::size_t c = 0; c < edges.size(); ++c)
    add(bodies.body_of(at(bodies.edges(), edges.edge[c])), edges.body[c], edges.depth[c]);
  std::vector<PlacedOverlap> list;
  list.reserve(pairs.size());
  for (const auto& [key, overlap] : pairs) list.push_back(overlap);
  return list;
}

}  // namespace

PlacedOverlaps::PlacedOverlaps(const Scene& scene, const Bodies& bodies) {
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
  Detector detector(held, DetectionSettings{}, {}, 1);
  detector.detect(held.points_rest());
  return overlaps_of(detector, held, ids, placed_);
}

}  // namespace palpate
