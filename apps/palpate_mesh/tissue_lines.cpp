#include "tissue_lines.hpp"

#include <array>
#include <cstddef>
#include <map>
#include <set>

#include "geometry/vector.hpp"
#include "lattice.hpp"

namespace palpate::app {
namespace {

constexpr int margin = 3;  // voxels around the map; there is no tissue at their end, so no line ends there

/// Steps of the lattice a voxel. With one, edges of tets jump over layers that are oblique to the voxels and
/// thinner than 1.7 of them, and tissues seem to meet that do not. With three, an edge is as long as a layer
/// of one oblique voxel is thick.
constexpr int parts = 3;

using Corner = std::array<int, 3>;

/// The six tets of a cell of the lattice that share its diagonal (Kuhn 1960). They fit those of the
/// neighbours.
constexpr std::array<std::array<Corner, 4>, 6> tets_of_cell{{{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}}},
                                                             {{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {1, 1, 1}}},
                                                             {{{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 1, 1}}},
                                                             {{{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {1, 1, 1}}},
                                                             {{{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}}},
                                                             {{{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 1, 1}}}}};

bool all_differ(const std::array<int, 3>& t) {
  return t[0] != t[1] && t[1] != t[2] && t[0] != t[2];
}

/// The point in a triangle where the three tissues of its corners meet: usually one of its four parts has all
/// three again, as in Sperner's lemma. Where none has, since a tissue reaches across an edge, the middle of
/// the smallest part found.
Vec3 meeting_point(const Tissues& tissues, std::array<Vec3, 3> p, std::array<int, 3> tissue) {
  constexpr int rounds = 8;
  for (int round = 0; round < rounds; ++round) {
    const std::array<Vec3, 3> m{0.5 * (p[1] + p[2]), 0.5 * (p[2] + p[0]), 0.5 * (p[0] + p[1])};
    const std::array<int, 3> at{tissues.at(m[0]), tissues.at(m[1]), tissues.at(m[2])};
    if (all_differ({tissue[0], at[2], at[1]})) {
      p = {p[0], m[2], m[1]};
      tissue = {tissue[0], at[2], at[1]};
    } else if (all_differ({at[2], tissue[1], at[0]})) {
      p = {m[2], p[1], m[0]};
      tissue = {at[2], tissue[1], at[0]};
    } else if (all_differ({at[1], at[0], tissue[2]})) {
      p = {m[1], m[0], p[2]};
      tissue = {at[1], at[0], tissue[2]};
    } else if (all_differ(at)) {
      p = m;
      tissue = at;
    } else {
      break;
    }
  }
  return (1.0 / 3.0) * (p[0] + p[1] + p[2]);
}

/// Makes a point of the graph in each triangle of the lattice whose corners are of three tissues, and one in
/// each tet of four tissues. A tet of three tissues has two such triangles, one of four tissues has four.
class LineTracer {
 public:
  explicit LineTracer(const Tissues& tissues) : tissues_(&tissues) {
    Lattice voxels;
    for (std::size_t a = 0; a < 3; ++a) {
      voxels.size[a] = tissues.size()[a] + 2 * margin;
      fine_.size[a] = parts * (voxels.size[a] - 1) + 1;
    }
    std::vector<int> tissue;
    for_points(voxels.size, [&](int i, int j, int k) {
      tissue.push_back(tissues.at(place({parts * i, parts * j, parts * k})));
    });
    for_points({voxels.size[0] - 1, voxels.size[1] - 1, voxels.size[2] - 1}, [&](int i, int j, int k) {
      std::set<int> found;
      for_points({2, 2, 2},
                 [&](int x, int y, int z) { found.insert(tissue[voxels.index(i + x, j + y, k + z)]); });
      if (found.size() > 2) add({parts * i, parts * j, parts * k});
    });
  }

  TissueLines lines;

 private:
  [[nodiscard]] std::size_t index(const Corner& c) const { return fine_.index(c[0], c[1], c[2]); }
  [[nodiscard]] Vec3 place(const Corner& c) const {
    const Vec3& s = tissues_->spacing();
    const auto along = [&](std::size_t a) { return static_cast<double>(c[a]) / parts - margin; };
    return {along(0) * s.x, along(1) * s.y, along(2) * s.z};
  }

  /// Adds what is between eight voxel centres.
  void add(const Corner& lowest) {
    Lattice inside;
    inside.size.fill(parts + 1);
    std::vector<int> tissue;
    for_points(inside.size, [&](int x, int y, int z) {
      tissue.push_back(tissues_->at(place({lowest[0] + x, lowest[1] + y, lowest[2] + z})));
    });
    for_points({parts, parts, parts}, [&](int x, int y, int z) {
      for (const auto& tet : tets_of_cell) {
        std::array<Corner, 4> corners{};
        std::array<int, 4> of_corners{};
        for (std::size_t c = 0; c < 4; ++c) {
          const Corner at{x + tet[c][0], y + tet[c][1], z + tet[c][2]};
          of_corners[c] = tissue[inside.index(at[0], at[1], at[2])];
          for (std::size_t a = 0; a < 3; ++a) corners[c][a] = lowest[a] + at[a];
        }
        add(corners, of_corners);
      }
    });
  }

  void add(const std::array<Corner, 4>& tet, const std::array<int, 4>& tissue) {
    std::vector<std::size_t> crossed;
    for (const auto& [a, b, c] : {std::array{1U, 2U, 3U}, {0U, 2U, 3U}, {0U, 1U, 3U}, {0U, 1U, 2U}}) {
      const std::array<int, 3> of_face{tissue[a], tissue[b], tissue[c]};
      if (all_differ(of_face)) crossed.push_back(point_of({tet[a], tet[b], tet[c]}, of_face));
    }
    if (crossed.size() == 2) connect(crossed[0], crossed[1]);
    if (crossed.size() < 4) return;
    Vec3 middle;
    for (const std::size_t p : crossed) middle += 0.25 * lines.points[p];
    const std::size_t junction = added(middle);
    for (const std::size_t p : crossed) connect(junction, p);
  }

  std::size_t point_of(const std::array<Corner, 3>& face, const std::array<int, 3>& tissue) {
    const auto [it, is_new] =
        of_face_.try_emplace({index(face[0]), index(face[1]), index(face[2])}, lines.points.size());
    if (is_new) added(meeting_point(*tissues_, {place(face[0]), place(face[1]), place(face[2])}, tissue));
    return it->second;
  }
  std::size_t added(const Vec3& place) {
    lines.points.push_back(place);
    lines.next.emplace_back();
    return lines.points.size() - 1;
  }
  void connect(std::size_t a, std::size_t b) {
    lines.next[a].push_back(b);
    lines.next[b].push_back(a);
  }

  const Tissues* tissues_;
  Lattice fine_;  ///< `parts` steps a voxel, and a margin around the map; without values
  std::map<std::array<std::size_t, 3>, std::size_t> of_face_;
};

/// Moves points between two neighbours towards their middle. Triangles of the lattice and the steps of voxels
/// make lines rough. The points are about a twelfth of a voxel apart, so ten rounds average over about half a
/// voxel. With more, lines leave narrow tissues, and layers of one voxel get holes beside them.
void smooth(TissueLines& lines) {
  constexpr int rounds = 10;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<Vec3> before = lines.points;
    for (std::size_t p = 0; p < before.size(); ++p) {
      const auto& next = lines.next[p];
      if (next.size() == 2) lines.points[p] = 0.5 * before[p] + 0.25 * (before[next[0]] + before[next[1]]);
    }
  }
}

}  // namespace

TissueLines tissue_lines(const Tissues& tissues) {
  TissueLines lines = LineTracer(tissues).lines;
  smooth(lines);
  return lines;
}

std::vector<std::array<Vec3, 2>> segments_of(const TissueLines& lines) {
  std::vector<std::array<Vec3, 2>> segments;
  for (std::size_t p = 0; p < lines.points.size(); ++p) {
    for (const std::size_t q : lines.next[p]) {
      if (p < q) segments.push_back({lines.points[p], lines.points[q]});
    }
  }
  return segments;
}

}  // namespace palpate::app
