#pragma once

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "support/mean.hpp"

/// The scenes of examples/scenes, and measurements of their runs.
namespace palpate::test {

inline std::filesystem::path example_folder() {
  return PALPATE_SOURCE_DIR "/examples/scenes";
}

inline Scene example(const std::string& name) {
  return read_scene(example_folder() / (name + ".json"));
}

inline Simulation simulate(const Scene& scene, int threads = 2) {
  Model model = load_model(scene, [](const std::filesystem::path& path) -> TetMesh {
    throw Error(path.string(), "", "a mesh file", "none in the examples");
  });
  return Simulation(std::move(model), scene.settings, threads);
}

inline void run_to(Simulation& simulation, double time) {
  while (simulation.metrics().time < time - 1e-9) simulation.step();
}

/// The run of a scene until its end.
inline Simulation run(const Scene& scene, int threads = 2) {
  Simulation simulation = simulate(scene, threads);
  run_to(simulation, scene.duration);
  return simulation;
}

inline Index body_named(const Simulation& simulation, const std::string& name) {
  const Bodies& bodies = simulation.bodies();
  for (Index b = 0; b < bodies.body_count(); ++b) {
    if (at(bodies.bodies(), b).name == name) return b;
  }
  throw Error("examples", name, "no such body", "the name of a body");
}

inline Range points_of(const Simulation& simulation, const std::string& body) {
  return at(simulation.bodies().bodies(), body_named(simulation, body)).points;
}

inline Vec3 force_on(const Simulation& simulation, const std::string& body) {
  return at(simulation.contact_forces(), body_named(simulation, body));
}

inline double weight_of(const Simulation& simulation, const std::string& body) {
  return 9.81 * at(simulation.masses(), body_named(simulation, body));
}

inline Vec3 mean(const Simulation& simulation, const std::string& body, std::span<const Vec3> values) {
  return mean_of_body(simulation.bodies(), body_named(simulation, body), values);
}

inline Vec3 centre(const Simulation& simulation, const std::string& body) {
  return mean(simulation, body, simulation.positions());
}

inline Vec3 velocity(const Simulation& simulation, const std::string& body) {
  return mean(simulation, body, simulation.velocities());
}

/// Extent of a body along z.
struct Heights {
  double lowest = INFINITY;
  double highest = -INFINITY;
  [[nodiscard]] double extent() const { return highest - lowest; }
};

inline Heights heights(const Simulation& simulation, const std::string& body) {
  const Range points = points_of(simulation, body);
  Heights found;
  for (Index p = points.begin; p < points.end; ++p) {
    found.lowest = std::min(found.lowest, at(simulation.positions(), p).z);
    found.highest = std::max(found.highest, at(simulation.positions(), p).z);
  }
  return found;
}

/// Mean height of the points of a body whose x was at most `tolerance` from `x` at the start.
inline double height_at(const Simulation& simulation, const std::string& body, double x,
                        double tolerance = 1e-6) {
  const Range points = points_of(simulation, body);
  double sum = 0.0;
  int count = 0;
  for (Index p = points.begin; p < points.end; ++p) {
    if (std::abs(at(simulation.bodies().points_rest(), p).x - x) > tolerance) continue;
    sum += at(simulation.positions(), p).z;
    ++count;
  }
  EXPECT_GT(count, 0) << "no point at " << x;
  return sum / count;
}

struct SelfContacts {
  std::size_t count = 0;
  double deepest = 0.0;
};

/// Contacts of points with their own body.
inline SelfContacts self_contacts(const Simulation& simulation) {
  SelfContacts found;
  const Contacts& contacts = simulation.detector().contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (at(simulation.bodies().body_of_point(), contacts.point[c]) != contacts.body[c]) continue;
    ++found.count;
    found.deepest = std::max(found.deepest, contacts.depth[c]);
  }
  return found;
}

}  // namespace palpate::test
