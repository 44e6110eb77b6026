#pragma once

#include <array>
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
  std::vector<Pair> pairs{};  ///< of several entries for a pair the last one holds
  [[nodiscard]] Relation between(int a, int b) const;
};

/// Tissues that are one body.
struct TissueBody {
  std::vector<int> tissues;  ///< ascending
  bool rigid = false;
  TetMesh mesh;                    ///< tets by tissue; points in the order of the whole mesh
  std::vector<int> tissue_of_tet;  ///< (n_tets), ascending
  std::vector<Index> points;       ///< (n_points), their indices in the whole mesh
};

/// Cuts a mesh into bodies: soft tissues that are grown together are one, each rigid tissue is one by itself.
/// Both sides of a cut have the same triangles, each with points of its own. Index t - 1 of `rigid` and
/// `names` is tissue t. Throws Error where tissues that slide or are open belong to one body by way of
/// others. O(n log n).
std::vector<TissueBody> bodies_of(const LabelledMesh& mesh, const std::vector<InterfaceFace>& faces,
                                  const Relations& relations, const std::vector<bool>& rigid,
                                  const std::vector<std::string>& names);

}  // namespace palpate::app
