// A long run with random disturbances from a seed, to find errors that appear only after hours:
//
// palpate_long_run RESULT.json SCENE STEPS [SEED] [SECONDS]
//
// Checks in each step that nothing is NaN and that contact forces add up to zero; every 500 steps that the
// contacts equal the contacts of all pairs (the structure brute) and, through save() and restore() in a
// second simulation, that a resumed run continues with the same bits; and how much memory the process has.
// Ends after SECONDS at the latest, and says how many steps it did.
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

#include "disturbances.hpp"
#include "geometry/vector.hpp"
#include "io/atomic_file.hpp"
#include "scene_steps.hpp"

namespace {

using namespace palpate;
using Json = nlohmann::ordered_json;

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
  const std::vector<std::uint8_t> rigid = bench::rigid_bodies_of(argv[2]);
  Detector brute(simulation.bodies(), all_pairs, rigid, 1);
  bench::Disturbances disturbances(simulation, bench::motions_of(argv[2]), rigid, seed);
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
      disturbances.apply(simulation, {&second, 1});
      const bool compares = simulation.metrics().step % interval == interval - 1;
      if (compares) second.restore(simulation.save());
      simulation.step();
      check_step(simulation);
      most_contacts = std::max(most_contacts, simulation.metrics().detection.contacts);
      if (!compares) continue;
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
