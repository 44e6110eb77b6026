#include "fem/coarse_space.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t least_members = 96;
constexpr std::size_t most_aggregates = 256;
constexpr std::size_t aggregate_grain = 8;
constexpr std::size_t coupling_grain = 256;

std::uint64_t pair_of(Index a, Index b) {
  return static_cast<std::uint64_t>(a) << 32U | static_cast<std::uint64_t>(b);
}
Index first_of(std::uint64_t pair) {
  return static_cast<Index>(pair >> 32U);
}
Index second_of(std::uint64_t pair) {
  return static_cast<Index>(pair & 0xffffffffU);
}

double component(const Vec3& a, int axis) {
  return axis == 0 ? a.x : axis == 1 ? a.y : a.z;
}

int longest_side(std::span<const Vec3> positions, std::span<const Index> points) {
  Vec3 lower = at(positions, points.front());
  Vec3 upper = lower;
  for (const Index p : points) {
    const Vec3& x = at(positions, p);
    lower = {std::min(lower.x, x.x), std::min(lower.y, x.y), std::min(lower.z, x.z)};
    upper = {std::max(upper.x, x.x), std::max(upper.y, x.y), std::max(upper.z, x.z)};
  }
  const Vec3 size = upper - lower;
  if (size.x >= size.y && size.x >= size.z) return 0;
  return size.y >= size.z ? 1 : 2;
}

/// Halves the points until no part has more than `most`; appends the end of each part to `ends`.
void halve(std::span<const Vec3> positions, std::span<Index> points, std::size_t begin, std::size_t most,
           std::vector<Index>& ends) {
  if (points.size() <= most) {
    std::sort(points.begin(), points.end());
    ends.push_back(static_cast<Index>(begin + points.size()));
    return;
  }
  const int axis = longest_side(positions, points);
  std::sort(points.begin(), points.end(), [&](Index a, Index b) {
    const double xa = component(at(positions, a), axis);
    const double xb = component(at(positions, b), axis);
    return xa != xb ? xa < xb : a < b;
  });
  const std::size_t half = points.size() / 2;
  halve(positions, points.first(half), begin, most, ends);
  halve(positions, points.subspan(half), begin + half, most, ends);
}

/// Rows of Z at a point: v = t + w x d for (t, w), three by six.
std::array<double, 18> motion_of(const simd::Padded3& d) {
  return {1, 0, 0, 0, d.z, -d.y, 0, 1, 0, -d.z, 0, d.x, 0, 0, 1, d.y, -d.x, 0};
}

/// s += a^T b of two of three by six.
void add_product(Block6& s, const std::array<double, 18>& a, const std::array<double, 18>& b) {
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) s[6 * i + j] += a[6 * k + i] * b[6 * k + j];
    }
  }
}

/// m z of three by six.
std::array<double, 18> product(const Matrix3& m, const std::array<double, 18>& z) {
  std::array<double, 18> result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 6; ++j) result[6 * i + j] += m.values[3 * i + k] * z[6 * k + j];
    }
  }
  return result;
}

Matrix3 whole(const SymmetricMatrix3& a) {
  return {{a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz}};
}

}  // namespace

CoarseSpace::CoarseSpace(const Bodies& bodies, std::span<const std::uint8_t> free)
    : aggregate_of_point_(free.size(), -1), offsets_(free.size()) {
  const auto free_count =
      static_cast<std::size_t>(std::ranges::count_if(free, [](auto f) { return f != 0; }));
  const std::size_t most = std::max(least_members, free_count / most_aggregates + 1);
  members_.begin.assign(1, 0);
  for (const Body& body : bodies.bodies()) {
    const std::size_t begin = members_.values.size();
    for (Index p = body.points.begin; p < body.points.end; ++p) {
      if (at(free, p) != 0) members_.values.push_back(p);
    }
    if (members_.values.size() == begin) continue;
    halve(bodies.points_rest(), std::span(members_.values).subspan(begin), begin, most, members_.begin);
  }
  for (Index a = 0; a < size(); ++a) {
    for (const Index p : members_[a]) at(aggregate_of_point_, p) = a;
  }
  coarse_.resize(static_cast<std::size_t>(size()));
  products_.resize(coarse_.size());
}

void CoarseSpace::find_neighbors(const BlockMatrix& matrix) {
  for (Index row = 0; row < matrix.size(); ++row) {
    const Index a = at(aggregate_of_point_, row);
    for (const std::uint32_t column : matrix.columns(row)) {
      const Index b = at(aggregate_of_point_, column);
      if (b >= 0) pattern_.push_back(pair_of(a, b));
    }
  }
  std::sort(pattern_.begin(), pattern_.end());
  pattern_.erase(std::unique(pattern_.begin(), pattern_.end()), pattern_.end());
}

void CoarseSpace::place_offsets(const parallel::Threads& threads, std::span<const Vec3> positions) {
  parallel::for_each(threads, coarse_.size(), aggregate_grain, [&](std::size_t a) {
    const auto members = members_[static_cast<Index>(a)];
    Vec3 middle;
    for (const Index p : members) middle += at(positions, p);
    middle = (1.0 / static_cast<double>(members.size())) * middle;
    for (const Index p : members) {
      const Vec3 d = at(positions, p) - middle;
      at(offsets_, p) = {d.x, d.y, d.z, 0.0};
    }
  });
}

void CoarseSpace::share_couplings(const parallel::Threads& threads, const CouplingSystem& couplings) {
  resize_with_room(shares_, couplings.size());
  parallel::for_each(threads, couplings.size(), coupling_grain, [&](std::size_t c) {
    const Coupling& coupling = couplings.couplings()[c];
    CouplingShares& all = shares_[c];
    all.count = 0;
    for (std::size_t k = 0; k < 5; ++k) {
      const Index point = coupling.points[k];
      const Index aggregate = point >= 0 ? at(aggregate_of_point_, point) : -1;
      if (aggregate < 0) continue;
      std::size_t place = 0;
      while (place < all.count && all.shares[place].aggregate != aggregate) ++place;
      if (place == all.count) all.shares[all.count++] = {.aggregate = aggregate};
      const auto motion = motion_of(at(offsets_, point));
      for (std::size_t i = 0; i < 18; ++i)
        all.shares[place].motion[i] += coupling.coefficients[k] * motion[i];
    }
  });
}

/// pairs_: all pairs that have a block, sorted, and where those of each aggregate begin.
void CoarseSpace::join_neighbors() {
  std::size_t most = pattern_.size();
  for (const CouplingShares& all : shares_) most += all.count * all.count;
  pairs_.clear();
  make_room(pairs_, most);
  pairs_.insert(pairs_.end(), pattern_.begin(), pattern_.end());
  for (const CouplingShares& all : shares_) {
    for (std::size_t i = 0; i < all.count; ++i) {
      for (std::size_t j = 0; j < all.count; ++j) {
        const std::uint64_t pair = pair_of(all.shares[i].aggregate, all.shares[j].aggregate);
        if (i != j && pairs_.back() != pair) pairs_.push_back(pair);
      }
    }
  }
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  neighbor_begin_.assign(coarse_.size() + 1, 0);
  for (const std::uint64_t pair : pairs_) ++at(neighbor_begin_, first_of(pair) + 1);
  for (std::size_t a = 1; a < neighbor_begin_.size(); ++a) neighbor_begin_[a] += neighbor_begin_[a - 1];
}

/// Reverse Cuthill & McKee (George & Liu 1981, section 4.3): breadth first from aggregates of few neighbours,
/// backwards.
void CoarseSpace::order_aggregates() {
  const auto count = static_cast<Index>(coarse_.size());
  const auto degree = [&](Index a) { return at(neighbor_begin_, a + 1) - at(neighbor_begin_, a); };
  const auto fewer = [&](Index a, Index b) { return degree(a) != degree(b) ? degree(a) < degree(b) : a < b; };
  degree_order_.resize(coarse_.size());
  std::iota(degree_order_.begin(), degree_order_.end(), 0);
  std::sort(degree_order_.begin(), degree_order_.end(), fewer);
  row_.assign(coarse_.size(), -1);
  order_.clear();
  order_.reserve(coarse_.size());
  std::size_t done = 0;
  for (const Index start : degree_order_) {
    if (at(row_, start) >= 0) continue;
    order_.push_back(start);
    at(row_, start) = 0;
    for (; done < order_.size(); ++done) {
      const std::size_t before = order_.size();
      for (Index k = at(neighbor_begin_, order_[done]); k < at(neighbor_begin_, order_[done] + 1); ++k) {
        const Index other = second_of(at(pairs_, k));
        if (at(row_, other) >= 0) continue;
        at(row_, other) = 0;
        order_.push_back(other);
      }
      std::sort(order_.begin() + static_cast<std::ptrdiff_t>(before), order_.end(), fewer);
    }
  }
  std::reverse(order_.begin(), order_.end());
  for (Index row = 0; row < count; ++row) at(row_, at(order_, row)) = row;
  first_.resize(coarse_.size());
  for (Index a = 0; a < count; ++a) {
    Index first = at(row_, a);
    for (Index k = at(neighbor_begin_, a); k < at(neighbor_begin_, a + 1); ++k)
      first = std::min(first, at(row_, second_of(at(pairs_, k))));
    at(first_, at(row_, a)) = first;
  }
}

/// The row of Z^T B Z of an aggregate, up to the diagonal.
void CoarseSpace::add_blocks(const BlockMatrix& matrix, Index aggregate) {
  const Index row = at(row_, aggregate);
  for (const Index point : members_[aggregate]) {
    const auto own = motion_of(at(offsets_, point));
    const auto columns = matrix.columns(point);
    std::array<double, 18> sum{};
    for (std::size_t place = 0; place < columns.size(); ++place) {
      const Index other = at(aggregate_of_point_, columns[place]);
      if (other < 0 || at(row_, other) > row) continue;
      const auto moved = product(matrix.block(point, place), motion_of(offsets_[columns[place]]));
      for (std::size_t i = 0; i < 18; ++i) sum[i] += moved[i];
      // Neighbours in the index mostly are of one aggregate.
      const bool last = place + 1 == columns.size() || at(aggregate_of_point_, columns[place + 1]) != other;
      if (!last) continue;
      add_product(factor_.block(row, at(row_, other)), own, sum);
      sum = {};
    }
  }
}

void CoarseSpace::add_couplings(const CouplingSystem& couplings) {
  for (std::size_t c = 0; c < couplings.size(); ++c) {
    const Matrix3 weight = whole(couplings.weight(c));
    const CouplingShares& all = shares_[c];
    for (std::size_t j = 0; j < all.count; ++j) {
      const auto moved = product(weight, all.shares[j].motion);
      for (std::size_t i = 0; i < all.count; ++i) {
        const Index row = at(row_, all.shares[i].aggregate);
        const Index column = at(row_, all.shares[j].aggregate);
        if (column <= row) add_product(factor_.block(row, column), all.shares[i].motion, moved);
      }
    }
  }
}

void CoarseSpace::update(const parallel::Threads& threads, const BlockMatrix& matrix,
                         const CouplingSystem& couplings, std::span<const Vec3> positions) {
  if (pattern_.empty()) find_neighbors(matrix);
  place_.resize(aggregate_of_point_.size());
  for (std::size_t row = 0; row < matrix.point_of_row().size(); ++row) {
    at(place_, matrix.point_of_row()[row]) =
        simd::slice_values * (row / simd::slice_rows) + row % simd::slice_rows;
  }
  place_offsets(threads, positions);
  share_couplings(threads, couplings);
  join_neighbors();
  order_aggregates();
  factor_.reset(first_);
  parallel::for_each(threads, coarse_.size(), aggregate_grain,
                     [&](std::size_t a) { add_blocks(matrix, static_cast<Index>(a)); });
  add_couplings(couplings);
  factor_.factor();
}

double CoarseSpace::correct(const parallel::Threads& threads, std::span<const float> r, std::span<float> z) {
  const auto value = [](std::span<const float> v, std::size_t place) {
    return Vec3{static_cast<double>(v[place]), static_cast<double>(v[place + simd::slice_rows]),
                static_cast<double>(v[place + 2 * simd::slice_rows])};
  };
  parallel::for_each(threads, coarse_.size(), aggregate_grain, [&](std::size_t row) {
    Vec3 force;
    Vec3 torque;
    for (const Index p : members_[order_[row]]) {
      const Vec3 f = value(r, at(place_, p));
      const simd::Padded3& d = at(offsets_, p);
      force += f;
      torque += cross({d.x, d.y, d.z}, f);
    }
    coarse_[row] = {force.x, force.y, force.z, torque.x, torque.y, torque.z};
  });
  factor_.solve(coarse_);
  parallel::for_each(threads, coarse_.size(), aggregate_grain, [&](std::size_t row) {
    const Vector6& c = coarse_[row];
    double sum = 0.0;
    for (const Index p : members_[order_[row]]) {
      const simd::Padded3& d = at(offsets_, p);
      const Vec3 v = Vec3{c[0], c[1], c[2]} + cross({c[3], c[4], c[5]}, {d.x, d.y, d.z});
      const std::size_t place = at(place_, p);
      z[place] += static_cast<float>(v.x);
      z[place + simd::slice_rows] += static_cast<float>(v.y);
      z[place + 2 * simd::slice_rows] += static_cast<float>(v.z);
      sum += dot(value(r, place), v);
    }
    products_[row] = sum;
  });
  return std::accumulate(products_.begin(), products_.end(), 0.0);
}

}  // namespace palpate::fem
