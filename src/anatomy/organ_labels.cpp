#include "anatomy/organ_labels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomy/eye_shapes.hpp"
#include "anatomy/millimetres.hpp"
#include "anatomy/shapes.hpp"

namespace palpate::anatomy {
namespace {

using Shapes = std::vector<std::pair<std::string, Distance>>;

/// The organs in the cavity except fat. If several contain a position, the first one counts.
Shapes inner_organs() {
  Shapes all{{"bulb", bulb_shape()}};
  for (const auto& [name, angle] : eye_recti) all.emplace_back(name, rectus_shape(angle, 0.0));
  all.emplace_back("nerve", common({nerve_shape(0.0), cavity_shape()}));
  return all;
}

Shapes eye_organs() {
  Shapes all = inner_organs();
  all.emplace_back("skin", skin_shape(0.0));
  all.emplace_back("fat", common({cavity_shape(), under_skin_shape()}));
  all.emplace_back("bone", bone_shape());
  return all;
}

/// An upright elliptic column: negative inside, of the right size of a distance near its wall.
Distance column(const FloorDefect& defect) {
  const double a = 0.5 * defect.width;
  const double b = 0.5 * defect.length;
  return [=](const Vec3& p) {
    return (std::hypot((p.x - defect.x) / a, (p.y - defect.y) / b) - 1.0) * std::min(a, b);
  };
}

Shapes orbit_organs(const FloorDefect& defect) {
  Shapes all = inner_organs();
  const Distance behind_lids = half_space({0.0, -6.0, 0.0}, {0.0, -1.0, 0.0});
  all.emplace_back("fat", common({cavity_shape(), under_skin_shape(), behind_lids}));
  const Distance bone = orbit_bone_shape();
  const Distance floor = common({bone, orbit_floor_shape()});
  all.emplace_back("fragment", common({floor, column(defect)}));
  all.emplace_back("floor", floor);
  all.emplace_back("bone", bone);
  return all;
}

std::uint8_t label_at(const Shapes& organs, const Vec3& p) {
  for (std::size_t o = 0; o < organs.size(); ++o) {
    if (organs[o].second(p) < 0.0) return static_cast<std::uint8_t>(o + 1);
  }
  return 0;
}

OrganLabels labels_of(const Shapes& organs, double edge, const Vec3& lower, const Vec3& upper) {
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

constexpr double least_edge = 0.25;
constexpr double most_edge = 4.0;

}  // namespace

OrganLabels eye_labels(double edge) {
  MillimetreCheck{"eye_labels"}("edge", edge, least_edge, most_edge);
  return labels_of(eye_organs(), edge, {-33.0, -20.0, -33.0}, {33.0, 51.0, 33.0});
}

OrganLabels orbit_labels(double edge, const FloorDefect& defect) {
  const MillimetreCheck check{"orbit_labels"};
  check("edge", edge, least_edge, most_edge);
  check("width", defect.width, 2.0, 22.0);
  check("length", defect.length, 2.0, 24.0);
  check("x", defect.x, -8.0, 8.0);
  check("y", defect.y, 0.0, 16.0);
  return labels_of(orbit_organs(defect), edge, {-33.0, -20.0, -50.0}, {33.0, 51.0, 33.0});
}

}  // namespace palpate::anatomy
