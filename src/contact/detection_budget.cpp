#include "contact/detection_budget.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <palpate/error.hpp>

#include "contact/frame.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"

namespace palpate {
namespace {

/// Fraction of the tests that is for points in tets; the rest is for edges.
constexpr double points_fraction = 0.75;
/// Fraction of the time that is planned, since forecasts are inexact.
constexpr double planned_fraction = 0.8;
/// Fraction of the time after the grid's update that the query of points gets in any case. Otherwise a
/// forecast that is too high could leave it no time, and without contacts the forecast would never be
/// corrected.
constexpr double least_points_fraction = 0.25;
/// Fraction of the time after which depths are not refined further.
constexpr double refining_fraction = 0.9;
/// Part of that time up to which edges are searched in any case, even if depths take longer than the rest.
constexpr double least_edges_fraction = 0.5;
/// Estimated cost of contacts, relative to the measured one, in a detection that had no time to refine them.
constexpr double unrefined_factor = 1.25;
/// First estimate of the fixed cost of depths, expressed as a number of contacts.
constexpr double contacts_for_none = 256.0;
/// Cost of a contact with a cached plane, relative to one whose depth is computed; from a profile.
constexpr double spared_fraction = 0.3;

/// Fraction of the contacts that compute their depth in any case, so that the age of cached planes is
/// bounded, and new regions have some computed planes to propagate.
constexpr double least_recomputed_fraction = 1.0 / 32.0;

/// Cost of contacts; the unit is a contact whose depth is computed.
double work_of(std::size_t contacts, std::size_t spared) {
  return static_cast<double>(contacts) - (1.0 - spared_fraction) * static_cast<double>(spared);
}

}  // namespace

void DetectionBudget::check(const DetectionSettings& settings) {
  const Budget budget = settings.budget.value_or(Budget{});
  if (budget.tests.has_value() == budget.milliseconds.has_value()) {
    throw Error("detection settings", "budget",
                budget.tests ? "both tests and milliseconds" : "neither tests nor milliseconds",
                "exactly one of tests and milliseconds");
  }
  if (budget.tests && *budget.tests < 1)
    throw Error("detection settings", "budget.tests", std::to_string(*budget.tests), "at least 1");
  const double milliseconds = budget.milliseconds.value_or(1.0);
  if (!(milliseconds > 0.0) || !std::isfinite(milliseconds)) {
    throw Error("detection settings", "budget.milliseconds", number_text(milliseconds),
                "a finite number > 0");
  }
  if (budget.region && (!(budget.region->radius > 0.0) || !std::isfinite(budget.region->radius) ||
                        !is_finite(budget.region->center))) {
    throw Error("detection settings", "budget.region", "a radius of " + number_text(budget.region->radius),
                "a finite centre and a finite radius > 0");
  }
  if (!works_on_clusters(settings)) {
    throw Error("detection settings", "budget",
                settings.cells_per_primitive
                    ? "a budget with cells_per_primitive"
                    : "a budget with the structure " +
                          std::string(structure_names[static_cast<std::size_t>(settings.structure)]),
                "the structure compact without cells_per_primitive");
  }
}

DetectionBudget::DetectionBudget(const DetectionSettings& settings, std::size_t bodies, ClusterQueue& tets,
                                 ClusterQueue& triangles)
    : budget_(settings.budget.value_or(Budget{})),
      tets_(tets),
      triangles_(triangles),
      later_phases_(contacts_for_none),
      late_bodies_(bodies, 0) {}

void DetectionBudget::begin(double fraction) {
  fraction_ = fraction;
  before_ = {tets_.states(), triangles_.states()};
  allowance_.reset();
  refining_ = edges_deadline_ = {};
  edge_work_ = late_edges_ = 0;
  points_seconds_ = 0.0;
  std::ranges::fill(late_bodies_, std::uint8_t{0});
  if (budget_.tests) {
    const double tests = points_fraction * fraction * static_cast<double>(*budget_.tests);
    allowance_ = Allowance::of_tests(static_cast<std::uint64_t>(std::ceil(tests)));
  } else {
    const double no_limit = std::numeric_limits<double>::infinity();
    const double seconds = fraction * 1e-3 * budget_.milliseconds.value_or(no_limit);
    allowance_ = Allowance::of_seconds(begun_ ? planned_fraction * seconds : no_limit);
    if (begun_) {
      const double refined = refining_fraction * seconds;
      refining_ = Deadline::after_seconds(refined);
      edges_deadline_ =
          Deadline::after_seconds(std::max(refined - depths_.high(), least_edges_fraction * refined));
    }
  }
}

std::optional<WorkLimit> DetectionBudget::points_limit() {
  if (!allowance_) return std::nullopt;
  if (allowance_->timed()) {
    const double most = (1.0 - least_points_fraction) * allowance_->seconds_left(1.0);
    allowance_->keep_back(std::min(later_phases_.fixed(), most), later_phases_.each() * spared_fraction);
  }
  return WorkLimit{*allowance_, budget_.region};
}

std::optional<WorkLimit> DetectionBudget::begin_crossings() {
  if (!allowance_ || !budget_.tests) return std::nullopt;
  const double tests = (1.0 - points_fraction) * static_cast<double>(*budget_.tests);
  allowance_->grant(static_cast<std::uint64_t>(std::ceil(tests)));
  return WorkLimit{*allowance_, budget_.region};
}

void DetectionBudget::end_points(double seconds) {
  points_seconds_ = seconds;
}

void DetectionBudget::end_edges(const EdgeWork& work) {
  edge_work_ = work.all;
  late_edges_ = work.late;
  for (const auto& [a, b] : work.late_pairs) at(late_bodies_, a) = at(late_bodies_, b) = 1;
}

std::size_t DetectionBudget::recomputed_contacts_limit(std::size_t contacts) const {
  if (!allowance_ || !allowance_->timed() || !later_phases_.known()) return contacts;
  const double affordable =
      (allowance_->seconds_left(1.0) - later_phases_.of(work_of(contacts, contacts))) / later_phases_.each();
  const double least = std::ceil(least_recomputed_fraction * static_cast<double>(contacts));
  const double limit = std::max(least, affordable / (1.0 - spared_fraction));
  return limit < static_cast<double>(contacts) ? static_cast<std::size_t>(limit) : contacts;
}

void DetectionBudget::end(const DetectionTimes& times, std::size_t spared, DetectionCounts& counts) {
  depths_.add(times.depth);
  counts.late_clusters = late_edges_;
  counts.completeness = 1.0;
  std::size_t all = edge_work_;
  for (ClusterQueue* queue : {&tets_, &triangles_}) {
    all += queue->ordered().size();
    counts.late_clusters += queue->close(late_bodies_);
  }
  if (all > 0)
    counts.completeness = static_cast<double>(all - counts.late_clusters) / static_cast<double>(all);
  begun_ = true;
  const double after = times.contacts - points_seconds_ + times.border_edges + times.crossings + times.depth;
  // An interrupted detection must not seem cheap, or the next one would plan too much. A sample without
  // contacts has no information on their cost. But where clusters wait, it corrects a fixed cost that is too
  // high.
  if (counts.contacts > 0 || counts.late_clusters > late_edges_) {
    later_phases_.add(work_of(counts.contacts, spared),
                      refining_.passed() || late_edges_ > 0 ? unrefined_factor * after : after);
  }
  if (counts.completeness < 1.0) return;
  shortest_detection_.add(
      (times.grid + points_seconds_ + later_phases_.usual(work_of(counts.contacts, counts.contacts))) /
      planned_fraction);
}

void DetectionBudget::hold() {
  held_ = {fraction_, before_, {tets_.states(), triangles_.states()}, late_bodies_};
}

void DetectionBudget::swap_back() {
  fraction_ = held_.fraction;
  before_ = held_.before;
  tets_.states() = held_.now.tets;
  triangles_.states() = held_.now.triangles;
  late_bodies_ = held_.late_bodies;
}

void DetectionBudget::save(DetectorMemory& memory) const {
  memory.tet_states = before_.tets;
  memory.triangle_states = before_.triangles;
  memory.fraction = fraction_;
}

void DetectionBudget::recall(const DetectorMemory& memory) {
  std::vector<std::uint8_t>& tets = tets_.states();
  std::vector<std::uint8_t>& triangles = triangles_.states();
  if (memory.tet_states.size() != tets.size() || memory.triangle_states.size() != triangles.size() ||
      !(memory.fraction > 0.0) || !(memory.fraction <= 1.0)) {
    throw Error("detector", "memory",
                "a budget state of " + std::to_string(memory.tet_states.size()) + " clusters of tets, " +
                    std::to_string(memory.triangle_states.size()) + " of triangles, fraction " +
                    std::to_string(memory.fraction),
                std::to_string(tets.size()) + " and " + std::to_string(triangles.size()) +
                    " clusters, as in this scene, and a fraction above 0 and up to 1");
  }
  tets = memory.tet_states;
  triangles = memory.triangle_states;
}

}  // namespace palpate
