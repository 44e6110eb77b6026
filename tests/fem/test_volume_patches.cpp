// Patches of constant pressure. Oracle: their definition, checked tet by tet.
#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "fem/meshes.hpp"
#include "fem/volume_patches.hpp"
#include "support/meshes.hpp"

namespace palpate::fem {
namespace {

std::vector<PatchTet> tets_of(const TetMesh& mesh) {
  std::vector<PatchTet> tets;
  tets.reserve(mesh.tets.size());
  for (const Tet& corners : mesh.tets) tets.push_back({corners, 0});
  return tets;
}

using Lists = std::map<std::uint32_t, std::vector<std::size_t>>;

Lists lists_of(const std::vector<std::uint32_t>& patches) {
  Lists lists;
  for (std::size_t t = 0; t < patches.size(); ++t) lists[patches[t]].push_back(t);
  return lists;
}

bool have_common_face(const PatchTet& a, const PatchTet& b) {
  const auto common = std::ranges::count_if(
      a.corners, [&](Index point) { return std::ranges::find(b.corners, point) != b.corners.end(); });
  return common == 3;
}

bool is_connected(const std::vector<PatchTet>& tets, const std::vector<std::size_t>& patch) {
  std::set<std::size_t> left(patch.begin(), patch.end());
  std::vector<std::size_t> front{patch.front()};
  left.erase(patch.front());
  while (!front.empty()) {
    const std::size_t tet = front.back();
    front.pop_back();
    for (auto other = left.begin(); other != left.end();) {
      if (have_common_face(tets[tet], tets[*other])) {
        front.push_back(*other);
        other = left.erase(other);
      } else {
        ++other;
      }
    }
  }
  return left.empty();
}

std::vector<TetMesh> meshes() {
  return {test::box_mesh({5, 4, 4}, {0.5, 0.4, 0.4}), palpate::test::box_mesh({5, 4, 4}, {}, {1, 1, 1}),
          palpate::test::box_mesh({6, 6, 1}, {}, {1, 1, 1}), palpate::test::ball_mesh(6, {}, 1.0)};
}

TEST(VolumePatches, AreConnectedAndNotSmall) {
  for (const TetMesh& mesh : meshes()) {
    const std::vector<PatchTet> tets = tets_of(mesh);
    const Lists lists = lists_of(volume_patches(tets));
    EXPECT_EQ(lists.rbegin()->first + 1, lists.size());
    // Constraints of volume against degrees of freedom: fewer than one for each second point.
    EXPECT_LT(lists.size(), mesh.points.size() / 2);
    EXPECT_GT(lists.size(), mesh.points.size() / 30);
    for (const auto& [patch, members] : lists) {
      EXPECT_GE(members.size(), least_patch_tets);
      EXPECT_TRUE(is_connected(tets, members)) << patch;
    }
  }
}

/// Most patches have all tets at some point.
TEST(VolumePatches, HaveCentres) {
  for (const TetMesh& mesh : meshes()) {
    const std::vector<PatchTet> tets = tets_of(mesh);
    const auto patches = volume_patches(tets);
    std::vector<std::set<std::uint32_t>> around(mesh.points.size());
    for (std::size_t t = 0; t < tets.size(); ++t) {
      for (const Index point : tets[t].corners) around[static_cast<std::size_t>(point)].insert(patches[t]);
    }
    std::set<std::uint32_t> centred;
    for (const auto& own : around) {
      if (own.size() == 1) centred.insert(*own.begin());
    }
    EXPECT_EQ(centred.size(), lists_of(patches).size());
  }
}

TEST(VolumePatches, HaveTetsOfOneMaterial) {
  const TetMesh mesh = palpate::test::box_mesh({6, 4, 4}, {}, {1, 1, 1});
  std::vector<PatchTet> tets = tets_of(mesh);
  for (PatchTet& tet : tets)
    tet.material = mesh.points[static_cast<std::size_t>(tet.corners[0])].x < 0.5 ? 3 : 5;
  for (const auto& [patch, members] : lists_of(volume_patches(tets))) {
    for (const std::size_t t : members) EXPECT_EQ(tets[t].material, tets[members.front()].material);
  }
}

/// Tets that share no face keep patches of their own, but the tets at a point have one; without tets there is
/// none.
TEST(VolumePatches, OfSingleTets) {
  EXPECT_TRUE(volume_patches({}).empty());
  const std::vector<PatchTet> tets{{{0, 1, 2, 3}, 0}, {{3, 4, 5, 6}, 0}, {{6, 7, 8, 9}, 0}};
  const auto patches = volume_patches(tets);
  EXPECT_EQ(patches[0], patches[1]);
  EXPECT_NE(patches[1], patches[2]);
}

/// A body numbered behind another has the patches that it has alone.
TEST(VolumePatches, OfABodyDoNotDependOnOthers) {
  const TetMesh mesh = palpate::test::box_mesh({4, 3, 3}, {}, {1, 1, 1});
  const auto alone = lists_of(volume_patches(tets_of(mesh)));
  std::vector<PatchTet> both = tets_of(palpate::test::ball_mesh(4, {}, 1.0));
  const std::size_t first = both.size();
  for (PatchTet tet : tets_of(mesh)) {
    for (Index& point : tet.corners) point += 1000;
    both.push_back(tet);
  }
  std::set<std::vector<std::size_t>> expected;
  std::set<std::vector<std::size_t>> found;
  for (const auto& [patch, members] : alone) expected.insert(members);
  for (auto& [patch, members] : lists_of(volume_patches(both))) {
    if (members.front() < first) continue;
    for (std::size_t& t : members) t -= first;
    found.insert(members);
  }
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace palpate::fem
