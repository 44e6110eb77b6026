#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_table.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// The edges of the points in contact, in two groups. A border edge connects a point in contact with a point
/// that is not in contact with the same body (paper 3), or, in self-contact, with a point in another layer. A
/// link connects two contacts.
class BorderEdges {
 public:
  explicit BorderEdges(const Bodies& bodies);

  /// Finds the border edges and the links. O(contacts x edges at a point), parallel.
  /// \param without  (n_contacts) nonzero for contacts whose border edges are left out; empty: none
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const ContactTable& table, std::span<const std::uint8_t> without = {});

  /// The border edges, sorted by (contact, edge).
  [[nodiscard]] std::span<const BorderEdge> edges() const { return edges_; }
  /// Swaps edges() and this list.
  void swap_edges(std::vector<BorderEdge>& edges) { edges_.swap(edges); }
  /// (n_contacts) the range of the links of each contact.
  [[nodiscard]] std::span<const Range> ranges_of_links() const { return ranges_; }
  /// The contact at the other end of each link, in the order of edges; there are gaps between the ranges.
  [[nodiscard]] std::span<const Index> links() const { return links_; }

 private:
  struct Part;
  void part(const Part& what, std::size_t contact, BorderEdge*& edge);

  Rows
      neighbors_;  ///< (n_points) points at the other ends of the edges of a point, in the order of the edges
  parallel::ChunkedList<BorderEdge> lists_;
  std::vector<BorderEdge> edges_;
  std::vector<Range> ranges_;
  std::vector<Index> links_;
};

}  // namespace palpate
