#pragma once

#include <gtest/gtest.h>

#include <palpate/detection.hpp>

namespace palpate::test {

/// What a detection finds, to the bit.
inline void expect_same(const Detector& a, const Detector& b) {
  ASSERT_EQ(a.contacts().point, b.contacts().point);
  ASSERT_EQ(a.contacts().body, b.contacts().body);
  ASSERT_EQ(a.contacts().tet, b.contacts().tet);
  ASSERT_EQ(a.contacts().weights, b.contacts().weights);
  ASSERT_EQ(a.contacts().depth, b.contacts().depth);
  ASSERT_EQ(a.contacts().direction, b.contacts().direction);
  ASSERT_EQ(a.contacts().certainty, b.contacts().certainty);
  ASSERT_EQ(a.edge_contacts().edge, b.edge_contacts().edge);
  ASSERT_EQ(a.edge_contacts().body, b.edge_contacts().body);
  ASSERT_EQ(a.edge_contacts().triangles, b.edge_contacts().triangles);
  ASSERT_EQ(a.edge_contacts().parameters, b.edge_contacts().parameters);
  ASSERT_EQ(a.edge_contacts().depth, b.edge_contacts().depth);
  ASSERT_EQ(a.edge_contacts().direction, b.edge_contacts().direction);
  ASSERT_EQ(a.border_edges().size(), b.border_edges().size());
  ASSERT_EQ(a.crossings().size(), b.crossings().size());
  for (std::size_t i = 0; i < a.crossings().size(); ++i) {
    ASSERT_EQ(a.crossings()[i].border_edge, b.crossings()[i].border_edge);
    ASSERT_EQ(a.crossings()[i].triangle, b.crossings()[i].triangle);
    ASSERT_EQ(a.crossings()[i].parameter, b.crossings()[i].parameter);
  }
  ASSERT_EQ(a.counts().depth_fallbacks, b.counts().depth_fallbacks);
  ASSERT_EQ(a.counts().completeness, b.counts().completeness);
  ASSERT_EQ(a.counts().dropped_cells, b.counts().dropped_cells);
}

}  // namespace palpate::test
