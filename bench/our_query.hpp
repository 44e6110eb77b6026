#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact/cluster_query.hpp"
#include "contact/point_in_tet.hpp"
#include "grid/fixed_positions.hpp"
#include "grid/lattice.hpp"
#include "grid/point_grid.hpp"
#include "measure/query_scenes.hpp"
#include "parallel/parallel.hpp"
#include "peers/peer.hpp"

namespace palpate::bench {

/// The input of our queries, like that of Detector.
struct Setting {
  explicit Setting(const measure::QueryScene& s);
  [[nodiscard]] PairFilter may_touch() const { return {immovable, scene.self_collision}; }

  const measure::QueryScene& scene;
  std::vector<std::uint8_t> immovable;  ///< per body
  std::vector<std::uint8_t> included;
  std::vector<std::uint8_t> marks;  ///< per point: of an immovable body
  Course course;
  double cell_size = 0.0;
  Lattice lattice;
};

/// The clustered query with its grid, frame after frame.
class OurQuery {
 public:
  /// \param setting   must outlive it
  /// \param coherent  with lists of near points, made for earlier frames
  OurQuery(const Setting& setting, int threads, bool coherent);
  /// Valid until the next. Throws if the positions have left the lattice.
  std::span<const PointInTet> find(std::span<const Vec3> positions);

 private:
  const Setting* setting_;
  bool coherent_;
  parallel::Threads threads_;
  PointGrid grid_;
  ClusterQuery query_;
  FixedPositions fixed_;
  bool is_new_ = true;
};

/// While it lives, Highway's dispatch uses one target, which the processor must have; 0: no change.
class ForcedTarget {
 public:
  explicit ForcedTarget(std::int64_t target);
  ~ForcedTarget();
  ForcedTarget(const ForcedTarget&) = delete;
  ForcedTarget& operator=(const ForcedTarget&) = delete;

 private:
  std::int64_t target_;
};

}  // namespace palpate::bench
