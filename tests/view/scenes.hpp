#pragma once

#include <memory>
#include <string>

#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "view/live.hpp"

/// Small scenes for the viewer.
namespace palpate::test {

/// A soft box above a fixed plate; a press with a prescribed motion beside it that sinks by 10 mm in a
/// second.
inline Scene small_scene() {
  return read_scene_text(R"({"name": "small", "time_step": 0.01, "contact": {"friction": 0.3}, "bodies": [
    {"name": "plate", "box": {"cells": [2, 2, 1], "size": [0.2, 0.2, 0.02]}, "translate": [0, 0, -0.01], "obstacle": true},
    {"name": "box", "box": {"cells": [3, 3, 3], "size": [0.06, 0.06, 0.06]}, "rotate": {"angle": 10},
     "translate": [0.003, 0.002, 0.0299], "material": {"young_modulus": 20000, "mass_damping": 1, "stiffness_damping": 0.002}},
    {"name": "press", "box": {"cells": [1, 1, 1], "size": [0.03, 0.03, 0.03]}, "translate": [0.07, 0, 0.05],
     "motion": {"keyframes": [{"time": 0}, {"time": 1, "translate": [0, 0, -0.01]}]}}]})",
                         "small");
}

/// Two bars of one cell that cross edge on edge, the upper one 1 mm in the lower one: no point is in the
/// other.
inline Scene crossed_bars() {
  return read_scene_text(R"({"name": "bars", "time_step": 0.01, "gravity": [0, 0, 0], "bodies": [
    {"name": "lower", "box": {"cells": [1, 1, 1], "size": [0.2, 0.02, 0.02]}, "obstacle": true},
    {"name": "upper", "box": {"cells": [1, 1, 1], "size": [0.02, 0.2, 0.02]}, "translate": [0.003, 0.001, 0.019],
     "material": {"young_modulus": 1e6}}]})",
                         "bars");
}

inline Model small_model(const Scene& scene) {
  return load_model(scene, [](const auto&) { return TetMesh{}; });
}

inline std::unique_ptr<view::LiveSource> small_source() {
  const Scene scene = small_scene();
  return std::make_unique<view::LiveSource>(scene, small_model(scene), 1);
}

inline void run(view::LiveSource& source, int steps) {
  for (int i = 0; i < steps; ++i) source.advance();
}

}  // namespace palpate::test
