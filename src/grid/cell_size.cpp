#include "grid/cell_size.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <palpate/error.hpp>

#include "geometry/box.hpp"
#include "grid/compact.hpp"
#include "number_text.hpp"

namespace palpate {
namespace {

/// Work of looking up a row of cells, in units of the work of testing one point. About the ratio of their
/// times in the query, where clusters test many points at once.
constexpr double work_of_lookup = 3.0;
constexpr double work_of_cluster_lookup = 10.0;
/// Work of a point in the update of the grid, in the same units.
constexpr double work_of_point = 4.0;

Spread edge_lengths(const Bodies& bodies) {
  return mesh_statistics(bodies, bodies.points_rest()).edge_length;
}

/// Counts the work of one query with cells of a given size.
class Trial {
 public:
  Trial(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
        std::span<const std::uint8_t> included, const Clusters* clusters)
      : threads_(threads),
        bodies_(bodies),
        clusters_(clusters),
        positions_(positions),
        included_(included),
        bounds_(bounds_of(threads, positions, included, scratch_)) {}

  CellSizeTrial run(double cell_size) {
    const Lattice lattice(bounds_, cell_size);
    grid_.build_points(threads_, lattice, positions_.size(), [&](Index p) {
      return at(included_, p) == 0 ? std::nullopt : std::optional(lattice.cell_of(at(positions_, p)));
    });
    constexpr std::size_t most = 20000;
    const std::size_t all = clusters_ != nullptr ? clusters_->clusters.size() : bodies_.tets().size();
    const std::size_t stride = std::max<std::size_t>(1, all / most);
    const std::size_t sampled = (all + stride - 1) / stride;
    CellSizeTrial trial{lattice.cell_size(), 0.0, 0.0, 0.0};
    trial.lookups = parallel::sum(threads_, sampled, sums_, [&](std::size_t n) {
      const CellRange range = range_of(lattice, n * stride);
      return static_cast<double>(range.along(1)) * static_cast<double>(range.along(2));
    });
    trial.visits = parallel::sum(threads_, sampled, sums_, [&](std::size_t n) {
      double visits = 0.0;
      grid_.for_each(range_of(lattice, n * stride), [&](Index) { visits += 1.0; });
      return visits;
    });
    const double scale = static_cast<double>(all) / static_cast<double>(sampled);
    trial.lookups *= scale;
    trial.visits *= scale;
    trial.work = (clusters_ != nullptr ? work_of_cluster_lookup : work_of_lookup) * trial.lookups +
                 trial.visits + work_of_point * static_cast<double>(positions_.size());
    return trial;
  }

 private:
  /// The cells that the box of a tet or cluster covers.
  [[nodiscard]] CellRange range_of(const Lattice& lattice, std::size_t n) const {
    if (clusters_ == nullptr) return lattice.cells_of(box_of(positions_, bodies_.tets()[n]));
    Box box;
    for (const Index point : clusters_->points_of(clusters_->clusters[n])) box.extend(at(positions_, point));
    return lattice.cells_of(box);
  }

  const parallel::Threads& threads_;
  const Bodies& bodies_;
  const Clusters* clusters_;  ///< of the query; null where it works on single tets
  std::span<const Vec3> positions_;
  std::span<const std::uint8_t> included_;
  std::vector<Box> scratch_;
  Box bounds_;
  CompactGrid grid_{Order::linear, Sort::counting};
  std::vector<double> sums_;
};

CellSizeChoice choose_automatically(const parallel::Threads& threads, const Bodies& bodies,
                                    std::span<const Vec3> positions, std::span<const std::uint8_t> included,
                                    const Clusters* clusters) {
  double smallest = edge_lengths(bodies).mean;
  double largest = smallest;
  for (Index b = 0; b < bodies.body_count(); ++b) {
    const double mean = mesh_statistics(bodies, bodies.points_rest(), b).edge_length.mean;
    smallest = std::min(smallest, mean);
    largest = std::max(largest, mean);
  }
  Trial trial(threads, bodies, positions, included, clusters);
  CellSizeChoice choice{CellSizeRule::automatic, 0.0, {}};
  for (double size = 0.5 * smallest; size <= 2.0 * largest * (1.0 + 1e-9); size *= 2.0) {
    choice.trials.push_back(trial.run(size));
  }
  const auto less_work = [](const CellSizeTrial& a, const CellSizeTrial& b) { return a.work < b.work; };
  const double best = std::min_element(choice.trials.begin(), choice.trials.end(), less_work)->cell_size;
  choice.trials.push_back(trial.run(best / std::sqrt(2.0)));
  choice.trials.push_back(trial.run(best * std::sqrt(2.0)));
  choice.cell_size = std::min_element(choice.trials.begin(), choice.trials.end(), less_work)->cell_size;
  return choice;
}

}  // namespace

void check_cell_size(const CellSize& wanted) {
  // Keeps all values computed from it finite.
  constexpr double most = 1e150;
  const double* length = std::get_if<double>(&wanted);
  if (length == nullptr || (*length > 0.0 && *length <= most)) return;
  throw Error("detection settings", "cell_size", number_text(*length), "a number > 0, 1e150 at most");
}

CellSizeChoice choose_cell_size(const parallel::Threads& threads, const Bodies& bodies,
                                std::span<const Vec3> positions, std::span<const std::uint8_t> included,
                                const CellSize& wanted, const Clusters* clusters) {
  if (const double* length = std::get_if<double>(&wanted)) {
    return {wanted, *length, {}};
  }
  switch (std::get<CellSizeRule>(wanted)) {
    case CellSizeRule::mean_edge:
      return {wanted, edge_lengths(bodies).mean, {}};
    case CellSizeRule::max_edge:
      return {wanted, edge_lengths(bodies).max, {}};
    case CellSizeRule::automatic:
      break;
  }
  return choose_automatically(threads, bodies, positions, included, clusters);
}

}  // namespace palpate
