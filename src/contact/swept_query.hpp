#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/local_thickness.hpp"
#include "contact/pair_filter.hpp"
#include "contact/surface_clusters.hpp"
#include "geometry/box.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

enum class SweptKind : std::uint8_t { point_triangle, edge_edge };

/// A surface point and a surface triangle, or two surface edges, that touch within a step.
struct SweptContact {
  SweptKind kind = SweptKind::point_triangle;
  Index first = -1;   ///< the point, or the edge of the lower body (within a body: the lower edge)
  Index second = -1;  ///< the triangle, or the other edge
  double time = 0.0;  ///< in [0, 1] of the step; see SweptTouch
  std::array<double, 3> weights{};
  /// Unit vector from the second to the first, on the side from which the first came. If they touch already
  /// at the start of the step, it is along the surfaces' normals there; zero if these cancel.
  Vec3 direction{};
  friend bool operator==(const SweptContact&, const SweptContact&) = default;
};

struct SweptSettings {
  /// Distance within which a touch may be reported, m; see point_meets_triangle().
  double tolerance = 0.0;
  /// Two clusters are tested only if their relative motion is more than this times the smaller of their local
  /// thicknesses; negative: always.
  double least_motion = 0.25;
};

/// Counts of a query.
struct SweptCounts {
  std::size_t body_pairs = 0;     ///< pairs of bodies with such pairs of clusters
  std::size_t cluster_pairs = 0;  ///< that could pass: swept boxes meet, relative motion above least_motion
  std::size_t tested = 0;         ///< pairs of primitives whose boxes meet, see SweptFrame
  double thinnest = 0.0;          ///< minimum local thickness of these clusters, m; 0 where there are none
};

/// Finds primitives that pass or touch each other within a step: surface points of bodies against surface
/// triangles of others, and surface edges against surface edges, moving along straight lines between two
/// positions. docs/continuous.md proves the filters. The same bits for every thread count. Keeps its memory
/// from step to step.
class SweptQuery {
 public:
  explicit SweptQuery(const Bodies& bodies);

  /// All touches in the pairs of bodies that `filter` allows (within a body: of primitives without a common
  /// point), sorted by (kind, first, second). Positions must be finite (n_points x 3). O(surface points) if
  /// nothing could pass; else in addition O(clusters log clusters + pairs whose swept boxes meet). Valid
  /// until the next call.
  std::span<const SweptContact> find(const parallel::Threads& threads, std::span<const Vec3> start,
                                     std::span<const Vec3> end, const PairFilter& filter,
                                     const SweptSettings& settings);

  /// As find(), but the paths lead from other positions, `from`, to `end`. The relative motion by which pairs
  /// are left out is still that from `start`.
  std::span<const SweptContact> find(const parallel::Threads& threads, std::span<const Vec3> start,
                                     std::span<const Vec3> from, std::span<const Vec3> end,
                                     const PairFilter& filter, const SweptSettings& settings);

  /// Whether boxes of bodies and their motions leave it possible that anything passes. If not, there is
  /// nothing to find and to count. O(surface points + bodies log bodies + pairs).
  bool may_pass(const parallel::Threads& threads, std::span<const Vec3> start, std::span<const Vec3> end,
                const PairFilter& filter, const SweptSettings& settings);
  /// Counts only the pairs that could pass. As may_pass(), and where that is true O(clusters log clusters +
  /// pairs).
  void count(const parallel::Threads& threads, std::span<const Vec3> start, std::span<const Vec3> end,
             const PairFilter& filter, const SweptSettings& settings);

  [[nodiscard]] const SweptCounts& counts() const { return counts_; }
  [[nodiscard]] const LocalThickness& thickness() const { return thickness_; }

 private:
  /// Boxes of the corners over the step, and of their displacements.
  struct Swept {
    Box places;
    Box motion;
  };
  using Pair = std::array<Index, 2>;
  struct Step {
    const parallel::Threads& threads;
    std::span<const Vec3> start;
    std::span<const Vec3> end;
    const PairFilter& filter;
    const SweptSettings& settings;
  };
  void begin(const Step& step, std::span<const Vec3> from);
  void sweep_clusters(const Step& step);
  void extend_places(const Step& step, std::span<const Vec3> from);
  void sweep_bodies();
  void find_body_pairs(const Step& step);
  void mark_clusters();
  void find_cluster_pairs(const Step& step);
  void count_cluster_pairs();
  void test_pairs(const Step& step);
  void test_pair(const Step& step, const Pair& pair, std::vector<SweptContact>& found,
                 std::size_t& tested) const;
  void test_point(const Step& step, Index point, Index triangle, std::vector<SweptContact>& found) const;
  void test_edge(const Step& step, Index first, Index second, std::vector<SweptContact>& found) const;
  [[nodiscard]] Vec3 out_of_edge(const Step& step, Index first, Index second) const;
  [[nodiscard]] bool may_touch(const PairFilter& filter, Index a, Index b) const;
  [[nodiscard]] std::ptrdiff_t body_pair_of(const Pair& clusters) const;

  const Bodies& bodies_;
  SurfaceClusters surface_;
  LocalThickness thickness_;
  std::vector<Swept> clusters_;       ///< boxes in the current step
  std::vector<Swept> of_bodies_;      ///< the same
  std::vector<Index> by_lower_;       ///< bodies, or marked clusters, sorted by the lower ends of their boxes
  std::vector<Pair> body_pairs_;      ///< ascending
  std::vector<std::uint8_t> marked_;  ///< per cluster, 1: meets the other body of a pair
  parallel::ChunkedList<Pair> pair_lists_;
  std::vector<Pair> pairs_;                 ///< of clusters
  std::vector<std::uint8_t> has_clusters_;  ///< (n_body_pairs) 1: in one of these
  parallel::ChunkedList<SweptContact> lists_;
  std::vector<std::size_t> tested_;  ///< per chunk
  std::vector<SweptContact> contacts_;
  SweptCounts counts_;
};

}  // namespace palpate
