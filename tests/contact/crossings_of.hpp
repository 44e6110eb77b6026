#pragma once

#include <span>

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/contact_table.hpp"
#include "contact/crossing_query.hpp"
#include "contact/crossings.hpp"

namespace palpate::test {

/// The crossings of border edges, by testing all pairs.
inline Crossings crossings_of(const Bodies& bodies, std::span<const Vec3> positions,
                              const ContactTable& table, const BorderEdges& border_edges) {
  DetectionSettings settings;
  settings.structure = Structure::brute;
  settings.cell_size = 1.0;
  Frame frame(bodies, settings, {}, 1);
  frame.place(positions, nullptr);
  const BorderEdgeView border{table.contacts(), border_edges.edges()};
  const auto query = make_crossing_query(bodies, settings);
  query->find(frame, border, {});
  Crossings crossings;
  crossings.set(frame.threads(), bodies, positions, border, query->found());
  return crossings;
}

}  // namespace palpate::test
