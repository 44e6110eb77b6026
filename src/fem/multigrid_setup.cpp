// Makes the hierarchy from the bodies at rest or at the reference positions.
#include <algorithm>
#include <cmath>

#include "fem/grains.hpp"
#include "fem/matrix.hpp"
#include "fem/multigrid.hpp"
#include "fem/rotation.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t few_nodes = 40;  // a level with fewer nodes is factored
constexpr double least_reduction =
    0.8;                         // no further level if it would have more than this fraction of the nodes
constexpr double strong = 0.05;  // a connection is strong if it is above this fraction of the diagonal blocks
constexpr std::size_t matrix_grain = 256;

Matrix3 minus(const Matrix3& a) {
  return Matrix3{} - a;
}

double squared_norm(const Dense<6, 6>& block) {
  double sum = 0.0;
  for (const double value : block) sum += value * value;
  return sum;
}

/// Aggregates by strong connections only: smoothed transfers also connect distant nodes weakly, which would
/// make aggregates too large for the smoother.
std::vector<Index> aggregate_strong(const BlockRows<6, 6>& a) {
  std::vector<double> diagonal(a.size(), 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t k = a.begin[i]; k < a.begin[i + 1]; ++k) {
      if (a.columns[k] == i) diagonal[i] = std::sqrt(squared_norm(a.blocks[k]));
    }
  }
  std::vector<std::uint32_t> begin{0};
  std::vector<std::uint32_t> columns;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t k = a.begin[i]; k < a.begin[i + 1]; ++k) {
      const std::uint32_t j = a.columns[k];
      if (squared_norm(a.blocks[k]) >= strong * strong * diagonal[i] * diagonal[j]) columns.push_back(j);
    }
    begin.push_back(static_cast<std::uint32_t>(columns.size()));
  }
  return aggregate({begin, columns});
}

}  // namespace

std::span<const Vec3> Multigrid::reference_positions() const {
  return reference_.empty() ? matrix_->elements().points_rest() : std::span<const Vec3>(reference_);
}

/// Rotation of each element from rest to the reference.
std::vector<Matrix3> Multigrid::element_rotations() const {
  const auto corners = matrix_->elements().corners();
  const auto edges = [](std::span<const Vec3> points, const Tet& tet) {
    const Vec3& first = at(points, tet[0]);
    return from_rows(at(points, tet[1]) - first, at(points, tet[2]) - first, at(points, tet[3]) - first);
  };
  std::vector<Matrix3> rotations(corners.size(), identity());
  if (reference_.empty()) return rotations;
  for (std::size_t e = 0; e < corners.size(); ++e) {
    const Matrix3 to_rest = inverse(edges(matrix_->elements().points_rest(), corners[e]));
    const Matrix3 now = edges(reference_, corners[e]);
    Matrix3 f;
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) f(j, i) += to_rest(i, k) * now(k, j);
      }
    }
    rotations[e] = nearest_rotation(f);
  }
  return rotations;
}

/// Rotation of each smoothing domain.
std::vector<Matrix3> Multigrid::domain_rotations() const {
  const Elements& elements = matrix_->elements();
  std::vector<Matrix3> rotations(elements.smoothing().size(), identity());
  if (reference_.empty()) return rotations;
  for (std::size_t d = 0; d < rotations.size(); ++d)
    rotations[d] = elements.smoothing().rotation(d, elements.points_rest(), reference_);
  return rotations;
}

/// The matrix at the reference positions. Its nodes are the points with a row, in the order of rows.
BlockRows<3, 3> Multigrid::matrix_at_reference(const parallel::Threads& threads) const {
  const auto row_of = matrix_->row_of_point();
  BlockRows<3, 3> result;
  for (const std::uint32_t row : rows_) {
    const std::size_t first = result.columns.size();
    for (const std::uint32_t other : matrix_->columns(matrix_->point_of_row()[row])) {
      if (row_of[other] >= 0) result.columns.push_back(at(node_of_row_, row_of[other]));
    }
    std::sort(result.columns.begin() + static_cast<std::ptrdiff_t>(first), result.columns.end());
    result.begin.push_back(static_cast<std::uint32_t>(result.columns.size()));
  }
  result.blocks.resize(result.columns.size());
  const Rotations rotations{element_rotations(), domain_rotations()};
  parallel::for_each(threads, rows_.size(), matrix_grain,
                     [&](std::size_t node) { add_stiffness(node, rotations, result); });
  return result;
}

/// Adds mass and stiffness to the blocks of a node's row.
void Multigrid::add_stiffness(std::size_t node, const Rotations& rotations, BlockRows<3, 3>& a) const {
  const Elements& elements = matrix_->elements();
  const auto row_of = matrix_->row_of_point();
  const Index point = matrix_->point_of_row()[rows_[node]];
  const auto columns = std::span(a.columns).subspan(a.begin[node], a.begin[node + 1] - a.begin[node]);
  const auto block = [&](Index other) -> Dense<3, 3>& {
    const auto place = std::ranges::lower_bound(columns, at(node_of_row_, at(row_of, other)));
    return a.blocks[a.begin[node] + static_cast<std::size_t>(place - columns.begin())];
  };
  const double m = at(matrix_->diagonal(), point);
  for (std::size_t k = 0; k < 3; ++k) block(point)[4 * k] = m;
  for (const Index e : matrix_->elements_of_point()[point]) {
    if (elements.is_smoothed(e)) continue;
    const Tet& corners = at(elements.corners(), e);
    const auto own = static_cast<int>(std::ranges::find(corners, point) - corners.begin());
    for (int j = 0; j < 4; ++j) {
      const Index other = at(corners, j);
      if (at(row_of, other) < 0) continue;
      Dense<3, 3>& sum = block(other);
      const Matrix3 stiffness = elements.stiffness_rest(e, own, j);
      if (reference_.empty()) {
        for (std::size_t k = 0; k < 9; ++k) sum[k] += stiffness.values[k];
        continue;
      }
      const Matrix3& rotation = at(rotations.elements, e);
      Dense<3, 3> turned{};
      add_product<3, 3, 3>(turned, rotation.values, stiffness.values);
      subtract_product_transposed<3, 3, 3>(sum, turned, minus(rotation).values);
    }
  }
  for (const SmoothingDomains::Entry& entry : elements.smoothing().entries(point)) {
    const auto points = elements.smoothing().points(entry.domain);
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (at(row_of, points[j]) < 0) continue;
      const Matrix3 b =
          elements.smoothing().block_rest(entry.domain, rotations.domains[entry.domain], entry.place, j);
      for (std::size_t k = 0; k < 9; ++k) block(points[j])[k] += b.values[k];
    }
  }
}

/// Connects the nodes of a common tet. Connections through smoothing domains would be too many for
/// aggregates; without them, the graph is the pattern of the matrix.
BlockRows<0, 0> Multigrid::element_graph(const BlockRows<3, 3>& matrix) const {
  const auto row_of = matrix_->row_of_point();
  BlockRows<0, 0> graph;
  if (matrix_->elements().smoothing().empty()) {
    graph.begin = matrix.begin;
    graph.columns = matrix.columns;
    return graph;
  }
  for (const std::uint32_t row : rows_) {
    const auto first = static_cast<std::ptrdiff_t>(graph.columns.size());
    for (const Index e : matrix_->elements_of_point()[matrix_->point_of_row()[row]]) {
      for (const Index other : at(matrix_->elements().corners(), e)) {
        if (at(row_of, other) >= 0) graph.columns.push_back(at(node_of_row_, at(row_of, other)));
      }
    }
    const auto own = graph.columns.begin() + first;
    std::sort(own, graph.columns.end());
    graph.columns.erase(std::unique(own, graph.columns.end()), graph.columns.end());
    graph.begin.push_back(static_cast<std::uint32_t>(graph.columns.size()));
  }
  return graph;
}

std::vector<Node> Multigrid::points_as_nodes() const {
  const std::vector<Index> bodies = matrix_->body_of_point();
  std::vector<Node> nodes;
  for (const std::uint32_t row : rows_) {
    const Index point = matrix_->point_of_row()[row];
    nodes.push_back({.middle = at(reference_positions(), point), .radius = 0.0, .body = at(bodies, point)});
  }
  return nodes;
}

/// Stores the transfer by rows instead of nodes.
void Multigrid::connect_rows(const BlockRows<3, 6>& transfer, std::size_t count) {
  transfer_ = padded(transfer);
  restriction_ = padded(transposed(transfer, count));
  for (std::uint32_t& node : restriction_.columns) node = rows_[node];
  transfer_.begin.assign(1, 0);
  std::size_t node = 0;
  for (std::size_t row = 0; row < matrix_->row_count(); ++row) {
    if (node < rows_.size() && rows_[node] == row) ++node;
    transfer_.begin.push_back(transfer.begin[node]);
  }
}

void Multigrid::build(const parallel::Threads& threads) {
  factors_.assign(matrix_->elements().factors().begin(), matrix_->elements().factors().end());
  diagonal_.assign(matrix_->diagonal().begin(), matrix_->diagonal().end());
  if (smoother_.empty()) {
    smoother_.emplace_back(*matrix_);
    node_of_row_.assign(matrix_->row_count(), 0);
    for (std::size_t row = 0; row < matrix_->point_of_row().size(); ++row) {
      if (matrix_->point_of_row()[row] < 0) continue;
      node_of_row_[row] = static_cast<std::uint32_t>(rows_.size());
      rows_.push_back(static_cast<std::uint32_t>(row));
    }
  }
  place_edges();
  levels_.clear();
  std::vector<Node> nodes = points_as_nodes();
  {
    const BlockRows<3, 3> a = matrix_at_reference(threads);
    const BlockRows<0, 0> near = element_graph(a);
    const std::vector<Index> of = aggregate(graph_of(near));
    std::vector<Node> aggregates = nodes_of(of, nodes);
    const BlockRows<3, 6> transfer =
        least_energy_transfer<3>(threads, a, graph_of(near), nodes, of, aggregates);
    connect_rows(transfer, aggregates.size());
    levels_.emplace_back(galerkin<3>(threads, a, transfer, aggregates.size()));
    nodes = std::move(aggregates);
  }
  while (nodes.size() > few_nodes) {
    const BlockRows<6, 6>& a = levels_.back().bodies();
    const std::vector<Index> of = aggregate_strong(a);
    std::vector<Node> aggregates = nodes_of(of, nodes);
    if (static_cast<double>(aggregates.size()) > least_reduction * static_cast<double>(nodes.size())) break;
    const BlockRows<6, 6> transfer = least_energy_transfer<6>(threads, a, graph_of(a), nodes, of, aggregates);
    levels_.back().connect(transfer, aggregates.size());
    BlockRows<6, 6> coarse = galerkin<6>(threads, a, transfer, aggregates.size());
    levels_.emplace_back(std::move(coarse));
    nodes = std::move(aggregates);
  }
}

/// Computes e_ij = S^-1 (X_j - X_i), with S the sum of (X_j - X_i) (X_j - X_i)^T, so that F is the
/// least-squares fit to the edges of a row. Ignores edges to points without a row, and rows whose edges lie
/// in a plane.
void Multigrid::place_edges() {
  const simd::SlicedRows all = matrix_->rows();
  const auto points = matrix_->point_of_row();
  const auto rest = reference_positions();
  edges_.assign(simd::slice_values * all.slot_begin[matrix_->slice_count()], 0.0F);
  for (const std::uint32_t row : rows_) {
    const std::size_t slice = row / simd::slice_rows;
    const std::size_t lane = row % simd::slice_rows;
    const auto for_each_edge = [&](auto&& body) {
      for (std::size_t slot = all.slot_begin[slice]; slot < all.slot_begin[slice + 1]; ++slot) {
        const std::uint32_t other = all.columns[simd::slice_rows * slot + lane];
        if (other < points.size()) body(slot, at(rest, points[other]) - at(rest, points[row]));
      }
    };
    Matrix3 squares;
    double size = 0.0;
    for_each_edge([&](std::size_t, const Vec3& edge) {
      add_outer(squares, 1.0, edge, edge);
      size += squared_length(edge);
    });
    if (!(determinant(squares) > 1e-6 * size * size * size)) continue;
    const Matrix3 inverted = inverse(squares);
    for_each_edge([&](std::size_t slot, const Vec3& edge) {
      const Vec3 e = inverted * edge;
      float* place = edges_.data() + simd::slice_values * slot + lane;
      place[0] = static_cast<float>(e.x);
      place[simd::slice_rows] = static_cast<float>(e.y);
      place[2 * simd::slice_rows] = static_cast<float>(e.z);
    });
  }
  const std::size_t slices = matrix_->slice_count();
  rotations_.resize(simd::slot_values * slices);
  positions_.resize(simd::slice_rows * slices);
  vector_.resize(simd::slice_rows * slices);
  rotated_.resize(simd::slice_rows * slices);
  partial_.resize(parallel::chunk_count(slices, slice_grain));
}

double Multigrid::operator_complexity() const {
  const auto fine = static_cast<double>(matrix_->rows().slot_begin[matrix_->slice_count()]) *
                    static_cast<double>(simd::slot_values);
  double all = fine;
  for (const CoarseLevel& level : levels_) all += 36.0 * static_cast<double>(level.bodies().columns.size());
  return all / fine;
}

}  // namespace palpate::fem
