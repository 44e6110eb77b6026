#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <tuple>
#include <vector>

#include <palpate/model.hpp>
#include <palpate/simulation.hpp>

#include "contact/contact_table.hpp"
#include "fem/dynamics.hpp"
#include "sim/archive.hpp"
#include "sim/edge_response.hpp"
#include "sim/grabs.hpp"
#include "sim/holds.hpp"
#include "sim/kept_contacts.hpp"
#include "sim/step_forces.hpp"

namespace palpate {

inline constexpr Seal state_seal{.kind = "PALPSTAT", .version = 16};

/// Hashes (FNV-1a, 64 bits) of the model and settings of a state: a simulation accepts only states with its
/// own fingerprint. Settings that do not affect results (structure, order, sort, cell size, threads) are left
/// out.
struct Fingerprint {
  static constexpr std::array<std::string_view, 5> names{"bodies", "materials", "motions", "loads",
                                                         "settings"};
  std::array<std::uint64_t, names.size()> hashes{};
};
/// O(points + tets).
Fingerprint fingerprint_of(const Model& model, const SimulationSettings& settings);

/// The settings that affect results, as bytes. O(1).
std::vector<std::byte> bytes_of(const SimulationSettings& settings);
/// These settings with those of bytes_of(). Throws Error on bytes of another length.
SimulationSettings with_bytes(SimulationSettings settings, std::span<const std::byte> bytes);

/// The current values of all that a ModelChange can change, except motions.
struct ChangedModel {
  Holds holds;
  std::vector<PointLoad> point_loads;
  std::vector<SurfaceLoad> surface_loads;
};

/// Everything that later steps depend on, and the results of the last one.
struct SavedState {
  Fingerprint fingerprint;
  std::vector<std::byte> settings;  ///< bytes_of() the current settings, which may have changed
  StepMetrics metrics;              ///< without times
  double last_length = 0.0;         ///< of the last substep, s
  std::int64_t slow_steps = 0;
  std::vector<Vec3> forces;
  std::vector<double> pressures;
  std::vector<HeldGrab> grabs;
  std::vector<Motion> motions;
  fem::DynamicsState dynamics;
  ContactHistory contacts;
  std::vector<KeptContact> kept_contacts;
  std::vector<EdgeEnd> edge_ends;
  DetectorMemory detector;
  std::vector<Vec3> contact_forces;
  std::vector<ActedContact> acting_contacts;
  std::vector<Vec3> tie_forces;
  bool records_reactions = false;
  std::vector<Vec3> reactions;
  std::optional<ChangedModel> changed;  ///< empty: constraints and loads are as in the model
};

/// Throws Error if an index is out of range, a number is not finite or the length of an array does not match
/// these bodies. Dynamics and Detector check their own data.
void check_saved(const SavedState& saved, const Bodies& bodies);

template <class Archive>
void serialize(Archive& archive, CuckooCounts& c) {
  archive(c.cells, c.slots, c.buckets, c.bucket_retries, c.redistributions, c.growths);
}

template <class Archive>
void serialize(Archive& archive, DetectionCounts& c) {
  archive(c.depth_fallbacks, c.cancelled_directions, c.raised_depths, c.regions_without_border,
          c.border_edges_without_crossing, c.rough_depths, c.contacts, c.edge_contacts, c.border_edges,
          c.crossings, c.candidates, c.folded_pairs, c.movers, c.approximated_primitives, c.dropped_cells,
          c.late_clusters, c.completeness, c.unseen_pairs, c.cells, c.cell_size, c.cell_doublings,
          c.cuckoo_points, c.cuckoo_edges);
  bool sorts = c.sort.has_value();
  archive(sorts);
  if (!sorts) return c.sort.reset();
  Sort sort = c.sort.value_or(Sort::radix);
  archive.choice(sort, sort_names.size());
  c.sort = sort;
}

template <class Archive>
void serialize(Archive& archive, StepMetrics& m) {
  archive(m.step, m.time, m.detection, m.solves, m.detections, m.substeps, m.speculative_contacts,
          m.stopped_passes, m.passes, m.pairs_that_could_pass, m.thinnest, m.looks_ahead, m.solver_iterations,
          m.solver_converged, m.order, m.kinetic_energy, m.elastic_energy, m.largest_speed, m.fastest_body,
          m.deepest);
}

template <class Archive>
void serialize(Archive& archive, HeldGrab& held) {
  archive(held.grab.point, held.grab.target, held.grab.stiffness, held.force);
}

template <class Archive>
void serialize(Archive& archive, Keyframe& key) {
  archive(key.time, key.translate, key.quaternion);
}

template <class Archive>
void serialize(Archive& archive, Motion& motion) {
  archive(motion.center, motion.keyframes);
  archive.choice(motion.interpolation, interpolation_names.size());
}

template <class Archive>
void serialize(Archive& archive, fem::SymmetricMatrix3& m) {
  archive(m.xx, m.yy, m.zz, m.xy, m.xz, m.yz);
}

template <class Archive>
void serialize(Archive& archive, fem::DynamicsState& s) {
  archive(s.positions, s.velocities, s.velocity_changes, s.plastic_strains, s.viscous_stresses,
          s.inversion_clocks, s.jacobi_iterations, s.jacobi_iterations_of_contacts, s.error_per_bound,
          s.multigrid_reference, s.multigrid_stale_iterations, s.past_positions, s.past_velocities,
          s.past_duration, s.contact_losses, s.second_order_multigrid_reference,
          s.second_order_multigrid_stale_iterations);
}

/// Describes states of contacts column by column, like the table.
template <class Archive>
void serialize(Archive& archive, ContactHistory& c) {
  archive(c.point, c.body);
  std::apply([&](auto&... column) { archive(column...); }, c.states.columns());
}

template <class Archive>
void serialize(Archive& archive, KeptContact& c) {
  archive(c.point, c.body, c.tet, c.distances, c.foot, c.stiffness);
}

template <class Archive>
void serialize(Archive& archive, EdgeEnd& s) {
  archive(s.edge, s.body, s.end, s.points, s.coefficients, s.of_edge, s.law.slip, s.law.direction,
          s.law.depth, s.law.stiffness, s.velocity, s.chatter_damping, s.lost, s.acts);
}

template <class Archive>
void serialize(Archive& archive, ActedContact& c) {
  archive(c.points, c.coefficients, c.of_edge, c.depth, c.direction, c.force);
  archive.choice(c.status, contact_status_names.size());
  archive(c.speculative);
}

template <class Archive>
void serialize(Archive& archive, CellSizeTrial& trial) {
  archive(trial.cell_size, trial.lookups, trial.visits, trial.work);
}

template <class Archive>
void serialize(Archive& archive, DetectorMemory& m) {
  archive(m.cell_size, m.trials, m.lower, m.upper, m.detections, m.repairs, m.counts, m.tet_states,
          m.triangle_states, m.fraction, m.reference_points, m.coherence, m.skipped_grid);
}

template <class Archive>
void serialize(Archive& archive, Ramp& ramp) {
  archive(ramp.times, ramp.factors);
}

template <class Archive>
void serialize(Archive& archive, Tie& tie) {
  archive(tie.point, tie.tet, tie.stiffness);
}

template <class Archive>
void serialize(Archive& archive, PointLoad& load) {
  archive(load.points, load.force, load.ramp);
}

template <class Archive>
void serialize(Archive& archive, SurfaceLoad& load) {
  archive(load.triangles, load.pressure, load.traction, load.ramp);
}

template <class Archive>
void serialize(Archive& archive, HeldTie& held) {
  archive(held.tie, held.weights);
}

template <class Archive>
void serialize(Archive& archive, ChangedModel& m) {
  Holds& h = m.holds;
  archive(h.obstacles, h.absent, h.fixed_points, h.fixed_axes, h.motion_of_point, h.prescribed_start, h.ties);
  archive(m.point_loads, m.surface_loads);
}

template <class Archive>
void serialize(Archive& archive, SavedState& s) {
  archive(s.fingerprint.hashes, s.settings, s.metrics, s.last_length, s.slow_steps, s.forces, s.pressures,
          s.grabs, s.motions, s.dynamics, s.contacts, s.kept_contacts, s.edge_ends, s.detector,
          s.contact_forces);
  archive(s.acting_contacts, s.tie_forces, s.records_reactions, s.reactions, s.changed);
}

}  // namespace palpate
