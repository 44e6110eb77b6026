#include "scene/overlaps.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "geometry/vector.hpp"

namespace palpate {

std::vector<Overlap> overlaps(const Bodies& bodies, const Detector& detector) {
  std::map<std::pair<Index, Index>, Overlap> pairs;
  const auto add = [&](Index body, Index penetrated, double depth) {
    const auto key = std::pair(std::min(body, penetrated), std::max(body, penetrated));
    Overlap& overlap = pairs.try_emplace(key, Overlap{key.first, key.second}).first->second;
    ++overlap.contacts;
    overlap.deepest = std::max(overlap.deepest, depth);
  };
  const Contacts& contacts = detector.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c)
    add(at(bodies.body_of_point(), contacts.point[c]), contacts.body[c], contacts.depth[c]);
  const EdgeContacts& edges = detector.edge_contacts();
  for (std::size_t c = 0; c < edges.size(); ++c)
    add(bodies.body_of(at(bodies.edges(), edges.edge[c])), edges.body[c], edges.depth[c]);
  std::vector<Overlap> list;
  list.reserve(pairs.size());
  for (const auto& [key, overlap] : pairs) list.push_back(overlap);
  return list;
}

}  // namespace palpate
