#include "fem/volume_patches.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <tuple>

namespace palpate::fem {
namespace {

constexpr std::uint32_t none = 0xffffffffU;

/// A tet at a point.
struct Corner {
  Index point = 0;
  Index material = 0;
  std::uint32_t tet = 0;
};

/// The tets of one material at a point: a range of corners.
struct Star {
  std::size_t begin = 0;
  std::size_t end = 0;
};

class Patches {
 public:
  explicit Patches(std::span<const PatchTet> tets) : tets_(tets), patch_of_tet_(tets.size(), none) {}

  std::vector<std::uint32_t> find() {
    list_neighbours();
    choose_centres();
    while (join_neighbours()) {
    }
    merge_small_patches();
    number_patches();
    return std::move(patch_of_tet_);
  }

 private:
  using Neighbours = std::array<std::uint32_t, 4>;  ///< across the faces of a tet, `none` without

  void list_neighbours() {
    struct Face {
      std::array<Index, 3> points{};
      Index material = 0;
      std::uint32_t tet = 0;
      std::uint32_t side = 0;
    };
    std::vector<Face> faces;
    for (std::uint32_t t = 0; t < tets_.size(); ++t) {
      for (std::uint32_t side = 0; side < 4; ++side) {
        const Tet& c = tets_[t].corners;
        Face face{{c[(side + 1) % 4], c[(side + 2) % 4], c[(side + 3) % 4]}, tets_[t].material, t, side};
        std::ranges::sort(face.points);
        faces.push_back(face);
      }
    }
    std::ranges::sort(faces, {}, [](const Face& f) { return std::tuple(f.points, f.material, f.tet); });
    neighbours_.assign(tets_.size(), {none, none, none, none});
    for (std::size_t k = 1; k < faces.size(); ++k) {
      const Face& a = faces[k - 1];
      const Face& b = faces[k];
      if (a.points != b.points || a.material != b.material) continue;
      neighbours_[a.tet][a.side] = b.tet;
      neighbours_[b.tet][b.side] = a.tet;
    }
  }

  [[nodiscard]] std::vector<Corner> corners() const {
    std::vector<Corner> all;
    for (std::uint32_t t = 0; t < tets_.size(); ++t) {
      for (const Index point : tets_[t].corners) all.push_back({point, tets_[t].material, t});
    }
    std::ranges::sort(all, {}, [](const Corner& c) { return std::tuple(c.point, c.material, c.tet); });
    return all;
  }

  /// Starts a patch of the tets at each centre.
  void choose_centres() {
    const std::vector<Corner> all = corners();
    std::vector<Star> stars;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const bool same = k > 0 && all[k].point == all[k - 1].point && all[k].material == all[k - 1].material;
      if (!same) stars.push_back({k, k});
      stars.back().end = k + 1;
    }
    std::ranges::stable_sort(stars, std::ranges::greater(), [](const Star& s) { return s.end - s.begin; });
    for (const Star& star : stars) {
      const std::span tets = std::span(all).subspan(star.begin, star.end - star.begin);
      if (std::ranges::any_of(tets, [&](const Corner& c) { return patch_of_tet_[c.tet] != none; })) continue;
      for (const Corner& c : tets) patch_of_tet_[c.tet] = static_cast<std::uint32_t>(sizes_.size());
      sizes_.push_back(tets.size());
    }
  }

  /// The patch other than `own` that has the most faces in common with some tets, then the smaller one, then
  /// the first; `none` without such a face.
  [[nodiscard]] std::uint32_t best_neighbour(std::span<const std::uint32_t> tets, std::uint32_t own) const {
    std::vector<std::uint32_t> near;
    for (const std::uint32_t t : tets) {
      for (const std::uint32_t other : neighbours_[t]) {
        if (other != none && patch_of_tet_[other] != none && patch_of_tet_[other] != own)
          near.push_back(patch_of_tet_[other]);
      }
    }
    std::ranges::sort(near);
    std::uint32_t best = none;
    std::size_t most = 0;
    for (auto first = near.begin(); first != near.end();) {
      const auto last = std::upper_bound(first, near.end(), *first);
      const auto faces = static_cast<std::size_t>(last - first);
      if (faces > most || (faces == most && sizes_[*first] < sizes_[best])) {
        best = *first;
        most = faces;
      }
      first = last;
    }
    return best;
  }

  /// Lets each tet without a patch join one across a face. Returns whether any has joined. Tets without a way
  /// across faces to a patch start one.
  bool join_neighbours() {
    std::vector<std::array<std::uint32_t, 2>> joins;  // tet and patch
    std::uint32_t first_left = none;
    for (std::uint32_t t = 0; t < tets_.size(); ++t) {
      if (patch_of_tet_[t] != none) continue;
      const std::uint32_t patch = best_neighbour(std::span(&t, 1), none);
      if (patch != none) joins.push_back({t, patch});
      if (first_left == none) first_left = t;
    }
    if (joins.empty() && first_left != none) {
      joins.push_back({first_left, static_cast<std::uint32_t>(sizes_.size())});
      sizes_.push_back(0);
    }
    for (const auto& [tet, patch] : joins) {
      patch_of_tet_[tet] = patch;
      ++sizes_[patch];
    }
    return !joins.empty();
  }

  void merge_small_patches() {
    std::vector<std::vector<std::uint32_t>> tets_of_patch(sizes_.size());
    for (std::uint32_t t = 0; t < tets_.size(); ++t) tets_of_patch[patch_of_tet_[t]].push_back(t);
    for (std::uint32_t patch = 0; patch < sizes_.size(); ++patch) {
      if (sizes_[patch] >= least_patch_tets) continue;
      const std::uint32_t target = best_neighbour(tets_of_patch[patch], patch);
      if (target == none) continue;
      for (const std::uint32_t t : tets_of_patch[patch]) {
        patch_of_tet_[t] = target;
        tets_of_patch[target].push_back(t);
      }
      sizes_[target] += sizes_[patch];
      sizes_[patch] = 0;
    }
  }

  /// Numbers patches without gaps.
  void number_patches() {
    std::vector<std::uint32_t> number(sizes_.size());
    std::uint32_t next = 0;
    for (std::size_t patch = 0; patch < sizes_.size(); ++patch) {
      number[patch] = next;
      if (sizes_[patch] != 0) ++next;
    }
    for (std::uint32_t& patch : patch_of_tet_) patch = number[patch];
  }

  std::span<const PatchTet> tets_;
  std::vector<std::uint32_t> patch_of_tet_;
  std::vector<Neighbours> neighbours_;
  std::vector<std::size_t> sizes_;  ///< tets of each patch
};

}  // namespace

std::vector<std::uint32_t> volume_patches(std::span<const PatchTet> tets) {
  return Patches(tets).find();
}

}  // namespace palpate::fem
