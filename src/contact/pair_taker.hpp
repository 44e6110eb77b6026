#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/pair_filter.hpp"
#include "contact/point_in_tet.hpp"
#include "contact/query_tally.hpp"
#include "mesh/clusters.hpp"
#include "simd/cluster_query.hpp"

namespace palpate {

/// Input of the evaluation of hits.
struct PairContext {
  const Clusters& clusters;
  const Bodies& bodies;
  std::span<const Vec3> positions;
  const PairFilter& may_touch;
  std::span<const std::uint8_t> upright;  ///< (n_bodies) 1: no tet of the body is folded
};

/// Evaluates the hits of blocks of the filter. Certain pairs are contacts; others go to the exact predicate.
/// Ignored bodies, folds and what ties hold together are left out.
class PairTaker {
 public:
  PairTaker(const PairContext& context, std::vector<PointInTet>& found) : context_(context), found_(found) {}

  /// Whether a pair is a contact.
  bool take(const Cluster& cluster, Index point, std::uint32_t primitives);
  QueryTally& tally() { return tally_; }

 private:
  [[nodiscard]] bool is_inside(const PointInTet& pair) const;
  /// Whether a pair of a point and a tet of its own body is a contact.
  bool is_folded(const PointInTet& pair, Index body);
  void leave_out_tied(Index body, std::size_t first);

  const PairContext& context_;
  std::vector<PointInTet>& found_;
  QueryTally tally_;
};

}  // namespace palpate
