#include "sim/contact_memory.hpp"

#include <utility>

#include "room.hpp"

namespace palpate {
namespace {

std::pair<Index, Index> key_of(const RememberedContact& contact) {
  return {contact.point, contact.body};
}

}  // namespace

void ContactMemory::remember_lost(RememberedContact contact) {
  const bool never_there = contact.speculative && contact.lost == 0;
  if (never_there || ++contact.lost > longest_absence) return;
  contact.speculative = false;
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
  make_room(joined_, contacts.size() + last_.size());
  resize_with_room(place_, contacts.size());
  std::size_t l = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::pair key(contacts.point[c], contacts.body[c]);
    while (l < last_.size() && key_of(last_[l]) < key) remember_lost(last_[l++]);
    place_[c] = all_.size();
    const bool is_known = l < last_.size() && key_of(last_[l]) == key;
    RememberedContact& remembered = is_known ? all_.emplace_back(last_[l++]) : all_.emplace_back();
    remembered.point = key.first;
    remembered.body = key.second;
    remembered.speculative = false;
    ++remembered.seen;
  }
  while (l < last_.size()) remember_lost(last_[l++]);
}

void ContactMemory::undo() {
  std::swap(all_, last_);
}

void ContactMemory::list_unknown(const Contacts& contacts, std::vector<std::size_t>& unknown) const {
  make_room(unknown, contacts.size());
  unknown.clear();
  std::size_t k = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::pair key(contacts.point[c], contacts.body[c]);
    while (k < all_.size() && key_of(all_[k]) < key) ++k;
    const bool remembered = k < all_.size() && key_of(all_[k]) == key;
    if (!remembered || (all_[k].lost > 0 && !all_[k].speculative)) unknown.push_back(c);
  }
}

void ContactMemory::add(std::span<const RememberedContact> contacts) {
  make_room(joined_, all_.size() + contacts.size());
  joined_.clear();
  std::size_t k = 0;
  for (const RememberedContact& contact : contacts) {
    while (k < all_.size() && key_of(all_[k]) < key_of(contact)) joined_.push_back(all_[k++]);
    joined_.push_back(contact);
    if (k < all_.size() && key_of(all_[k]) == key_of(contact)) {
      joined_.back().lost = all_[k].lost;
      joined_.back().chatter_damping = all_[k].chatter_damping;
      ++k;
    }
  }
  while (k < all_.size()) joined_.push_back(all_[k++]);
  std::swap(all_, joined_);
}

}  // namespace palpate
