#pragma once

#include <nlohmann/json.hpp>

#include <palpate/simulation.hpp>

namespace palpate::view {

/// A wrench as JSON: {"force": [x, y, z], "torque": [x, y, z]}.
nlohmann::ordered_json wrench_json(const Wrench& wrench);

/// The wrench of contacts on each body in the last step: {"force": [x, y, z], "torque": [x, y, z]} per body,
/// torques about its centre of mass, in the units of the scene. Contacts of a body with itself add up to
/// zero. O(contacts log).
nlohmann::ordered_json wrenches_json(const Simulation& simulation);

}  // namespace palpate::view
