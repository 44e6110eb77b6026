#pragma once

#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_list.hpp"

namespace palpate {

/// The edges that connect a point in contact with a point that is not in contact with the same body (paper
/// 3), or with another layer of it where the body is their own; in order of (contact, edge). O(contacts x
/// edges at a point), parallel.
void find_border_edges(const parallel::Threads& threads, const Bodies& bodies,
                       std::span<const Vec3> positions, const ContactList& contacts,
                       parallel::ChunkedList<BorderEdge>& scratch, std::vector<BorderEdge>& border_edges);

}  // namespace palpate
