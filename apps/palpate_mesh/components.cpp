#include "components.hpp"

namespace palpate::app {

Components components_of(const std::array<int, 3>& size, std::span<const std::uint16_t> labels) {
  Components components;
  components.of.assign(labels.size(), -1);
  const auto row = static_cast<std::size_t>(size[0]);
  const std::array<std::size_t, 3> strides{1, row, row * static_cast<std::size_t>(size[1])};
  std::vector<std::size_t> open;
  const auto reach = [&](std::size_t point, std::uint16_t label) {
    if (components.of[point] >= 0 || labels[point] != label) return;
    components.of[point] = static_cast<std::int32_t>(components.sizes.size()) - 1;
    ++components.sizes.back();
    open.push_back(point);
  };
  for (std::size_t first = 0; first < labels.size(); ++first) {
    if (components.of[first] >= 0 || labels[first] == 0) continue;
    components.sizes.push_back(0);
    components.labels.push_back(labels[first]);
    reach(first, labels[first]);
    while (!open.empty()) {
      const std::size_t point = open.back();
      open.pop_back();
      for (std::size_t a = 0; a < 3; ++a) {
        const auto along = point / strides[a] % static_cast<std::size_t>(size[a]);
        if (along > 0) reach(point - strides[a], labels[first]);
        if (along + 1 < static_cast<std::size_t>(size[a])) reach(point + strides[a], labels[first]);
      }
    }
  }
  return components;
}

}  // namespace palpate::app
