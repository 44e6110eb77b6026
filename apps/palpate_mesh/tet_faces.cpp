#include "tet_faces.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include <palpate/error.hpp>

namespace palpate::app {
namespace {

struct Side {
  std::array<Index, 3> points{};
  Index tet = 0;
};

std::vector<Side> sides_of(const TetMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(4 * mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      Side side{{}, static_cast<Index>(t)};
      std::size_t next = 0;
      for (std::size_t c = 0; c < 4; ++c) {
        if (c != opposite) side.points[next++] = mesh.tets[t][c];
      }
      std::ranges::sort(side.points);
      sides.push_back(side);
    }
  }
  std::ranges::sort(sides, {}, [](const Side& side) { return std::pair(side.points, side.tet); });
  return sides;
}

}  // namespace

std::vector<InterfaceFace> interface_faces(const LabelledMesh& mesh) {
  const std::vector<Side> sides = sides_of(mesh.mesh);
  const auto label = [&](Index tet) { return tet < 0 ? 0 : mesh.labels[static_cast<std::size_t>(tet)]; };
  std::vector<InterfaceFace> faces;
  for (std::size_t first = 0, end = 0; first < sides.size(); first = end) {
    while (end < sides.size() && sides[end].points == sides[first].points) ++end;
    if (end - first > 2) throw Error("meshing", "", fmt::format("a face of {} tets", end - first), "two");
    Index a = sides[first].tet;
    Index b = end - first == 2 ? sides[first + 1].tet : -1;
    if (label(a) == label(b)) continue;
    if (label(a) > label(b)) std::swap(a, b);
    faces.push_back({sides[first].points, {a, b}, {label(a), label(b)}});
  }
  return faces;
}

}  // namespace palpate::app
