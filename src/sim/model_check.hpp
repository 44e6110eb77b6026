#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/model.hpp>

#include "geometry/vector.hpp"

/// Completes the arrays of a model: empty ones are filled with default values.
namespace palpate {

/// Returns the flags, or `count` zeros if there are none. Throws Error if their number is not `count`.
inline std::vector<std::uint8_t> flags_or_none(const std::vector<std::uint8_t>& flags, std::size_t count,
                                               const char* name) {
  if (flags.empty()) return std::vector<std::uint8_t>(count, 0);
  if (flags.size() == count) return flags;
  throw Error("simulation", name, std::to_string(flags.size()) + " flags", std::to_string(count));
}

/// Per body, 1: rigid or absent.
inline std::vector<std::uint8_t> rigid_bodies(const Model& model) {
  auto rigid = flags_or_none(model.obstacles, model.bodies.bodies().size(), "obstacles");
  const auto absent = flags_or_none(model.absent, rigid.size(), "absent");
  for (std::size_t b = 0; b < rigid.size(); ++b) rigid[b] |= absent[b];
  return rigid;
}

/// Per point, the axes along which it does not move, 0 to 7. Throws Error on another number.
inline std::vector<std::uint8_t> axes_or_none(const Model& model) {
  auto axes = flags_or_none(model.fixed_axes, model.bodies.points_rest().size(), "fixed_axes");
  for (std::size_t p = 0; p < axes.size(); ++p) {
    if (axes[p] > 7) {
      throw Error("simulation", "fixed_axes[" + std::to_string(p) + "]", std::to_string(axes[p]),
                  "a sum of 1 (x), 2 (y) and 4 (z)");
    }
  }
  return axes;
}

/// Per point, 1: fixed or prescribed.
inline std::vector<std::uint8_t> constrained_points(const Model& model) {
  auto flags = flags_or_none(model.fixed_points, model.bodies.points_rest().size(), "fixed_points");
  for (std::size_t p = 0; p < model.motion_of_point.size() && p < flags.size(); ++p) {
    if (model.motion_of_point[p] >= 0) flags[p] = 1;
  }
  const std::vector<std::uint8_t> axes = axes_or_none(model);
  for (std::size_t p = 0; p < flags.size(); ++p) {
    if (axes[p] == 7) flags[p] = 1;
  }
  return flags;
}

}  // namespace palpate
