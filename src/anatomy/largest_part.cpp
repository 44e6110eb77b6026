#include "anatomy/largest_part.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "geometry/disjoint_sets.hpp"
#include "geometry/vector.hpp"

namespace palpate::anatomy {
namespace {

using Face = std::array<Index, 3>;         ///< corners, ascending
using FaceCorners = std::array<Index, 2>;  ///< of a face: corners, ascending

/// The faces of tets, sorted, each with its tet.
std::vector<std::pair<Face, Index>> faces_of(const TetMesh& mesh) {
  std::vector<std::pair<Face, Index>> faces;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      Face face{};
      for (std::size_t i = 0; i < 3; ++i) face[i] = mesh.tets[t][(opposite + 1 + i) % 4];
      std::ranges::sort(face);
      faces.emplace_back(face, static_cast<Index>(t));
    }
  }
  std::ranges::sort(faces);
  return faces;
}

/// The edges of more than two surface faces.
std::vector<FaceCorners> pinched_edges(const TetMesh& mesh) {
  const auto faces = faces_of(mesh);
  std::vector<FaceCorners> sides;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Face& face = faces[f].first;
    const bool is_inner =
        (f > 0 && faces[f - 1].first == face) || (f + 1 < faces.size() && faces[f + 1].first == face);
    if (!is_inner) sides.insert(sides.end(), {{face[0], face[1]}, {face[0], face[2]}, {face[1], face[2]}});
  }
  std::ranges::sort(sides);
  std::vector<FaceCorners> pinched;
  for (std::size_t i = 2; i < sides.size(); ++i) {
    if (sides[i] == sides[i - 2] && (pinched.empty() || pinched.back() != sides[i]))
      pinched.push_back(sides[i]);
  }
  return pinched;
}

DisjointSets parts_of(const TetMesh& mesh) {
  const auto faces = faces_of(mesh);
  DisjointSets parts(mesh.tets.size());
  for (std::size_t f = 1; f < faces.size(); ++f) {
    if (faces[f].first == faces[f - 1].first) parts.join(faces[f].second, faces[f - 1].second);
  }
  return parts;
}

/// For each tet the representative of its part, and how many tets each part has.
struct Sizes {
  std::vector<std::size_t> part;
  std::vector<std::size_t> size;  ///< by representative
  [[nodiscard]] std::size_t largest() const {
    return static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
  }
};

Sizes sizes_of(const TetMesh& mesh) {
  DisjointSets parts = parts_of(mesh);
  Sizes sizes{std::vector<std::size_t>(mesh.tets.size()), std::vector<std::size_t>(mesh.tets.size())};
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    sizes.part[t] = static_cast<std::size_t>(parts.find(static_cast<Index>(t)));
    ++sizes.size[sizes.part[t]];
  }
  return sizes;
}

/// Marks the tets around an edge that are not in the largest fan.
void mark_smaller_fans(const TetMesh& mesh, const FaceCorners& edge, std::vector<bool>& dropped) {
  TetMesh fans;
  std::vector<std::size_t> tets;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    if (dropped[t] || std::ranges::count(tet, edge[0]) == 0 || std::ranges::count(tet, edge[1]) == 0)
      continue;
    tets.push_back(t);
    fans.tets.push_back(tet);
  }
  if (tets.empty()) return;
  const Sizes sizes = sizes_of(fans);
  for (std::size_t i = 0; i < tets.size(); ++i) {
    if (sizes.part[i] != sizes.largest()) dropped[tets[i]] = true;
  }
}

}  // namespace

TetMesh largest_part(const TetMesh& mesh) {
  if (mesh.tets.empty()) return {};
  const Sizes sizes = sizes_of(mesh);
  const std::size_t largest = sizes.largest();
  TetMesh part;
  std::vector<Index> number(mesh.points.size(), -1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (sizes.part[t] != largest) continue;
    part.tets.push_back(mesh.tets[t]);
    for (const Index p : mesh.tets[t]) at(number, p) = 0;
  }
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    if (number[p] < 0) continue;
    number[p] = static_cast<Index>(part.points.size());
    part.points.push_back(mesh.points[p]);
  }
  for (Tet& tet : part.tets) {
    for (Index& p : tet) p = at(number, p);
  }
  return part;
}

TetMesh without_pinched_edges(TetMesh mesh) {
  for (;;) {
    const std::vector<FaceCorners> pinched = pinched_edges(mesh);
    if (pinched.empty()) return mesh;
    std::vector<bool> dropped(mesh.tets.size(), false);
    for (const FaceCorners& edge : pinched) mark_smaller_fans(mesh, edge, dropped);
    std::vector<Tet> kept;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      if (!dropped[t]) kept.push_back(mesh.tets[t]);
    }
    mesh.tets = std::move(kept);
  }
}

}  // namespace palpate::anatomy
