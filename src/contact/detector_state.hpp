#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/contact_tables.hpp"
#include "contact/crossing_query.hpp"
#include "contact/crossings.hpp"
#include "contact/depth.hpp"
#include "contact/detection_budget.hpp"
#include "contact/edge_contacts.hpp"
#include "contact/frame.hpp"
#include "contact/plane_cache.hpp"
#include "contact/point_query.hpp"
#include "contact/unseen_pairs.hpp"

namespace palpate {

/// The members of a Detector. Its functions are in detector.cpp (a detection) and detector_memory.cpp (state
/// for later detections and resumed runs).
struct Detector::State {
  /// The results of a held detection that are not in the tables.
  struct Held {
    bool active = false;
    bool has_lists = false;  ///< border edges and crossings are stored here, since another detection began
    std::vector<BorderEdge> border_edges;
    std::vector<Crossing> crossings;
    DetectionCounts counts;
    DetectionTimes times;
  };

  State(const Bodies& b, const DetectionSettings& s, std::vector<std::uint8_t> immovable, int threads);

  /// A detection, phase by phase.
  /// \param fraction  of the budget that it may spend
  /// \param alone     without data of earlier detections
  void detect(std::span<const Vec3> positions, double fraction, bool alone = false);
  void update(std::span<const Vec3> positions, bool alone);
  void find_contacts();
  void find_crossings();
  void find_depths();
  void finish_counts();
  /// Whether planes are cached, which is so with a budget in time.
  [[nodiscard]] bool caches_planes() const { return budget && budget->is_timed(); }

  void hold();
  void keep_held_lists();
  void swap_back();
  void release();
  void check_coherence(const DetectorMemory& memory) const;

  const Bodies& bodies;
  Frame frame;
  std::unique_ptr<PointQuery> points;
  std::unique_ptr<CrossingQuery> edges;
  std::unique_ptr<DetectionBudget> budget;  ///< null: no limit
  std::unique_ptr<EdgeContactQuery>
      edge_contacts;                    ///< null: not wanted, or one body that cannot touch itself
  std::unique_ptr<UnseenPairs> unseen;  ///< if edge contacts are not wanted
  ContactTables tables;
  PlaneCache plane_cache;  ///< with a budget in time
  BorderEdges border_edges;
  Crossings crossings;
  DepthEstimate depth;

  DetectionCounts counts;
  DetectionTimes times;
  Held held;
};

}  // namespace palpate
