#include "forces_file.hpp"

#include <fmt/format.h>
#include <string>
#include <utility>

#include "numbers.hpp"

namespace palpate::app {
namespace {

void add_wrench_columns(std::string& line, const std::string& what, const Units& units) {
  for (const auto& [name, unit] :
       {std::pair("force", dimension::force), std::pair("torque", dimension::torque)}) {
    for (const char axis : {'x', 'y', 'z'}) {
      line.append(1, ',').append(
          csv_field(fmt::format("{} {}_{} [{}]", what, name, axis, unit_name(units, unit))));
    }
  }
}

std::string header(const ForceProbe& probe, const Units& units) {
  std::string line = "step,";
  line += csv_field(fmt::format("time [{}]", units.time));
  for (std::size_t b = 0; b < probe.names().size(); ++b) {
    add_wrench_columns(line, probe.names()[b] + " contact", units);
    if (probe.is_held(b)) add_wrench_columns(line, probe.names()[b] + " held", units);
    if (probe.is_tied(b)) add_wrench_columns(line, probe.names()[b] + " tied", units);
    if (probe.is_grabbed(b)) add_wrench_columns(line, probe.names()[b] + " grabbed", units);
  }
  for (const ForceProbe::Pair& pair : probe.pairs()) {
    const std::string what = fmt::format("{} on {}", probe.names()[static_cast<std::size_t>(pair.first)],
                                         probe.names()[static_cast<std::size_t>(pair.second)]);
    add_wrench_columns(line, what, units);
    line.append(1, ',').append(
        csv_field(fmt::format("{} normal [{}]", what, unit_name(units, dimension::force))));
  }
  return line + "\n";
}

void add_wrench(std::string& line, const Wrench& wrench) {
  for (const Vec3& v : {wrench.force, wrench.torque}) {
    for (const double value : {v.x, v.y, v.z}) line.append(1, ',').append(exact_text(value));
  }
}

}  // namespace

ForcesFile::ForcesFile(std::filesystem::path path, const ForceProbe& probe, const Units& units)
    : file_(std::move(path), header(probe, units)) {}
ForcesFile::ForcesFile(std::filesystem::path path, std::uint64_t bytes) : file_(std::move(path), bytes) {}

void ForcesFile::add(const Simulation& simulation, const ForcesOfStep& forces) {
  std::string line = fmt::format("{},{}", simulation.metrics().step, exact_text(simulation.metrics().time));
  for (const BodyForces& body : forces.bodies) {
    add_wrench(line, body.contact);
    for (const auto& wrench : {body.held, body.tied, body.grabbed}) {
      if (wrench) add_wrench(line, *wrench);
    }
  }
  for (const PairWrench& pair : forces.pairs) {
    add_wrench(line, pair.on_b);
    line.append(1, ',').append(exact_text(pair.normal));
  }
  file_.add(line + "\n");
}

}  // namespace palpate::app
