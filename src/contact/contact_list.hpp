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
    const OfPoint& contacts = at(of_point_, point);
    if (contacts.count > 1) [[unlikely]] {
      for (Index c = contacts.first; c < contacts.first + contacts.count; ++c) {
        if (at(contacts_.body, c) == body) return c;
      }
      return -1;
    }
    return contacts.body == body ? contacts.first : -1;
  }

 private:
  /// The contacts of a point: `count` from `first` on.
  struct OfPoint {
    Index first;
    Index count;
    Index body;  ///< of the first; -1: there is none
  };

  Contacts contacts_;
  std::vector<OfPoint> of_point_;  ///< (n_points)
  std::vector<PointInTet> by_point_;
  std::vector<Index> row_begin_;
};

}  // namespace palpate
