// Construction of a detector.
#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "contact/detector_state.hpp"

namespace palpate {
namespace {

AnyStructure make_structure(Structure structure, Order order, Sort sort) {
  switch (structure) {
    case Structure::uniform:
      return UniformGrid{order};
    case Structure::compact:
      return CompactGrid{order, sort};
    case Structure::hash:
      return HashGrid{};
    case Structure::cuckoo:
      return CuckooGrid{order};
    case Structure::brute:
      return BruteForce{};
  }
  throw Error("detection settings", "structure", std::to_string(static_cast<int>(structure)),
              "a known structure");
}

/// The pairs of bodies that a setting lists, sorted, with the lower body first in each.
/// \param bodies  number of bodies
std::vector<std::array<Index, 2>> sorted_pairs(std::vector<std::array<Index, 2>> pairs, Index bodies) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    auto& [a, b] = pairs[i];
    if (a > b) std::swap(a, b);
    if (a < 0 || b >= bodies || a == b) {
      throw Error("detection settings", "ignored_pairs[" + std::to_string(i) + "]",
                  "bodies " + std::to_string(a) + " and " + std::to_string(b),
                  "two different bodies in [0, " + std::to_string(bodies - 1) + "]");
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace

Detector::State::State(const Bodies& b, const DetectionSettings& s, std::vector<std::uint8_t> i, int n)
    : bodies(b), settings(s), immovable(std::move(i)), threads(n), border_edges(b), depth(b) {
  if (bodies.body_count() == 0) throw Error("detector", "bodies", "none", "at least one");
  if (immovable.empty()) immovable.assign(bodies.bodies().size(), 0);
  if (immovable.size() != bodies.bodies().size()) {
    throw Error("detection settings", "immovable", std::to_string(immovable.size()) + " flags",
                std::to_string(bodies.bodies().size()) + ", one for each body");
  }
  std::vector<std::uint8_t>& self = settings.self_collision;
  if (self.empty()) self.assign(bodies.bodies().size(), 0);
  if (self.size() != bodies.bodies().size()) {
    throw Error("detection settings", "self_collision", std::to_string(self.size()) + " flags",
                std::to_string(bodies.bodies().size()) + ", one for each body");
  }
  settings.ignored_pairs = sorted_pairs(std::move(settings.ignored_pairs), bodies.body_count());
  if (settings.cells_per_primitive &&
      (*settings.cells_per_primitive < 1 || *settings.cells_per_primitive > CellSlots::most)) {
    throw Error("detection settings", "cells_per_primitive", std::to_string(*settings.cells_per_primitive),
                "1 to 27, or none for exact");
  }
  check_cell_size(settings.cell_size);
  in_a_tet.resize(bodies.points_rest().size());
  for (std::size_t p = 0; p < in_a_tet.size(); ++p) {
    in_a_tet[p] = bodies.point_tets()[static_cast<Index>(p)].empty() ? 0 : 1;
  }
  points = make_structure(settings.structure, settings.order, settings.sort);
  edges = make_structure(settings.structure, settings.order, settings.sort);
  if (settings.budget) budget = std::make_unique<DetectionBudget>(settings, bodies.bodies().size());
  if (settings.edge_contacts && bodies.body_count() > 1)
    edge_contacts = std::make_unique<EdgeContactQuery>(bodies);
  // In approximate mode, slots belong to single tets.
  if (settings.structure == Structure::compact && !settings.cells_per_primitive) {
    cluster_query = std::make_unique<ClusterQuery>(bodies);
    crossings.use_clusters(bodies);
    fixed = std::make_unique<FixedPositions>(in_a_tet, marks_of_immovable());
  }
}

std::vector<std::uint8_t> Detector::State::marks_of_immovable() const {
  std::vector<std::uint8_t> marks(in_a_tet.size());
  for (std::size_t p = 0; p < marks.size(); ++p) marks[p] = at(immovable, bodies.body_of_point()[p]);
  return marks;
}

Detector::Detector(const Bodies& bodies, const DetectionSettings& settings,
                   std::vector<std::uint8_t> immovable, int threads)
    : state_(std::make_unique<State>(bodies, settings, std::move(immovable), threads)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

}  // namespace palpate
