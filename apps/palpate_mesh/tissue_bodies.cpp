#include "tissue_bodies.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>

#include <palpate/error.hpp>

#include "geometry/disjoint_sets.hpp"

namespace palpate::app {
namespace {

using Pair = std::array<int, 2>;

TissuePairs touching(const std::vector<InterfaceFace>& faces) {
  TissuePairs pairs;
  for (const InterfaceFace& face : faces) {
    if (face.labels[0] > 0) pairs.insert(face.labels);
  }
  return pairs;
}

/// The lowest tissue of the body of each tissue (1 to n; 0 is not used).
std::vector<int> body_of_tissues(const TissuePairs& pairs, const Relations& relations,
                                 const std::vector<bool>& rigid) {
  DisjointSets bodies(rigid.size() + 1);
  const auto is_rigid = [&](int t) { return rigid[static_cast<std::size_t>(t - 1)]; };
  for (const auto& [a, b] : pairs) {
    if (relations.between(a, b) != Relation::grown || is_rigid(a) || is_rigid(b)) continue;
    bodies.join(a, b);
  }
  std::vector<int> lowest(rigid.size() + 1);
  for (std::size_t tissue = 0; tissue < lowest.size(); ++tissue)
    lowest[tissue] = bodies.find(static_cast<Index>(tissue));
  return lowest;
}

TissueBody body_of(const LabelledMesh& mesh, std::vector<int> tissues) {
  TissueBody body;
  std::map<Index, Index> own;  // index in the body, by index in the whole mesh
  for (std::size_t t = 0; t < mesh.mesh.tets.size(); ++t) {
    if (std::ranges::count(tissues, mesh.labels[t]) == 0) continue;
    for (const Index p : mesh.mesh.tets[t]) own.emplace(p, 0);
  }
  for (auto& [point, index] : own) {
    index = static_cast<Index>(body.points.size());
    body.points.push_back(point);
    body.mesh.points.push_back(mesh.mesh.points[static_cast<std::size_t>(point)]);
  }
  for (const int tissue : tissues) {
    for (std::size_t t = 0; t < mesh.mesh.tets.size(); ++t) {
      if (mesh.labels[t] != tissue) continue;
      Tet tet = mesh.mesh.tets[t];
      for (Index& p : tet) p = own.at(p);
      body.mesh.tets.push_back(tet);
      body.tissue_of_tet.push_back(tissue);
    }
  }
  body.tissues = std::move(tissues);
  return body;
}

}  // namespace

Relation Relations::between(int a, int b) const {
  Relation found = general;
  for (const Pair& pair : pairs) {
    if (pair.tissues[0] == std::min(a, b) && pair.tissues[1] == std::max(a, b)) found = pair.relation;
  }
  return found;
}

void check_relations(const TissuePairs& pairs, const Relations& relations, const std::vector<bool>& rigid,
                     const std::vector<std::string>& names) {
  const std::vector<int> lowest = body_of_tissues(pairs, relations, rigid);
  for (const auto& [a, b] : pairs) {
    const Relation relation = relations.between(a, b);
    if (relation == Relation::grown) continue;
    if (lowest[static_cast<std::size_t>(a)] != lowest[static_cast<std::size_t>(b)]) continue;
    const std::string& first = names[static_cast<std::size_t>(a - 1)];
    const std::string& second = names[static_cast<std::size_t>(b - 1)];
    throw Error("--relation", fmt::format("{}:{}", first, second),
                fmt::format("'{}' of tissues that are grown together through others",
                            relation_names[static_cast<std::size_t>(relation)]),
                fmt::format("{}:{}=grown, or another relation on the way between them", first, second));
  }
}

std::vector<TissueBody> bodies_of(const LabelledMesh& mesh, const std::vector<InterfaceFace>& faces,
                                  const Relations& relations, const std::vector<bool>& rigid,
                                  const std::vector<std::string>& names) {
  const TissuePairs pairs = touching(faces);
  check_relations(pairs, relations, rigid, names);
  const std::vector<int> lowest = body_of_tissues(pairs, relations, rigid);
  std::map<int, std::vector<int>> groups;
  for (int t = 1; t < static_cast<int>(lowest.size()); ++t) {
    if (std::ranges::count(mesh.labels, t) > 0) groups[lowest[static_cast<std::size_t>(t)]].push_back(t);
  }
  std::vector<TissueBody> bodies;
  for (const auto& [first, tissues] : groups) {
    bodies.push_back(body_of(mesh, tissues));
    bodies.back().rigid = rigid[static_cast<std::size_t>(first - 1)];
  }
  return bodies;
}

}  // namespace palpate::app
