#include "label_map.hpp"

#include <algorithm>
#include <map>

namespace palpate::app {

Vec3 Frame::to_world(const Vec3& p) const {
  const auto along = [&](double Vec3::*c) {
    return origin.*c + axes[0].*c * p.x + axes[1].*c * p.y + axes[2].*c * p.z;
  };
  return {along(&Vec3::x), along(&Vec3::y), along(&Vec3::z)};
}

std::vector<LabelExtent> labels_in(const LabelMap& map) {
  std::map<std::int32_t, LabelExtent> found;
  LabelExtent* last = nullptr;  // usually the next voxel has the same label
  for (int k = 0; k < map.size[2]; ++k) {
    for (int j = 0; j < map.size[1]; ++j) {
      for (int i = 0; i < map.size[0]; ++i) {
        const std::int32_t label = map.at(i, j, k);
        if (label == 0) continue;
        const std::array<int, 3> voxel{i, j, k};
        if (last == nullptr || last->label != label) {
          last = &found.try_emplace(label, LabelExtent{label, 0, {voxel, voxel}}).first->second;
        }
        ++last->voxels;
        for (std::size_t a = 0; a < 3; ++a) {
          last->box.lower[a] = std::min(last->box.lower[a], voxel[a]);
          last->box.upper[a] = std::max(last->box.upper[a], voxel[a]);
        }
      }
    }
  }
  std::vector<LabelExtent> extents;
  extents.reserve(found.size());
  for (const auto& [label, extent] : found) extents.push_back(extent);
  return extents;
}

}  // namespace palpate::app
