#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/cluster_pairs.hpp"
#include "contact/contact_table.hpp"
#include "contact/surface_clusters.hpp"

namespace palpate {

/// Finds the points that were in contact with a body in the last detection and no longer are: an edge at such
/// a point may now have an edge contact.
class LostContacts {
 public:
  LostContacts(const SurfaceClusters& surface, const Bodies& bodies);

  /// Compares contacts with those of the last call. O(contacts + clusters).
  void follow(const Bodies& bodies, const ContactTable& contacts);
  /// Pairs of bodies that have lost contacts, the lower body first, sorted.
  [[nodiscard]] std::span<const IndexPair> bodies() const { return bodies_; }
  /// Whether a point of the cluster has lost a contact.
  [[nodiscard]] bool has_lost(Index cluster) const { return at(is_lost_, cluster) != 0; }

 private:
  Rows clusters_of_point_;     ///< (n_points)
  std::vector<Index> points_;  ///< of the contacts of the last call,
  std::vector<Index> in_;      ///< and the bodies that they were in
  std::vector<IndexPair> bodies_;
  std::vector<std::uint8_t> is_lost_;  ///< (n_clusters)
};

}  // namespace palpate
