#include "view/wrenches.hpp"

#include <cstddef>
#include <vector>

#include "geometry/vector.hpp"

namespace palpate::view {
namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const Vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

Json wrench_json(const Wrench& wrench) {
  return {{"force", vector_json(wrench.force)}, {"torque", vector_json(wrench.torque)}};
}

Json wrenches_json(const Simulation& simulation) {
  const Index count = simulation.bodies().body_count();
  std::vector<Wrench> sums;
  sums.reserve(static_cast<std::size_t>(count));
  for (Index b = 0; b < count; ++b) {
    sums.push_back({.force = {}, .torque = {}, .about = simulation.center_of_mass(b)});
  }
  const auto add = [&](Index body, const Wrench& wrench, double sign) {
    const Wrench here = moved_to(wrench, at(sums, body).about);
    at(sums, body).force += sign * here.force;
    at(sums, body).torque += sign * here.torque;
  };
  for (const PairWrench& pair : simulation.pair_wrenches()) {
    if (pair.body_a == pair.body_b) continue;
    add(pair.body_b, pair.on_b, 1.0);
    add(pair.body_a, pair.on_b, -1.0);
  }
  Json list = Json::array();
  for (const Wrench& sum : sums) {
    list.push_back(wrench_json(sum));
  }
  return list;
}

}  // namespace palpate::view
