#pragma once

#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/edge_query.hpp"
#include "contact/silhouette.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Finds the edge contacts among bodies, and of bodies with themselves, and their depths (docs/edges.md).
///
/// A part of an edge that is inside a body, with both ends of the edge outside, leaves by the shortest of
/// three exits: across itself, over the silhouette of the surface through which it enters or leaves, or back
/// along itself, until one end is at its entry.
///
/// A part is between an entry and the last exit before the next entry. If an edge only touches another body,
/// this is a contact, too. In its own body, only parts count.
class EdgeContactQuery {
 public:
  /// \param keeps_lists  as of EdgeQuery
  explicit EdgeContactQuery(const Bodies& bodies, bool keeps_lists = true);

  /// \param contacts  of the same positions
  /// \param deadline  the search ends then; edge contacts that it has found are completed
  ///
  /// O(of EdgeQuery + edge contacts x triangles nearer to each than its depth), parallel.
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const PairFilter& may_touch, const ContactTable& contacts, EdgeContacts& found,
            const Deadline& deadline = {});
  /// What the search left out after the deadline.
  [[nodiscard]] const EdgeWork& work() const { return query_.work(); }

 private:
  /// A crossing of an edge and a triangle.
  struct Meeting {
    Index triangle;
    double parameter;
    bool enters;  ///< whether the edge enters the body there
  };
  /// The hits of an edge with one body: a range of the query's result.
  struct Group {
    std::size_t begin;
    std::size_t end;
  };
  struct Row {
    Index edge;
    std::array<Index, 2> triangles;
    std::array<double, 2> parameters;
    double depth;
    Vec3 direction;
  };
  struct Scratch {
    Scratch() { meetings.reserve(64); }
    std::vector<Meeting> meetings;
    SilhouetteSearch search;
  };
  void list_groups(const Bodies& bodies, std::size_t spare);
  void find_meetings(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     std::size_t spare);
  static Meeting exact_meeting(const Bodies& bodies, std::span<const Vec3> positions,
                               const EdgeTriangle& hit);
  void add_rows(const Bodies& bodies, std::span<const Vec3> positions, const Group& group,
                const PairFilter& may_touch, Scratch& scratch, std::vector<Row>& rows) const;
  [[nodiscard]] LineExit shortest_exit(const Bodies& bodies, std::span<const Vec3> positions, Index edge,
                                       const Meeting& in, const Meeting& out, SilhouetteSearch& search) const;

  EdgeQuery query_;
  std::vector<double> slack_;  ///< (n_bodies) EdgeLine::slack
  std::vector<Group> groups_;
  std::vector<Meeting> meetings_;   ///< of the query's result
  std::vector<Scratch> scratches_;  ///< of each chunk of groups
  parallel::ChunkedList<Row> lists_;
  std::vector<Row> rows_;
};

}  // namespace palpate
