#include "anatomy/eye_labels.hpp"

#include <cmath>
#include <utility>

#include <palpate/error.hpp>

#include "anatomy/eye_shapes.hpp"
#include "anatomy/shapes.hpp"

namespace palpate::anatomy {
namespace {

/// Organs in order: a place that is in several belongs to the first.
std::vector<std::pair<std::string, Distance>> organs() {
  std::vector<std::pair<std::string, Distance>> all{{"bulb", bulb_shape()}};
  for (const auto& [name, angle] : eye_recti) all.emplace_back(name, rectus_shape(angle, 0.0));
  all.emplace_back("nerve", common({nerve_shape(0.0), cavity_shape()}));
  all.emplace_back("skin", skin_shape(0.0));
  all.emplace_back("fat", common({cavity_shape(), under_skin_shape()}));
  all.emplace_back("bone", bone_shape());
  return all;
}

std::uint8_t label_at(const std::vector<std::pair<std::string, Distance>>& organs, const Vec3& p) {
  for (std::size_t o = 0; o < organs.size(); ++o) {
    if (organs[o].second(p) < 0.0) return static_cast<std::uint8_t>(o + 1);
  }
  return 0;
}

}  // namespace

OrganLabels eye_labels(double edge) {
  constexpr double least = 0.25;
  constexpr double most = 4.0;
  if (!(edge >= least && edge <= most))
    throw Error("eye_labels", "edge", std::to_string(edge), "0.25 to 4 mm");
  constexpr Vec3 lower{-33.0, -20.0, -33.0};
  constexpr Vec3 upper{33.0, 51.0, 33.0};
  const auto organs = anatomy::organs();
  OrganLabels map;
  const auto cubes = [&](double low, double high) {
    return static_cast<int>(std::ceil((high - low) / edge));
  };
  map.size = {cubes(lower.x, upper.x), cubes(lower.y, upper.y), cubes(lower.z, upper.z)};
  map.origin = {lower.x + 0.5 * edge, lower.y + 0.5 * edge, lower.z + 0.5 * edge};
  map.edge = edge;
  for (const auto& [name, shape] : organs) map.names.push_back(name);
  for (int k = 0; k < map.size[2]; ++k) {
    for (int j = 0; j < map.size[1]; ++j) {
      for (int i = 0; i < map.size[0]; ++i) {
        map.labels.push_back(
            label_at(organs, {map.origin.x + i * edge, map.origin.y + j * edge, map.origin.z + k * edge}));
      }
    }
  }
  return map;
}

}  // namespace palpate::anatomy
