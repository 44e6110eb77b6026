// The cost of the stable neo-Hookean law relative to the corotational one: the pass over the elements of a
// block, and steps of the eye with all soft bodies of one law. One thread; the laws take turns.
#include <filesystem>
#include <utility>
#include <vector>

#include <palpate/io/mesh_reader.hpp>
#include <palpate/simulation.hpp>

#include "fem/elements.hpp"
#include "our_dynamics.hpp"
#include "scene/generators.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

namespace fs = std::filesystem;

constexpr int tissue_frames = 60;
constexpr int cells = 16;

Json result(const char* name, double tets, int frames, double corotational, double neo_hookean) {
  return {{"name", name},
          {"tets", tets},
          {"frames", frames},
          {"corotational_ms", corotational},
          {"neo_hookean_ms", neo_hookean}};
}

Json measure_passes(int frames) {
  Bodies bodies;
  bodies.add("block", make_box({cells, cells, cells}, {0.1, 0.1, 0.1}));
  Material soft{.young_modulus = 2e4, .poisson_ratio = 0.45};
  const std::vector<std::uint8_t> obstacles(1, 0);
  fem::Elements corotational(bodies, {soft}, obstacles);
  soft.model = MaterialModel::stable_neo_hookean;
  fem::Elements neo_hookean(bodies, {soft}, obstacles);
  const parallel::Threads one(1);
  std::vector<double> ours;
  std::vector<double> theirs;
  constexpr int warm_up = 2;
  for (int f = 0; f < warm_up + frames; ++f) {
    const std::vector<Vec3> positions = deformed(bodies.points_rest(), f);
    const double other = milliseconds([&] { corotational.update(one, positions); });
    const double time = milliseconds([&] { neo_hookean.update(one, positions); });
    if (f < warm_up) continue;
    theirs.push_back(other);
    ours.push_back(time);
  }
  return result("element pass", static_cast<double>(bodies.tets().size()), frames, median(theirs),
                median(ours));
}

/// Means, since steps with other numbers of solves cost different times.
Json measure_eye(const fs::path& file, int frames) {
  const Scene scene = read_scene(file);
  Model model = load_model(scene, [](const fs::path& path) { return io::read_mesh(path).mesh; });
  Simulation corotational(model, scene.settings, 1);
  for (Material& material : model.materials) material.model = MaterialModel::stable_neo_hookean;
  const auto tets = static_cast<double>(model.bodies.tets().size());
  Simulation neo_hookean(std::move(model), scene.settings, 1);
  double ours = 0.0;
  double theirs = 0.0;
  int our_solves = 0;
  int their_solves = 0;
  for (int f = 0; f < frames; ++f) {
    theirs += milliseconds([&] { corotational.step(); }) / frames;
    ours += milliseconds([&] { neo_hookean.step(); }) / frames;
    their_solves += corotational.metrics().solves;
    our_solves += neo_hookean.metrics().solves;
  }
  Json json = result("step of the eye", tets, frames, theirs, ours);
  json["corotational_solves"] = static_cast<double>(their_solves) / frames;
  json["neo_hookean_solves"] = static_cast<double>(our_solves) / frames;
  return json;
}

}  // namespace

Part tissue_part(const SpeedEffort& effort) {
  const int frames = effort.frames_or(tissue_frames);
  Part part{"tissue",
            {{"element pass", 5.0 * cells * cells * cells, [frames] { return measure_passes(frames); }}},
            tissue_rows};
  const fs::path eye = effort.scenes / "eye.json";
  if (fs::exists(eye))
    part.cases.push_back({"step of the eye", 1e4, [=] { return measure_eye(eye, frames); }});
  return part;
}

}  // namespace palpate::bench
