#pragma once

#include <array>
#include <set>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>

#include "domain_mesher.hpp"
#include "mesh_options.hpp"
#include "tet_faces.hpp"

namespace palpate::app {

/// The relations of all pairs of tissues.
struct Relations {
  struct Pair {
    std::array<int, 2> tissues{};  ///< ascending, from 1
    Relation relation = Relation::grown;
  };
  Relation general = Relation::grown;
  std::vector<Pair> pairs{};  ///< if a pair has several entries, the last one counts
  [[nodiscard]] Relation between(int a, int b) const;
};

/// Tissues that are one body.
struct TissueBody {
  std::vector<int> tissues;  ///< ascending
  bool rigid = false;
  TetMesh mesh;                    ///< tets by tissue; points in the order of the whole mesh
  std::vector<int> tissue_of_tet;  ///< (n_tets), ascending
  std::vector<Index> points;       ///< (n_points) indices of its points in the whole mesh
};

/// Pairs of tissues that touch, each ascending, from 1.
using TissuePairs = std::set<std::array<int, 2>>;

/// Throws Error if tissues that slide or are open belong to one body because of relations with others.
/// `rigid[t - 1]` and `names[t - 1]` belong to tissue t. O(pairs x tissues).
void check_relations(const TissuePairs& pairs, const Relations& relations, const std::vector<bool>& rigid,
                     const std::vector<std::string>& names);

/// Cuts a mesh into bodies: soft tissues that are grown together are one, each rigid tissue is one by itself.
/// On both sides of a cut lie the same triangles, with points of their own. `rigid` and `names` are those of
/// tissue t at t - 1. Throws Error as check_relations() does. O(n log n).
std::vector<TissueBody> bodies_of(const LabelledMesh& mesh, const std::vector<InterfaceFace>& faces,
                                  const Relations& relations, const std::vector<bool>& rigid,
                                  const std::vector<std::string>& names);

}  // namespace palpate::app
