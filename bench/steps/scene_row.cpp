#include "steps/scene_row.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "steps/clock.hpp"
#include "steps/product_clock.hpp"

namespace palpate::bench {
namespace {

struct Tally {
  std::int64_t sum = 0;
  std::int64_t most = 0;
  void add(std::int64_t value) {
    sum += value;
    most = std::max(most, value);
  }
};

/// What the steps so far took.
struct Course {
  int steps = 0;
  Tally solves;
  Tally iterations;
  Tally detections;
  Tally inverted;
  int divided = 0;
  int not_converged = 0;
  double seconds = 0.0;
  double solver_seconds = 0.0;
  double deepest = 0.0;  ///< of all steps
  double largest_ms = 0.0;

  void add(const StepMetrics& metrics, double step_seconds, double wall_seconds) {
    ++steps;
    solves.add(metrics.solves);
    iterations.add(metrics.solver_iterations);
    detections.add(metrics.detections);
    inverted.add(metrics.inverted_tets);
    if (metrics.substeps > 1) ++divided;
    if (!metrics.solver_converged) ++not_converged;
    seconds += step_seconds;
    if (wall_seconds > 0.0) solver_seconds += metrics.solver_seconds * step_seconds / wall_seconds;
    largest_ms = std::max(largest_ms, 1e3 * step_seconds);
    deepest = std::max(deepest, metrics.deepest);
  }
};

void set_solver(SolverSettings& solver, const StepEffort& effort) {
  solver.preconditioner = effort.preconditioner.value_or(solver.preconditioner);
  solver.tolerance = effort.tolerance.value_or(solver.tolerance);
}

int steps_of(const StepScene& scene, const StepEffort& effort) {
  return effort.steps.value_or(effort.quick ? scene.quick_steps : scene.steps);
}

/// Makes the steps; returns the reason if it could not continue.
std::string go(Simulation& simulation, ProductClock& product, int steps, int threads, Course& course) {
  product.run();
  try {
    for (int i = 0; i < steps; ++i) {
      const Clock clock(threads);
      simulation.step();
      course.add(simulation.metrics(), clock.seconds(), clock.wall_seconds());
      product.run();
    }
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

void add_figures(Json& row, const Course& course, const Simulation& simulation, double product_seconds,
                 double meters) {
  const double n = std::max(course.steps, 1);
  const auto tally = [n](const Tally& t) {
    return Json{{"mean", static_cast<double>(t.sum) / n}, {"most", t.most}};
  };
  const StepMetrics& end = simulation.metrics();
  row["steps"] = course.steps;
  row["solves"] = tally(course.solves);
  row["iterations"] = tally(course.iterations);
  row["detections"] = tally(course.detections);
  row["iterations_a_solve"] = static_cast<double>(course.iterations.sum) /
                              static_cast<double>(std::max<std::int64_t>(course.solves.sum, 1));
  row["work"] = course.solver_seconds / n / product_seconds;
  row["product_us"] = 1e6 * product_seconds;
  row["ms"] = 1e3 * course.seconds / n;
  row["largest_ms"] = course.largest_ms;
  row["solver_share"] = course.seconds > 0.0 ? course.solver_seconds / course.seconds : 0.0;
  row["divided"] = course.divided;
  row["not_converged"] = course.not_converged;
  row["inverted_tets"] = {{"most", course.inverted.most}, {"last", end.inverted_tets}};
  row["deepest_um"] = {{"most", 1e6 * meters * course.deepest}, {"last", 1e6 * meters * end.deepest}};
  row["fastest_body_mm_s"] = 1e3 * meters * end.fastest_body;
  row["at_rest"] = simulation.at_rest();
  row["state_hash"] = simulation.state_hash();
}

/// The last positions of a scene as it moves with a tight tolerance and as many solves and iterations as that
/// takes.
std::vector<Vec3> reference_positions(const StepScene& scene, double tolerance, int steps, int threads) {
  StepModel made = scene.make();
  made.settings.solver.tolerance = tolerance;
  made.settings.solver.max_iterations = 100000;
  made.settings.solver.max_solves = 1000;
  Simulation simulation(std::move(made.model), made.settings, threads);
  for (int i = 0; i < steps; ++i) simulation.step();
  return {simulation.positions().begin(), simulation.positions().end()};
}

Json position_error(const Simulation& simulation, std::span<const Vec3> reference) {
  const Bodies& bodies = simulation.bodies();
  std::vector<double> edges;
  for (Index b = 0; b < bodies.body_count(); ++b)
    edges.push_back(mesh_statistics(bodies, bodies.points_rest(), b).edge_length.mean);
  double largest = 0.0;
  double sum = 0.0;
  for (std::size_t p = 0; p < reference.size(); ++p) {
    const double error =
        length(simulation.positions()[p] - reference[p]) / at(edges, bodies.body_of_point()[p]);
    largest = std::max(largest, error);
    sum += error * error;
  }
  return {{"largest", largest}, {"rms", std::sqrt(sum / static_cast<double>(reference.size()))}};
}

}  // namespace

Json scene_row(const StepScene& scene, const StepEffort& effort) {
  Json row{{"name", scene.name}};
  try {
    StepModel made = scene.make();
    const std::size_t tets = made.model.bodies.tets().size();
    if (tets > effort.most_tets) return {};
    set_solver(made.settings.solver, effort);
    row["tets"] = tets;
    row["points"] = made.model.bodies.points_rest().size();
    row["bodies"] = made.model.bodies.body_count();
    row["time_step"] = made.settings.time_step;
    ProductClock product(made.model, made.settings.time_step, effort.threads);
    Simulation simulation(std::move(made.model), made.settings, effort.threads);
    Course course;
    const std::string failure = go(simulation, product, steps_of(scene, effort), effort.threads, course);
    add_figures(row, course, simulation, product.seconds(), made.meters);
    row["error"] = failure.empty() ? Json() : Json(failure);
    if (effort.reference && failure.empty()) {
      row["position_error"] = position_error(
          simulation, reference_positions(scene, *effort.reference, course.steps, effort.threads));
    }
  } catch (const Error& error) {
    row["error"] = error.what();
  }
  return row;
}

}  // namespace palpate::bench
