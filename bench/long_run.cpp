// A long run with disturbances drawn from a seed, that looks for what only shows after hours:
//
//   palpate_long_run RESULT.json SCENE STEPS [SEED] [SECONDS]
//
// Every few steps a point is pushed, or grabbed, drawn about and let go; the scene's own motions run once.
// Checks in each step that nothing is NaN and that contact forces add up to zero; every 500 steps that the
// contacts are those of all pairs (the structure brute) and, through save() and restore() in a second
// simulation, that a resumed run goes on with the same bits; and how much memory the process has. Ends after
// SECONDS at the latest, and says how many steps it did.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "io/atomic_file.hpp"
#include "scene_steps.hpp"

namespace {

using namespace palpate;
using Json = nlohmann::ordered_json;

/// splitmix64: the same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high) {
    state_ += 0x9e3779b97f4a7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return low + (high - low) * static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
  }
  Vec3 in_ball(double radius) {
    const auto side = [&] { return uniform(-radius, radius); };
    return {side(), side(), side()};
  }

 private:
  std::uint64_t state_;
};

/// Memory of the process that is in use, MiB.
double resident_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024.0;
  }
  return 0.0;
}

void require(bool holds, const std::string& what, std::int64_t step) {
  if (!holds) throw std::runtime_error("step " + std::to_string(step) + ": " + what);
}

/// Pushes and grabs, by the sizes of the scene.
class Disturbances {
 public:
  Disturbances(const Simulation& simulation, std::uint64_t seed) : random_(seed) {
    const MeshStatistics all = mesh_statistics(simulation.bodies(), simulation.bodies().points_rest());
    reach_ = 2.0 * all.edge_length.mean;
    double mass = 0.0;
    for (Index b = 0; b < simulation.bodies().body_count(); ++b) mass += at(simulation.masses(), b);
    const double points = static_cast<double>(simulation.positions().size());
    const double h = simulation.settings().time_step;
    // A push moves a free point by a tenth of an edge in a step; a grab is as stiff as inertia.
    force_ = 0.1 * all.edge_length.mean * mass / points / (h * h);
    stiffness_ = mass / points / (h * h);
  }

  void apply(Simulation& simulation, std::int64_t step) {
    if (step % 5 == 0) {
      if (pushed_ >= 0) simulation.set_force(pushed_, {});
      pushed_ = point(simulation);
      simulation.set_force(pushed_, random_.in_ball(force_));
    }
    if (step % 200 == 50) {
      const Index held = point(simulation);
      home_ = at(simulation.positions(), held);
      grab_ = simulation.grab({.point = held, .target = home_, .stiffness = stiffness_});
    }
    if (grab_ >= 0 && step % 10 == 0) simulation.move_grab(grab_, home_ + random_.in_ball(reach_));
    if (grab_ >= 0 && step % 200 == 150) {
      simulation.release(grab_);
      grab_ = -1;
    }
  }

 private:
  Index point(const Simulation& simulation) {
    const auto points = static_cast<double>(simulation.positions().size());
    return static_cast<Index>(random_.uniform(0.0, points - 0.5));
  }

  Random random_;
  double reach_ = 0.0;
  double force_ = 0.0;
  double stiffness_ = 0.0;
  Index pushed_ = -1;
  Index grab_ = -1;  ///< its number; -1: none
  Vec3 home_{};
};

void check_step(const Simulation& simulation) {
  const std::int64_t step = simulation.metrics().step;
  for (const auto& values : {simulation.positions(), simulation.velocities()})
    require(std::ranges::all_of(values, is_finite), "a value that is not finite", step);
  Vec3 sum;
  double size = 0.0;
  for (const Vec3& force : simulation.contact_forces()) {
    sum += force;
    size += length(force);
  }
  require(length(sum) <= 1e-9 * size, "contact forces do not add up to zero", step);
}

/// Contacts against those of all pairs.
void check_contacts(const Simulation& simulation, Detector& brute) {
  brute.detect(simulation.positions());
  const Contacts& found = simulation.detector().contacts();
  const Contacts& all = brute.contacts();
  require(
      found.point == all.point && found.body == all.body && found.tet == all.tet && found.depth == all.depth,
      "contacts are not those of all pairs", simulation.metrics().step);
}

std::int64_t integer(const char* text) {
  std::int64_t value = 0;
  std::from_chars(text, text + std::string(text).size(), value);
  return value;
}

int work(int argc, char** argv) {
  const std::int64_t steps = integer(argv[3]);
  const auto seed = static_cast<std::uint64_t>(argc > 4 ? integer(argv[4]) : 1);
  const double most_seconds = argc > 5 ? static_cast<double>(integer(argv[5])) : 1e9;
  constexpr std::int64_t interval = 500;
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  Simulation simulation = bench::simulation_of(argv[2], std::nullopt, 1);
  Simulation second = bench::simulation_of(argv[2], std::nullopt, 1);
  DetectionSettings all_pairs = simulation.settings().detection;
  all_pairs.structure = Structure::brute;
  Detector brute(simulation.bodies(), all_pairs, bench::rigid_bodies_of(argv[2]), 1);
  Disturbances disturbances(simulation, seed);
  Json json{{"scene", argv[2]}, {"seed", seed}, {"memory_mib", Json::array()}};
  std::size_t most_contacts = 0;
  std::int64_t resumed = 0;
  const auto write = [&](const std::string& fault) {
    const StepMetrics& m = simulation.metrics();
    json["steps"] = m.step;
    json["seconds"] = seconds();
    json["most_contacts"] = most_contacts;
    json["compared_with_all_pairs"] = m.step / interval;
    json["resumed_with_the_same_bits"] = resumed;
    json["state_hash"] = simulation.state_hash();
    json["fault"] = fault.empty() ? Json() : Json(fault);
    io::write_atomically(argv[1], json.dump(1) + "\n");
  };
  try {
    while (simulation.metrics().step < steps && seconds() < most_seconds) {
      disturbances.apply(simulation, simulation.metrics().step);
      const bool look = simulation.metrics().step % interval == interval - 1;
      if (look) second.restore(simulation.save());
      simulation.step();
      check_step(simulation);
      most_contacts = std::max(most_contacts, simulation.metrics().detection.contacts);
      if (!look) continue;
      check_contacts(simulation, brute);
      second.step();
      require(second.save() == simulation.save(), "a resumed run has other bits", simulation.metrics().step);
      ++resumed;
      json["memory_mib"].push_back(resident_memory());
      write("");
    }
    write("");
  } catch (const std::exception& error) {
    write(error.what());
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: palpate_long_run RESULT.json SCENE STEPS [SEED] [SECONDS]\n");
    return 2;
  }
  return work(argc, argv);
}
