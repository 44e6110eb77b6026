#include "anatomy/largest_part.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "geometry/vector.hpp"

namespace palpate::anatomy {
namespace {

/// Sets of tets that hang together (union-find with path halving).
class Parts {
 public:
  explicit Parts(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The lower of two representatives stays, so that the first part wins.
  void join(std::size_t i, std::size_t j) {
    const std::size_t a = find(i);
    const std::size_t b = find(j);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

Parts parts_of(const TetMesh& mesh) {
  std::vector<std::pair<std::array<Index, 3>, std::size_t>> faces;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      std::array<Index, 3> face{};
      for (std::size_t i = 0; i < 3; ++i) face[i] = mesh.tets[t][(opposite + 1 + i) % 4];
      std::ranges::sort(face);
      faces.emplace_back(face, t);
    }
  }
  std::ranges::sort(faces);
  Parts parts(mesh.tets.size());
  for (std::size_t f = 1; f < faces.size(); ++f) {
    if (faces[f].first == faces[f - 1].first) parts.join(faces[f].second, faces[f - 1].second);
  }
  return parts;
}

}  // namespace

TetMesh largest_part(const TetMesh& mesh) {
  if (mesh.tets.empty()) return {};
  Parts parts = parts_of(mesh);
  std::vector<std::size_t> sizes(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) ++sizes[parts.find(t)];
  const auto largest = static_cast<std::size_t>(std::ranges::max_element(sizes) - sizes.begin());

  TetMesh part;
  std::vector<Index> number(mesh.points.size(), -1);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (parts.find(t) != largest) continue;
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

}  // namespace palpate::anatomy
