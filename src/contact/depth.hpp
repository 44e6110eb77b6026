#pragma once

#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_list.hpp"
#include "contact/crossings.hpp"

namespace palpate {

/// Consistent penetration depth and direction (Heidelberger, Teschner, Keiser, Mueller & Gross, "Consistent
/// penetration depth estimation for deformable collision response", 2004), for each pair of a body and one
/// that it penetrates.
///
/// Border points take depth and direction from the crossings of their border edges; points deeper inside from
/// their processed neighbours, breadth first. Deviations: of several crossings of an edge the one nearest its
/// free end counts; the normal is that of the triangle (exact for flat contact), not interpolated; where a
/// region has no border edge, or the estimate is not usable (negative, or no direction), the nearest surface
/// point of the penetrated body is taken.
class DepthEstimate {
 public:
  /// Fills depth and direction of all contacts; returns how many came from the nearest surface point.
  /// O(contacts x edges at a point + fallbacks x triangles), parallel, the same bits for every thread count.
  std::size_t compute(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                      ContactList& contacts, std::span<const BorderEdge> border_edges,
                      const CrossingQuery& crossings);

 private:
  void mark_border_edges(std::size_t contacts, std::span<const BorderEdge> border_edges);
  void estimate_border(const parallel::Threads& threads, const Bodies& bodies,
                       std::span<const Vec3> positions, Contacts& contacts,
                       std::span<const BorderEdge> border_edges, const CrossingQuery& crossings);
  void propagate(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                 ContactList& contacts);
  void take_nearest_surface(const Bodies& bodies, std::span<const Vec3> positions, Contacts& contacts,
                            std::size_t c);
  static constexpr double steepest_ = 8.0;  ///< bound of depth per distance to the surface

  void next_level(const Bodies& bodies, const ContactList& contacts, Index level);

  static constexpr Index unreached = -1;
  std::vector<Index> border_begin_;  ///< (n_contacts + 1) border edges of each contact
  std::vector<Index> level_;  ///< (n_contacts) 0 at the border, else steps of propagation; or unreached
  std::vector<Index> frontier_;
  std::vector<Index> next_;
  std::vector<std::uint8_t> fallback_;
};

}  // namespace palpate
