#include "contact/contact_table.hpp"

#include <algorithm>
#include <utility>

#include "geometry/predicates.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t row_grain = 512;

}  // namespace

/// Makes no pass over all points of the model but that over the marks: most points have no contact.
void ContactTable::list_rows(const parallel::Threads& threads, const Bodies& bodies,
                             std::span<const PointInTet> found) {
  constexpr OfPoint none{.first = 0, .count = 0, .body = -1};
  const std::size_t n_points = bodies.points_rest().size();
  if (of_point_.size() != n_points) {
    of_point_.assign(n_points, none);
    with_contact_.resize(n_points);
  } else {
    for (const Index p : points_) at(of_point_, p) = none;
  }
  for (const PointInTet& f : found) {
    ++at(of_point_, f.point).count;
    with_contact_.want(f.point);
  }
  const std::span<const Index> points = with_contact_.list(threads);
  make_room(points_, found.size());
  points_.assign(points.begin(), points.end());
  with_contact_.forget();
  Index begin = 0;
  for (const Index p : points_) at(of_point_, p).first = std::exchange(begin, begin + at(of_point_, p).count);
  resize_with_room(by_point_, found.size());
  for (const PointInTet& f : found) at(by_point_, at(of_point_, f.point).first++) = f;
  for (std::vector<Index>* list : {&contacts_.point, &contacts_.body, &contacts_.tet}) {
    list->clear();
    make_room(*list, found.size());
  }
  auto entry = by_point_.begin();
  for (const Index p : points_) {
    OfPoint& of_point = at(of_point_, p);
    const auto end = entry + of_point.count;
    // Tets are in the order of bodies, so bodies ascend.
    if (of_point.count > 1) {
      std::sort(entry, end, [](const PointInTet& a, const PointInTet& b) { return a.tet < b.tet; });
    }
    of_point = {static_cast<Index>(contacts_.size()), 0, -1};
    Index last_body = -1;
    for (; entry != end; ++entry) {
      const Index body = bodies.body_of(at(bodies.tets(), entry->tet));
      if (body == last_body) continue;
      last_body = body;
      if (of_point.count++ == 0) of_point.body = body;
      contacts_.point.push_back(p);
      contacts_.body.push_back(body);
      contacts_.tet.push_back(entry->tet);
    }
  }
  size_ = contacts_.size();
}

void ContactTable::assign(const parallel::Threads& threads, const Bodies& bodies,
                          std::span<const Vec3> positions, std::span<const PointInTet> found,
                          const ContactTable* last) {
  list_rows(threads, bodies, found);
  resize_with_room(contacts_.weights, size_);
  assign_with_room(contacts_.depth, size_, 0.0);
  assign_with_room(contacts_.direction, size_, Vec3{});
  assign_with_room(contacts_.certainty, size_, 0.0);
  parallel::for_each(threads, size_, row_grain, [&](std::size_t c) {
    const Tet& tet = at(bodies.tets(), contacts_.tet[c]);
    contacts_.weights[c] =
        barycentric_weights(at(positions, contacts_.point[c]), at(positions, tet[0]), at(positions, tet[1]),
                            at(positions, tet[2]), at(positions, tet[3]));
  });
  resize_columns(planes_, 0);
  resize_with_room(previous_, size_);
  if (last == nullptr) {
    std::ranges::fill(previous_, -1);
    keeps_states_ = false;
  } else {
    match(threads, *last);
    keeps_states_ = last->keeps_states_;
    if (keeps_states_) carry_states(threads, *last);
  }
  if (!keeps_states_) resize(now_, 0, 0);
}

Contacts ContactTable::take_contacts() {
  taken_bodies_ = contacts_.body;
  return std::exchange(contacts_, Contacts{});
}

ContactTable::Key ContactTable::key(std::size_t row) const {
  if (row < size_) return {contacts_.point[row], contacts_.body[row]};
  return {now_.point[row - size_], now_.body[row - size_]};
}

Index ContactTable::row_of(Index point, Index body) const {
  if (of_point_.empty()) return -1;
  const Index row = find(point, body);
  if (row >= 0 || now_.point.empty()) return row;
  const auto [first, last] = std::ranges::equal_range(now_.point, point);
  for (auto it = first; it != last; ++it) {
    const std::ptrdiff_t ended = it - now_.point.begin();
    if (at(now_.body, ended) == body) return static_cast<Index>(static_cast<std::ptrdiff_t>(size_) + ended);
  }
  return -1;
}

void ContactTable::match(const parallel::Threads& threads, const ContactTable& last) {
  parallel::for_each(threads, size_, row_grain, [&](std::size_t c) {
    previous_[c] = last.row_of(contacts_.point[c], contacts_.body[c]);
  });
}

/// Lists the rows of the last table that have a history but no row here, by merging two sorted lists.
void ContactTable::list_ended(const ContactTable& last) {
  const std::size_t rows = last.size_ + last.now_.point.size();
  assign_with_room(matched_, rows, std::uint8_t{0});
  for (const Index row : previous_)
    if (row >= 0) at(matched_, row) = 1;
  ended_.clear();
  make_room(ended_, rows);
  std::size_t old = last.size_;  // index of the first row that had ended before
  const auto add = [&](std::size_t row) {
    if (matched_[row] == 0) ended_.push_back(row);
  };
  for (std::size_t row = 0; row < last.size_; ++row) {
    if (matched_[row] != 0 || !last.has_history(row)) continue;
    while (old < rows && last.key(old) < last.key(row)) add(old++);
    add(row);
  }
  while (old < rows) add(old++);
}

void ContactTable::resize(RowStates& history, std::size_t rows, std::size_t ended) {
  resize_with_room(history.point, ended);
  resize_with_room(history.body, ended);
  resize_columns(history.states, rows + ended);
  resize_columns(history.rims, rows + ended);
}

/// Adds rows; existing values stay.
void ContactTable::grow(RowStates& history, std::size_t rows, std::size_t ended) {
  grow_column(history.point, ended);
  grow_column(history.body, ended);
  grow_columns(history.states, rows + ended);
  grow_columns(history.rims, rows + ended);
}

void ContactTable::carry_states(const parallel::Threads& threads, const ContactTable& last) {
  list_ended(last);
  resize(now_, size_, ended_.size());
  parallel::for_each(threads, size_ + ended_.size(), row_grain, [&](std::size_t row) {
    const std::size_t from = row < size_ ? static_cast<std::size_t>(previous_[row]) : ended_[row - size_];
    if (row < size_ && previous_[row] < 0) {
      clear_row(now_.states, row);
      clear_row(now_.rims, row);
      return;
    }
    copy_row(last.now_.states, from, now_.states, row);
    copy_row(last.now_.rims, from, now_.rims, row);
    if (row >= size_) std::tie(now_.point[row - size_], now_.body[row - size_]) = last.key(from);
  });
}

/// Moves rows in descending order, so that no value is overwritten before it is moved.
void ContactTable::add_rows(std::span<const Key> keys) {
  new_keys_.clear();
  make_room(new_keys_, keys.size());
  for (const Key& key : keys)
    if (row_of(key.first, key.second) < 0) new_keys_.push_back(key);
  if (new_keys_.empty()) return;
  std::size_t old = now_.point.size();
  std::size_t row = old + new_keys_.size();
  grow(now_, size_, row);
  for (std::size_t added = new_keys_.size(); added > 0;) {
    const bool is_old = old > 0 && Key(now_.point[old - 1], now_.body[old - 1]) > new_keys_[added - 1];
    --row;
    const Key key = is_old ? Key(now_.point[old - 1], now_.body[old - 1]) : new_keys_[added - 1];
    if (is_old) {
      --old;
      copy_row(now_.states, size_ + old, now_.states, size_ + row);
      copy_row(now_.rims, size_ + old, now_.rims, size_ + row);
    } else {
      --added;
      clear_row(now_.states, size_ + row);
      clear_row(now_.rims, size_ + row);
    }
    std::tie(now_.point[row], now_.body[row]) = key;
  }
}

void ContactTable::begin_step(const parallel::Threads& threads) {
  if (!keeps_states_) set_history({});
  std::swap(now_, before_);
  const ContactStates& then = before_.states;
  resize(now_, size_, before_.point.size());
  parallel::for_each(threads, size_, row_grain, [&](std::size_t row) {
    copy_row(then, row, now_.states, row);
    copy_row(before_.rims, row, now_.rims, row);
    now_.states.speculative[row] = 0;
    ++now_.states.seen[row];
  });
  std::size_t ended = 0;
  for (std::size_t g = 0; g < before_.point.size(); ++g) {
    const std::size_t from = size_ + g;
    const bool never_there = then.speculative[from] != 0 && then.lost[from] == 0;
    if (never_there || then.lost[from] >= longest_absence) continue;
    const std::size_t row = size_ + ended;
    clear_row(now_.rims, row);
    clear_row(now_.states, row);
    now_.states.lost[row] = then.lost[from] + 1;
    now_.states.direction[row] = then.direction[from];
    now_.states.velocity[row] = then.velocity[from];
    now_.states.chatter_damping[row] = then.chatter_damping[from];
    now_.point[ended] = before_.point[g];
    now_.body[ended++] = before_.body[g];
  }
  resize(now_, size_, ended);
}

ContactHistory ContactTable::history() const {
  ContactHistory all;
  if (!keeps_states_) return all;
  const std::size_t rows = size_ + now_.point.size();
  std::vector<std::size_t> order;
  for (std::size_t row = 0; row < rows; ++row)
    if (has_history(row)) order.push_back(row);
  const auto begin_of_ended = std::ranges::lower_bound(order, size_);
  std::inplace_merge(order.begin(), begin_of_ended, order.end(),
                     [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  resize_columns(all.states, order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    all.point.push_back(key(order[i]).first);
    all.body.push_back(key(order[i]).second);
    copy_row(now_.states, order[i], all.states, i);
  }
  return all;
}

void ContactTable::set_history(const ContactHistory& contacts) {
  keeps_states_ = true;
  std::vector<Index> row_of_contact;
  std::size_t ended = 0;
  for (std::size_t i = 0; i < contacts.point.size(); ++i) {
    row_of_contact.push_back(of_point_.empty() ? -1 : find(contacts.point[i], contacts.body[i]));
    ended += row_of_contact.back() < 0 ? 1 : 0;
  }
  resize(now_, size_, ended);
  for (std::size_t row = 0; row < size_ + ended; ++row) {
    clear_row(now_.states, row);
    clear_row(now_.rims, row);
  }
  ended = 0;
  for (std::size_t i = 0; i < contacts.point.size(); ++i) {
    const bool is_ended = row_of_contact[i] < 0;
    if (is_ended) {
      now_.point[ended] = contacts.point[i];
      now_.body[ended] = contacts.body[i];
    }
    const auto row = is_ended ? size_ + ended++ : static_cast<std::size_t>(row_of_contact[i]);
    copy_row(contacts.states, i, now_.states, row);
  }
}

}  // namespace palpate
