#pragma once

#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/point_in_tet.hpp"
#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Contacts in canonical order, and where those of each point are.
class ContactList {
 public:
  /// Sorts what the query found by (point, body) and keeps of several tets of one body the lowest.
  void assign(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              std::span<const PointInTet> found);

  [[nodiscard]] Contacts& contacts() { return contacts_; }
  [[nodiscard]] const Contacts& contacts() const { return contacts_; }
  /// The contact of a point with a body, or -1. O(bodies that the point is in).
  [[nodiscard]] Index find(Index point, Index body) const {
    for (Index c = at(point_begin_, point); c < at(point_begin_, point + 1); ++c) {
      if (at(contacts_.body, c) == body) return c;
    }
    return -1;
  }

 private:
  Contacts contacts_;
  std::vector<Index>
      point_begin_;  ///< (n_points + 1) contacts of point p: [point_begin_[p], point_begin_[p + 1])
  std::vector<PointInTet> by_point_;
  std::vector<Index> row_begin_;
};

}  // namespace palpate
