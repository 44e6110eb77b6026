#include "sim/contact_memory.hpp"

#include <utility>

#include "room.hpp"

namespace palpate {

void ContactMemory::remember_lost(RememberedContact contact) {
  if (++contact.lost > longest_absence) return;
  contact.seen = 0;
  contact.slip = {};
  contact.force = {};
  contact.stiffness = 0.0;
  all_.push_back(contact);
}

/// Both lists are sorted by (point, body), so one pass joins them.
void ContactMemory::update(const Contacts& contacts) {
  std::swap(all_, last_);
  all_.clear();
  make_room(all_, contacts.size() + last_.size());
  resize_with_room(place_, contacts.size());
  std::size_t l = 0;
  const auto last_key = [&] { return std::pair(last_[l].point, last_[l].body); };
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::pair key(contacts.point[c], contacts.body[c]);
    while (l < last_.size() && last_key() < key) remember_lost(last_[l++]);
    place_[c] = all_.size();
    RememberedContact remembered;
    if (l < last_.size() && last_key() == key) remembered = last_[l++];
    remembered.point = key.first;
    remembered.body = key.second;
    ++remembered.seen;
    all_.push_back(remembered);
  }
  while (l < last_.size()) remember_lost(last_[l++]);
}

}  // namespace palpate
