#include "metrics_file.hpp"

#include <fmt/format.h>
#include <string_view>
#include <utility>

#include "numbers.hpp"

namespace palpate::app {
namespace {

std::string header(const Units& units, const OutcomeProbe& outcomes) {
  const auto in = [](const char* name, const std::string& unit) {
    return fmt::format(",{}", csv_field(fmt::format("{} [{}]", name, unit)));
  };
  std::string line = "step" + in("time", units.time);
  for (const char* phase :
       {"grid", "contacts", "border_edges", "crossings", "depth", "forces", "solver", "step"}) {
    line += fmt::format(",wall_{} [s]", phase);
  }
  line +=
      ",contacts,border_edges,crossings,edge_contacts,unseen_pairs,candidates,movers,depth_fallbacks,raised_"
      "depths,"
      "cancelled_directions,"
      "regions_without_border,border_edges_without_crossing,folded_pairs,approximated_primitives,"
      "dropped_cells,late_clusters,rough_depths,completeness,looks_ahead,sort,cuckoo_occupancy,cuckoo_"
      "retries,cuckoo_growths,detections,speculative_contacts,stopped_passes,passes,pairs_that_could_pass,"
      "solves,solver_iterations,"
      "solver_converged,substeps,order,inverted_tets";
  line += in("kinetic_energy", unit_name(units, dimension::energy)) +
          in("elastic_energy", unit_name(units, dimension::energy));
  line += in("largest_speed", unit_name(units, dimension::speed)) +
          in("fastest_body", unit_name(units, dimension::speed)) + in("deepest", units.length) +
          in("thinnest", units.length) + in("normal_force", unit_name(units, dimension::force)) +
          in("largest_contact_force", unit_name(units, dimension::force));
  for (std::size_t i = 0; i < outcomes.infos().size(); ++i) {
    const OutcomeInfo& info = outcomes.infos()[i];
    line += in(info.name.c_str(), outcomes.unit(i));
    for (const char* axis : {"_x", "_y", "_z"})
      if (info.has_vector) line += in((info.name + axis).c_str(), outcomes.unit(i));
  }
  return line + "\n";
}

}  // namespace

MetricsFile::MetricsFile(std::filesystem::path path, const Units& units, const OutcomeProbe& outcomes)
    : file_(std::move(path), header(units, outcomes)) {}
MetricsFile::MetricsFile(std::filesystem::path path, std::uint64_t bytes) : file_(std::move(path), bytes) {}

void MetricsFile::add(const StepMetrics& m, const ForcesOfStep& forces,
                      std::span<const OutcomeValue> outcomes, double step_seconds) {
  std::string line = fmt::format("{},{}", m.step, exact_text(m.time));
  const DetectionTimes& t = m.detection_seconds;
  for (const double seconds : {t.grid, t.contacts, t.border_edges, t.crossings, t.depth, m.forces_seconds,
                               m.solver_seconds, step_seconds}) {
    line += fmt::format(",{:.3e}", seconds);
  }
  const DetectionCounts& c = m.detection;
  const std::string_view sort = c.sort ? sort_names[static_cast<std::size_t>(*c.sort)] : "none";
  for (const std::size_t count :
       {c.contacts, c.border_edges, c.crossings, c.edge_contacts, c.unseen_pairs, c.candidates, c.movers,
        c.depth_fallbacks, c.raised_depths, c.cancelled_directions, c.regions_without_border,
        c.border_edges_without_crossing, c.folded_pairs, c.approximated_primitives, c.dropped_cells}) {
    line += fmt::format(",{}", count);
  }
  line +=
      fmt::format(",{},{},{:.4f},{}", c.late_clusters, c.rough_depths, c.completeness, m.looks_ahead ? 1 : 0);
  const CuckooCounts points = c.cuckoo_points.value_or(CuckooCounts{});
  const CuckooCounts edges = c.cuckoo_edges.value_or(CuckooCounts{});
  line += fmt::format(",{},{:.4f},{},{},{},{},{},{},{},{},{},{},{},{},{}", sort, points.occupancy(),
                      points.retries() + edges.retries(), points.growths + edges.growths, m.detections,
                      m.speculative_contacts, m.stopped_passes, m.passes, m.pairs_that_could_pass, m.solves,
                      m.solver_iterations, m.solver_converged ? 1 : 0, m.substeps, m.order, m.inverted_tets);
  for (const double value : {m.kinetic_energy, m.elastic_energy, m.largest_speed, m.fastest_body, m.deepest,
                             m.thinnest, forces.normal, forces.largest}) {
    line.append(1, ',').append(exact_text(value));
  }
  for (const OutcomeValue& outcome : outcomes) {
    line.append(1, ',').append(exact_text(outcome.value));
    if (!outcome.vector) continue;
    for (const double part : {outcome.vector->x, outcome.vector->y, outcome.vector->z})
      line.append(1, ',').append(exact_text(part));
  }
  line += '\n';
  file_.add(line);
}

}  // namespace palpate::app
