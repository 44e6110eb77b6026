#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_columns.hpp"
#include "contact/point_in_tet.hpp"
#include "contact/wanted_items.hpp"
#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// States of contacts with their keys, sorted by (point, body). A resumed run needs them.
struct ContactHistory {
  std::vector<Index> point;
  std::vector<Index> body;
  ContactStates states;
};

/// All data of contacts: one row for each (point, body), in this order. docs/contact-table.md draws it and
/// says who writes which column.
///
/// Rows in contact come first; their public columns are `Contacts`. If states are kept, rows of ended
/// contacts follow, so that a contact that opens and closes again is recognised. A table is made from the
/// result of the query and the previous table. Each row is matched once, and all data of a contact use this
/// match.
class ContactTable {
 public:
  using Key = std::pair<Index, Index>;  ///< point, body

  /// Steps for which the state of an ended contact is kept.
  static constexpr std::int32_t longest_absence = 20;

  /// Sorts the result of the query (of several tets of one body the lowest is used), matches the rows with
  /// those of the last table, and copies their states. Depth, direction and certainty are zero.
  /// O(points / 8 + found + rows of `last`), parallel.
  /// \param last  null: there is no previous table
  void assign(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              std::span<const PointInTet> found, const ContactTable* last = nullptr);

  /// The columns that users see, (size()) rows.
  [[nodiscard]] Contacts& contacts() { return contacts_; }
  [[nodiscard]] const Contacts& contacts() const { return contacts_; }
  /// Edge contacts are rows of a separate kind, moved together with the table.
  [[nodiscard]] EdgeContacts& edges() { return edges_; }
  [[nodiscard]] const EdgeContacts& edges() const { return edges_; }
  /// Moves the public columns out; contacts() is empty until the next assign().
  [[nodiscard]] Contacts take_contacts();
  /// Rows in contact.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// The contact of a point with a body, or -1. O(bodies that the point is in).
  [[nodiscard]] Index find(Index point, Index body) const {
    const OfPoint& contacts = at(of_point_, point);
    if (contacts.count > 1) [[unlikely]] {
      for (Index c = contacts.first; c < contacts.first + contacts.count; ++c) {
        if (at(bodies(), c) == body) return c;
      }
      return -1;
    }
    return contacts.body == body ? contacts.first : -1;
  }
  /// The row of a contact, or of an ended one, or -1. O(bodies that the point is in + log(ended)).
  [[nodiscard]] Index row_of(Index point, Index body) const;
  /// (size()) the row of each contact in the last table, -1: none. Rows from that table's size() on are
  /// contacts that had ended.
  [[nodiscard]] std::span<const Index> previous() const { return previous_; }

  /// Cached planes, written by PlaneCache: (size()) rows, or none.
  [[nodiscard]] CachedPlanes& planes() { return planes_; }
  [[nodiscard]] const CachedPlanes& planes() const { return planes_; }
  /// States of rows in contact, then of rows that have ended; empty before the first begin_step() or
  /// set_history().
  [[nodiscard]] ContactStates& states() { return now_.states; }
  [[nodiscard]] const ContactStates& states() const { return now_.states; }
  [[nodiscard]] RimCache& rims() { return now_.rims; }

  /// Adds rows with zero states, among the ended ones, for contacts that have no row. Keys must be sorted.
  /// Indices of rows of ended contacts change. O(rows).
  void add_rows(std::span<const Key> keys);
  /// Counts a step: increments `seen` of contacts and `lost` of ended ones, which are removed after
  /// longest_absence. A speculative contact that never existed at the end of a step is removed. O(rows),
  /// parallel.
  void begin_step(const parallel::Threads& threads);
  /// Undoes the last begin_step() and all later changes of states. O(1).
  void undo_step() { std::swap(now_, before_); }

  /// The states of all contacts that have acted, including those that have ended. O(rows).
  [[nodiscard]] ContactHistory history() const;
  /// Replaces all states: `contacts` are sorted by (point, body). O(rows).
  void set_history(const ContactHistory& contacts);

 private:
  /// The contacts of a point: `count` rows from `first` on.
  struct OfPoint {
    Index first;
    Index count;
    Index body;  ///< body of the first contact; -1: no contact
  };
  /// States of all rows, and keys of the ended ones.
  struct RowStates {
    std::vector<Index> point;
    std::vector<Index> body;
    ContactStates states;
    RimCache rims;
  };

  [[nodiscard]] const std::vector<Index>& bodies() const {
    return contacts_.body.empty() ? taken_bodies_ : contacts_.body;
  }
  [[nodiscard]] Key key(std::size_t row) const;
  [[nodiscard]] bool has_history(std::size_t row) const {
    return now_.states.seen[row] > 0 || now_.states.lost[row] > 0;
  }
  void list_rows(const parallel::Threads& threads, const Bodies& bodies, std::span<const PointInTet> found);
  void match(const parallel::Threads& threads, const ContactTable& last);
  void list_ended(const ContactTable& last);
  void carry_states(const parallel::Threads& threads, const ContactTable& last);
  static void resize(RowStates& history, std::size_t rows, std::size_t ended);
  static void grow(RowStates& history, std::size_t rows, std::size_t ended);

  Contacts contacts_;
  EdgeContacts edges_;
  std::size_t size_ = 0;
  std::vector<Index> taken_bodies_;  ///< the column `body` after take_contacts(), which moves it out
  std::vector<Index> previous_;
  CachedPlanes planes_;
  bool keeps_states_ = false;
  RowStates now_;
  RowStates before_;               ///< states before the last begin_step()
  std::vector<OfPoint> of_point_;  ///< (n_points)
  std::vector<Index> points_;      ///< that have contacts, ascending
  // Scratch:
  std::vector<PointInTet> by_point_;
  WantedItems with_contact_;           ///< points; none between calls
  std::vector<std::uint8_t> matched_;  ///< 1: rows of the last table with a row here
  std::vector<std::size_t> ended_;     ///< rows of the last table that ended
  std::vector<Key> new_keys_;
};

}  // namespace palpate
