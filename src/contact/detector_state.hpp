#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <variant>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/cluster_query.hpp"
#include "contact/contact_tables.hpp"
#include "contact/crossings.hpp"
#include "contact/depth.hpp"
#include "contact/detection_budget.hpp"
#include "contact/edge_contacts.hpp"
#include "contact/plane_cache.hpp"
#include "contact/points_in_tets.hpp"
#include "grid/brute.hpp"
#include "grid/cell_size.hpp"
#include "grid/cell_slots.hpp"
#include "grid/compact.hpp"
#include "grid/cuckoo.hpp"
#include "grid/fixed_positions.hpp"
#include "grid/hash.hpp"
#include "grid/uniform.hpp"

namespace palpate {

using AnyStructure = std::variant<UniformGrid, CompactGrid, HashGrid, CuckooGrid, BruteForce>;

/// The members of a Detector. Its functions are in detector_setup.cpp (construction), detector.cpp (a
/// detection) and detector_memory.cpp (state for later detections and resumed runs).
struct Detector::State {
  /// State of clusters with a budget: how long they have waited, and whether they found something.
  struct Waiting {
    std::vector<std::uint8_t> tets;
    std::vector<std::uint8_t> triangles;
  };
  /// Further data of a held detection: its results, and the state that the next detection depends on.
  struct Held {
    bool active = false;
    bool has_lists = false;  ///< border edges and crossings are stored here, since another detection began
    std::vector<BorderEdge> border_edges;
    std::vector<Crossing> crossings;
    DetectionCounts counts;
    DetectionTimes times;
    Lattice lattice;
    std::uint64_t step = 0;
    double fraction = 1.0;
    Waiting waiting;      ///< State::waiting
    Waiting waiting_now;  ///< state of the queues
    std::vector<std::uint8_t> late_bodies;
  };

  State(const Bodies& b, const DetectionSettings& s, std::vector<std::uint8_t> i, int n);

  /// Whether this detection queries clusters of tets.
  [[nodiscard]] bool clustered() const {
    return cluster_query != nullptr && FixedPositions::represents(lattice);
  }
  /// Whether this detection uses data of earlier frames where possible.
  [[nodiscard]] bool coherent() const { return settings.coherence && !budget && clustered(); }
  [[nodiscard]] PairFilter may_touch() const {
    return {immovable, settings.self_collision, settings.ignored_pairs};
  }
  [[nodiscard]] std::vector<std::uint8_t> marks_of_immovable() const;

  /// The threads for the update of the grid: the calling thread alone if waking another takes longer than the
  /// loops.
  [[nodiscard]] const parallel::Threads& grid_threads() const {
    constexpr std::size_t points_worth_sharing = 30000;
    return in_a_tet.size() < points_worth_sharing ? one_thread : threads;
  }
  void update_domain(std::span<const Vec3> positions);
  void count_movers(std::span<const Vec3> positions);
  void update_grid(std::span<const Vec3> positions);
  void find_points_in_tets(std::span<const Vec3> positions, const CellSlots& slots);
  /// The allowance of this detection; null: no limit.
  [[nodiscard]] Allowance* limit() { return budget && clustered() ? budget->allowance() : nullptr; }
  void begin_budget(double fraction_of_budget);
  /// Whether planes are cached, which is so with a budget in time.
  [[nodiscard]] bool caches_planes() const { return budget && settings.budget->milliseconds; }
  void choose_planes(std::span<const Vec3> positions);
  void find_edge_contacts(std::span<const Vec3> positions);
  void estimate_depths(std::span<const Vec3> positions);
  void finish_counts();
  void hold();
  void keep_held_lists();
  void swap_back();
  void release();
  void limit_crossings();
  void end_budget();
  void recall_budget(const DetectorMemory& memory);
  void recall_coherence(const DetectorMemory& memory);

  const Bodies& bodies;
  DetectionSettings settings;
  std::vector<std::uint8_t> immovable;  ///< per body
  std::vector<std::uint8_t> in_a_tet;   ///< per point; unreferenced points are left out
  parallel::Threads threads;
  parallel::Threads one_thread{1};
  CellSizeChoice cell_size;  ///< chosen at the first detection
  std::uint64_t step = 0;    ///< detections so far

  Lattice lattice;
  bool new_domain = true;
  bool other_domain = false;  ///< the lattice differs from that of the last detection
  std::vector<Box> box_scratch;
  std::vector<std::uint64_t> cell_of_point;  ///< cell index of each point at the last detection
  std::vector<double> mover_scratch;

  AnyStructure points;
  AnyStructure edges;
  PointsInTets points_in_tets;
  std::unique_ptr<ClusterQuery> cluster_query;  ///< for the compact grid
  std::unique_ptr<FixedPositions> fixed;        ///< with cluster_query
  bool skips_coherence = false;                 ///< this detection does not use coherence
  bool skipped_grid = false;                    ///< the last detection used no grid
  std::unique_ptr<DetectionBudget> budget;      ///< null: no limit
  Allowance* crossings_limit = nullptr;         ///< part of the budget for crossings; null: no limit
  Waiting waiting;                              ///< state of the queues before the last detection
  double fraction = 1.0;                        ///< fraction of the budget in the last detection
  PlaneCache plane_cache;                       ///< with a budget in time
  QueryTally points_tally;
  ContactTables tables;
  BorderEdges border_edges;
  CrossingQuery crossings;
  std::unique_ptr<EdgeContactQuery> edge_contacts;  ///< null: not wanted
  DepthEstimate depth;

  DetectionCounts counts;
  DetectionTimes times;
  Held held;
};

}  // namespace palpate
