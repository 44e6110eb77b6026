#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/edge_contacts.hpp"
#include "contact/frame.hpp"

namespace palpate {

/// Without edge contacts (DetectionSettings::edge_contacts), bodies that cross edge on edge have no contact
/// and pass through each other. This counts the pairs of bodies for which this is so: their surfaces cross,
/// and no point of one is in the other.
class UnseenPairs {
 public:
  /// \param keeps_lists  as of EdgeQuery
  UnseenPairs(const Bodies& bodies, bool keeps_lists);

  /// Counts the pairs at the positions of the frame; a body in which only its own tissue crosses counts as a
  /// pair. Surfaces that only touch do not count. O(contacts log contacts + of EdgeContactQuery, where only
  /// bodies without a contact between them are searched).
  /// \param contacts  of the same positions
  /// \param deadline  the search ends then
  std::size_t count(const Frame& frame, const ContactTable& contacts, const Deadline& deadline);

 private:
  void leave_out_contacts(const Frame& frame, const ContactTable& contacts);

  EdgeContactQuery query_;
  std::vector<double> least_depth_;  ///< (n_bodies) of an edge that does more than touch, m
  // Scratch:
  EdgeContacts found_;
  std::vector<std::array<Index, 2>> pairs_;
  std::vector<std::uint8_t> self_collision_;
};

}  // namespace palpate
