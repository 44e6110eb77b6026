#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>
#include <palpate/relax.hpp>

#include "contact/detector_steps.hpp"
#include "fem/dynamics.hpp"
#include "fem/lumping.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"
#include "sim/holds.hpp"
#include "sim/model_check.hpp"
#include "sim/prescribed_motions.hpp"
#include "sim/response.hpp"

namespace palpate {
namespace {

/// Time step of the relaxation, relative to that of the scene. It is long, so that inertia has little effect
/// on the result, but short enough for the solver to find rigid motions, which only inertia resists.
constexpr double time_steps = 10.0;
/// Solves need not be accurate, because the next step continues from the result.
constexpr double solver_tolerance = 1e-4;
constexpr int solver_iterations = 1000;
/// If more than this fraction of the depth is left after a step, the contact stiffness is doubled.
constexpr double stalled = 0.9;
/// Bounds of the contact stiffness, relative to that of the scene.
constexpr double most_factor = 1024.0;
constexpr double least_factor = 1.0 / 1024.0;
/// Every tet keeps at least this fraction of its initial volume.
constexpr double least_volume = 0.1;
/// How often a step that leaves a tet less volume is halved at most.
constexpr int most_halvings = 8;
/// The depth of an edge contact is ignored if its stiffness is below this fraction of the full contact
/// stiffness.
constexpr double least_part = 0.1;

double least_mean_edge(const Bodies& bodies) {
  double least = std::numeric_limits<double>::infinity();
  for (Index b = 0; b < bodies.body_count(); ++b) {
    least = std::min(least, mesh_statistics(bodies, bodies.points_rest(), b).edge_length.mean);
  }
  return least;
}

/// Detection settings for relaxation, which must be exact.
DetectionSettings exact(DetectionSettings settings) {
  settings.cells_per_primitive.reset();
  settings.budget.reset();
  return settings;
}

ResponseSettings without_friction(ResponseSettings settings) {
  settings.friction = 0.0;
  settings.damping = 0.0;
  return settings;
}

double largest_distance(std::span<const Vec3> a, std::span<const Vec3> b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, squared_length(a[i] - b[i]));
  return std::sqrt(largest);
}

/// The materials without plasticity and viscosity.
std::vector<Material> elastic(std::vector<Material> materials) {
  for (Material& material : materials) {
    material.plastic_yield.reset();
    material.viscosity = {};
  }
  return materials;
}

/// The bodies during relaxation.
class Relaxation {
 public:
  Relaxation(const Model& model, const SimulationSettings& settings, int threads)
      : bodies_(model.bodies),
        threads_(threads),
        time_step_(time_steps * settings.time_step),
        materials_(elastic(model.materials), model.material_of_tet, model.fibre_of_tet),
        dynamics_(bodies_, materials_, constrained_points(holds_of(model), bodies_), rigid_bodies(model),
                  threads_),
        detector_(bodies_, without_absent(exact(settings.detection), model.absent), rigid_bodies(model),
                  threads),
        contact_materials_(fem::mean_materials(bodies_, materials_)),
        response_(bodies_, contact_materials_, rigid_bodies(model), without_friction(settings.response),
                  dynamics_.point_masses(), dynamics_.free_points()),
        prescribed_(model.motions, model.motion_of_point, bodies_.points_rest()),
        still_(bodies_.points_rest().size()),
        start_(prescribed_.start_positions(threads_, bodies_.points_rest())) {
    response_.use_edges(DetectorSteps::surfaces(detector_));
    dynamics_.set_fixed_axes(bodies_, materials_, axes_or_none(model));
    dynamics_.set_positions(start_);
    find_contacts();
  }

  [[nodiscard]] const Contacts& contacts() const { return detector_.contacts(); }
  /// The largest depth of contacts and of acting edges, of pairs of which at least one body can move.
  [[nodiscard]] double deepest() const {
    double deepest = 0.0;
    const auto moves = [&](Index point) { return at(dynamics_.free_points(), point) != 0; };
    for (std::size_t c = 0; c < contacts().size(); ++c) {
      const Tet& tet = at(bodies_.tets(), contacts().tet[c]);
      if (moves(contacts().point[c]) || std::ranges::any_of(tet, moves))
        deepest = std::max(deepest, contacts().depth[c]);
    }
    for (std::size_t c = contacts().size(); c < response_.present(); ++c) {
      const fem::ContactLaw& law = response_.laws()[c];
      const auto& points = couplings_[c].points;
      const double full = response_.stiffness(at(bodies_.body_of_point(), points.front()),
                                              at(bodies_.body_of_point(), points.back()));
      if (law.stiffness > least_part * full && std::ranges::any_of(points, moves))
        deepest = std::max(deepest, law.depth);
    }
    return deepest;
  }
  /// Largest displacement of a point, m.
  [[nodiscard]] double largest_move() const { return largest_distance(dynamics_.positions(), start_); }
  /// The rest positions that belong to the current positions; those of prescribed points do not change.
  [[nodiscard]] std::vector<Vec3> points_rest() const {
    std::vector<Vec3> points(dynamics_.positions().begin(), dynamics_.positions().end());
    for (const Index p : prescribed_.points()) at(points, p) = at(bodies_.points_rest(), p);
    return points;
  }

  /// Relaxes the bodies. Returns false if they cannot separate without crushing tissue.
  bool step() {
    const double before = deepest();
    for (std::size_t c = 0; c < couplings_.size(); ++c) {
      fem::ContactLaw law = response_.laws()[c];
      law.stiffness *= factor_;
      fem::linearise(law, {.coefficient = 0.0, .time_step = time_step_}, {}, couplings_[c]);
    }
    dynamics_.holds().append(time_step_, couplings_);
    last_.assign(dynamics_.positions().begin(), dynamics_.positions().end());
    dynamics_.step(time_step_, {}, {}, couplings_, solver_tolerance, solver_iterations);
    const bool moved = shorten_step(before);
    dynamics_.set_velocities(still_);
    dynamics_.set_velocity_changes(still_);
    find_contacts();
    // If the step would crush tissue, elastic forces need more steps; if there is no progress, the contact
    // needs a higher stiffness.
    if (!moved) {
      factor_ *= 0.5;
    } else if (deepest() > stalled * before) {
      factor_ = std::min(2.0 * factor_, most_factor);
    }
    return factor_ >= least_factor;
  }

 private:
  /// Detects contacts at the current positions, and computes their forces.
  void find_contacts() {
    detector_.detect(dynamics_.positions());
    couplings_.clear();
    response_.compute(threads_, bodies_, DetectorSteps::table(detector_), dynamics_.positions(), still_,
                      {.since = time_step_, .ahead = time_step_}, 0.0, couplings_);
  }
  /// Shortens the step so that no point moves further than the largest depth (a free body could rotate too
  /// far for the linear model), and so that no tet becomes too flat.
  bool shorten_step(double most) {
    const double move = largest_distance(dynamics_.positions(), last_);
    if (move > most) shorten_step_to(most / move);
    for (int halvings = 0; !tets_keep_volume(); ++halvings) {
      shorten_step_to(halvings < most_halvings ? 0.5 : 0.0);
      if (halvings == most_halvings) return false;
    }
    return true;
  }
  void shorten_step_to(double fraction) {
    shortened_.assign(last_.begin(), last_.end());
    for (std::size_t p = 0; p < last_.size(); ++p) {
      shortened_[p] += fraction * (dynamics_.positions()[p] - last_[p]);
    }
    dynamics_.set_positions(shortened_);
  }
  [[nodiscard]] bool tets_keep_volume() const {
    const auto six_volumes = [](std::span<const Vec3> points, const Tet& tet) {
      const Vec3& corner = at(points, tet[0]);
      return dot(cross(at(points, tet[1]) - corner, at(points, tet[2]) - corner),
                 at(points, tet[3]) - corner);
    };
    return std::ranges::all_of(bodies_.tets(), [&](const Tet& tet) {
      return six_volumes(dynamics_.positions(), tet) >= least_volume * six_volumes(start_, tet);
    });
  }

  const Bodies& bodies_;
  parallel::Threads threads_;
  double time_step_;
  Materials materials_;
  fem::Dynamics dynamics_;
  Detector detector_;
  std::vector<Material> contact_materials_;
  ContactResponse response_;
  PrescribedMotions prescribed_;
  std::vector<Vec3> still_;
  std::vector<Vec3> start_;
  std::vector<Vec3> last_;       ///< positions before the current step
  std::vector<Vec3> shortened_;  ///< scratch
  std::vector<fem::Coupling> couplings_;
  double factor_ = 1.0;  ///< factor of the contact stiffness
};

void check(const RelaxSettings& settings) {
  if (!(settings.depth > 0.0) || !std::isfinite(settings.depth))
    throw Error("relax settings", "depth", number_text(settings.depth), "a finite number > 0");
  if (settings.max_steps < 1)
    throw Error("relax settings", "max_steps", std::to_string(settings.max_steps), "at least 1");
}

}  // namespace

RelaxReport relax(Model& model, const SimulationSettings& settings, const RelaxSettings& relaxation,
                  int threads, const std::function<void(int, double)>& progress) {
  check(relaxation);
  Relaxation bodies(model, settings, threads);
  RelaxReport report;
  report.allowed_depth = relaxation.depth * least_mean_edge(model.bodies);
  report.contacts_before = bodies.contacts().size();
  report.deepest_before = bodies.deepest();
  while (bodies.deepest() > report.allowed_depth && report.steps < relaxation.max_steps) {
    const bool moves_on = bodies.step();
    ++report.steps;
    if (progress) progress(report.steps, bodies.deepest());
    if (!moves_on) break;
  }
  report.contacts_after = bodies.contacts().size();
  report.deepest_after = bodies.deepest();
  report.relaxed = report.deepest_after <= report.allowed_depth;
  report.largest_move = bodies.largest_move();
  if (report.steps > 0) model.bodies.set_points_rest(bodies.points_rest());
  return report;
}

}  // namespace palpate
