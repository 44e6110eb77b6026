#include "fem/rest_factor.hpp"

#include <algorithm>
#include <cmath>

#include "fem/matrix.hpp"
#include "fem/sparse_cholesky.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t slice_grain = 16;
constexpr std::size_t most_points = 60000;  // to order more would take seconds
constexpr double most_fill = 8.0;           // blocks of L over those of the lower half of the matrix

}  // namespace

/// Approximate minimum degree, then body by body: which body comes first makes no difference to the fill.
void RestFactor::order() {
  ordered_ = true;
  const auto points = matrix_->point_of_row();
  if (points.empty() || points.size() > most_points) return;
  std::vector<Index> begin{0};
  std::vector<Index> columns;
  for (const Index point : points) {
    for (const std::uint32_t other : matrix_->columns(point)) {
      const Index row = at(matrix_->row_of_point(), other);
      if (row >= 0) columns.push_back(row);
    }
    begin.push_back(static_cast<Index>(columns.size()));
  }
  order_ = minimum_degree_order(begin, columns);
  const std::vector<Index> bodies = matrix_->body_of_point();
  const auto body = [&](Index row) { return at(bodies, at(points, row)); };
  std::ranges::stable_sort(order_, {}, body);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    if (k == 0 || body(order_[k]) != body(order_[k - 1]))
      body_begin_.push_back(static_cast<std::uint32_t>(k));
  }
  body_begin_.push_back(static_cast<std::uint32_t>(order_.size()));
  const std::vector<std::uint32_t> counts = factor_counts(begin, columns, order_);
  std::size_t blocks = 0;
  for (const std::uint32_t count : counts) blocks += count;
  fits_ = static_cast<double>(blocks) <= most_fill * 0.5 * static_cast<double>(columns.size());
  if (!fits_) return;
  column_begin_.assign(1, 0);
  for (const std::uint32_t count : counts) column_begin_.push_back(column_begin_.back() + count);
  places_.assign(matrix_->row_count(),
                 static_cast<std::uint32_t>(order_.size()));  // a place that nobody reads
  for (std::size_t k = 0; k < order_.size(); ++k) at(places_, order_[k]) = static_cast<std::uint32_t>(k);
}

std::optional<int> RestFactor::patience() {
  if (!ordered_) order();
  if (!fits_) return std::nullopt;
  // An iteration's other passes take half a product; a usual solve with the factor takes eight iterations.
  const auto blocks = static_cast<double>(column_begin_.back());
  const double products = 2.0 * blocks * 9.0 * sizeof(float) /
                          static_cast<double>(std::max<std::size_t>(matrix_->value_bytes(), 1));
  return static_cast<int>(8.0 * (1.5 + products) / 1.5);
}

void RestFactor::factor() {
  const Elements& elements = matrix_->elements();
  factors_.assign(elements.factors().begin(), elements.factors().end());
  diagonal_.assign(matrix_->diagonal().begin(), matrix_->diagonal().end());
  BlockEntries entries;
  const auto place_of = [&](Index point) {
    const Index row = at(matrix_->row_of_point(), point);
    return row < 0 ? Index{-1} : static_cast<Index>(at(places_, row));
  };
  for (const Index row : order_) {
    const Index point = at(matrix_->point_of_row(), row);
    const double m = at(diagonal_, point);
    entries.push_back({place_of(point), place_of(point), {{m, 0, 0, 0, m, 0, 0, 0, m}}});
  }
  for (Index e = 0; e < elements.size(); ++e) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const Index row = place_of(at(at(elements.corners(), e), i));
        const Index column = place_of(at(at(elements.corners(), e), j));
        if (row < column || column < 0) continue;
        entries.push_back({row, column, elements.stiffness_rest(e, i, j)});
      }
    }
  }
  const BlockFactor factored = block_cholesky(static_cast<Index>(order_.size()), entries);
  column_begin_.assign(factored.column_begin.begin(), factored.column_begin.end());
  block_rows_.assign(factored.rows.begin(), factored.rows.end());
  blocks_.assign(factored.blocks.begin(), factored.blocks.end());
  inverses_.assign(factored.inverses.begin(), factored.inverses.end());
  for (auto* list : {&blocks_, &inverses_}) list->insert(list->end(), 3, 0.0F);
}

/// e_ij = S^-1 (X_j - X_i), with S the sum of their squares, so that F is the least-squares fit to the edges
/// of a row. Edges to points that have no row, and those of rows whose edges lie in a plane, do not count.
void RestFactor::place_edges() {
  const simd::SlicedRows all = matrix_->rows();
  const auto points = matrix_->point_of_row();
  const auto rest = matrix_->elements().points_rest();
  edges_.assign(simd::slice_values * all.slot_begin[matrix_->slice_count()], 0.0F);
  for (std::size_t row = 0; row < points.size(); ++row) {
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
  taken_.resize(simd::slice_rows * slices);
  rotations_.resize(simd::slot_values * slices);
  positions_.resize(simd::slice_rows * slices);
  vector_.resize(order_.size() + 1);
  partial_.resize(parallel::chunk_count(slices, slice_grain));
}

simd::TurnedRows RestFactor::rows() {
  const simd::SlicedRows all = matrix_->rows();
  return {.slot_begin = all.slot_begin,
          .columns = all.columns,
          .edges = edges_.data(),
          .places = places_.data(),
          .taken = taken_.data(),
          .rotations = rotations_.data()};
}

void RestFactor::update(const parallel::Threads& threads, const CouplingSystem& couplings,
                        std::span<const Vec3> positions) {
  if (edges_.empty()) place_edges();
  const bool same = std::ranges::equal(factors_, matrix_->elements().factors()) &&
                    std::ranges::equal(diagonal_, matrix_->diagonal());
  if (!same) factor();
  const auto points = matrix_->point_of_row();
  const Vec3 origin = at(positions, points.front());  // floats are finer near zero
  parallel::for_each(threads, points.size(), simd::slice_rows * slice_grain, [&](std::size_t row) {
    const Vec3 p = at(positions, points[row]) - origin;
    positions_[row] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0.0F};
    taken_[row] = couplings.holds(points[row]) ? 0.0F : 1.0F;
  });
  const simd::TurnedRows turned = rows();
  parallel::for_chunks(threads, matrix_->slice_count(), slice_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::find_rotations(turned, positions_.data(), begin, end);
                       });
}

double RestFactor::apply(const parallel::Threads& threads, std::span<const float> r, std::span<float> z) {
  const simd::TurnedRows turned = rows();
  const simd::FactorColumns columns{.begin = column_begin_.data(),
                                    .rows = block_rows_.data(),
                                    .blocks = blocks_.data(),
                                    .inverses = inverses_.data()};
  const std::size_t slices = matrix_->slice_count();
  // The rows that only fill up share a place: they are left to one chunk, the last.
  parallel::for_chunks(threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::turn_back(turned, r.data(), vector_.data(), begin, end);
  });
  parallel::for_chunks(
      threads, body_begin_.size() - 1, 2, [&](std::size_t begin, std::size_t end, std::size_t) {
        simd::solve_columns(columns, vector_.data(), {body_begin_[begin], body_begin_[begin + 1]},
                            {body_begin_[begin + 1], body_begin_[end]});  // none, where there is one body
      });
  parallel::for_chunks(
      threads, slices, slice_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        partial_[chunk] = simd::turn_forth(turned, r.data(), vector_.data(), z.data(), begin, end);
      });
  double sum = 0.0;
  for (const double part : partial_) sum += part;
  return sum;
}

}  // namespace palpate::fem
