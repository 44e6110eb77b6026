#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "contact/swept_pair.hpp"

/// Oracles of swept pairs. Distances in 80-bit arithmetic as the least over corners, sides and faces; touches
/// of small integer coordinates by the roots of the cubic whose coefficients are exact.
namespace palpate::test {

using Long = long double;
using LongVec = std::array<Long, 3>;

inline LongVec operator-(const LongVec& a, const LongVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Long dot_of(const LongVec& a, const LongVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline LongVec cross_of(const LongVec& a, const LongVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline LongVec mixed(const LongVec& a, const LongVec& b, Long t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}
inline Long length_of(const LongVec& a) {
  return std::sqrt(dot_of(a, a));
}

inline std::array<LongVec, 4> places(const SweptPoints& points, Long t) {
  std::array<LongVec, 4> all;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3& a = points.start[i];
    const Vec3& b = points.end[i];
    all[i] = mixed({a.x, a.y, a.z}, {b.x, b.y, b.z}, t);
  }
  return all;
}

inline Long to_segment(const LongVec& p, const LongVec& a, const LongVec& b) {
  const LongVec edge = b - a;
  const Long square = dot_of(edge, edge);
  const Long s = square > 0 ? std::clamp<Long>(dot_of(p - a, edge) / square, 0, 1) : 0;
  return length_of(p - mixed(a, b, s));
}

/// Never less than the distance, since each value belongs to two positions.
inline Long point_triangle_distance(const std::array<LongVec, 4>& x) {
  Long least =
      std::min({to_segment(x[0], x[1], x[2]), to_segment(x[0], x[2], x[3]), to_segment(x[0], x[3], x[1])});
  const LongVec n = cross_of(x[2] - x[1], x[3] - x[1]);
  const Long square = dot_of(n, n);
  if (square == 0) return least;
  std::array<Long, 3> w{};
  for (std::size_t i = 0; i < 3; ++i) {
    const LongVec& a = x[1 + (i + 1) % 3];
    const LongVec& b = x[1 + (i + 2) % 3];
    w[i] = dot_of(cross_of(b - a, x[0] - a), n) / square;
  }
  if (w[0] < 0 || w[1] < 0 || w[2] < 0) return least;
  LongVec foot{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) foot[k] += w[i] / (w[0] + w[1] + w[2]) * x[1 + i][k];
  return std::min(least, length_of(x[0] - foot));
}

inline Long edge_edge_distance(const std::array<LongVec, 4>& x) {
  Long least = std::min({to_segment(x[0], x[2], x[3]), to_segment(x[1], x[2], x[3]),
                         to_segment(x[2], x[0], x[1]), to_segment(x[3], x[0], x[1])});
  const LongVec u = x[1] - x[0];
  const LongVec v = x[3] - x[2];
  const LongVec w = x[2] - x[0];
  const Long uu = dot_of(u, u);
  const Long uv = dot_of(u, v);
  const Long vv = dot_of(v, v);
  const Long determinant = uu * vv - uv * uv;
  if (determinant <= 0) return least;
  const Long s = (dot_of(u, w) * vv - dot_of(v, w) * uv) / determinant;
  if (s < 0 || s > 1) return least;
  return std::min(least, to_segment(mixed(x[0], x[1], s), x[2], x[3]));
}

/// Least difference along a direction of the first `first` corners and the others.
inline Long gap_along(const std::array<LongVec, 4>& x, std::size_t first, const Vec3& direction) {
  const LongVec n{direction.x, direction.y, direction.z};
  Long least = INFINITY;
  for (std::size_t i = 0; i < first; ++i)
    for (std::size_t j = first; j < 4; ++j) least = std::min(least, dot_of(n, x[i] - x[j]));
  return least;
}

enum class Verdict { touches, misses, unclear };
struct Answer {
  Verdict verdict = Verdict::unclear;
  Long time = 0;  ///< of the first touch
};

/// Of integer coordinates below 2^9. The four points are in a plane at the roots of a cubic; there, whether
/// the place is inside both (\param inside  least weight) tells. Unclear where a root is double or a weight
/// within 1e-6 of a side.
template <class Inside>
Answer answer(const SweptPoints& points, bool edges, Inside&& inside) {
  using Whole = long long;
  using WholeVec = std::array<Whole, 3>;
  std::array<std::array<WholeVec, 2>, 3> columns{};  // of the determinant: value at the start, and change
  const auto whole = [](const Vec3& a, const Vec3& b) {
    return WholeVec{static_cast<Whole>(b.x - a.x), static_cast<Whole>(b.y - a.y),
                    static_cast<Whole>(b.z - a.z)};
  };
  const std::array<std::array<std::size_t, 2>, 3> pairs =
      edges ? std::array<std::array<std::size_t, 2>, 3>{{{0, 1}, {2, 3}, {0, 2}}}
            : std::array<std::array<std::size_t, 2>, 3>{{{1, 2}, {1, 3}, {1, 0}}};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& [from, to] = pairs[c];
    columns[c][0] = whole(points.start[from], points.start[to]);
    const WholeVec end = whole(points.end[from], points.end[to]);
    for (std::size_t k = 0; k < 3; ++k) columns[c][1][k] = end[k] - columns[c][0][k];
  }
  std::array<Whole, 4> f{};
  for (std::size_t choice = 0; choice < 8; ++choice) {
    const WholeVec& a = columns[0][choice & 1];
    const WholeVec& b = columns[1][(choice >> 1) & 1];
    const WholeVec& c = columns[2][(choice >> 2) & 1];
    const Whole d = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                    a[2] * (b[0] * c[1] - b[1] * c[0]);
    f[(choice & 1) + ((choice >> 1) & 1) + ((choice >> 2) & 1)] += d;
  }
  const auto value = [&](Long t) { return f[0] + t * (f[1] + t * (f[2] + t * static_cast<Long>(f[3]))); };
  const Long scale = std::abs(static_cast<Long>(f[0])) + std::abs(static_cast<Long>(f[1])) +
                     std::abs(static_cast<Long>(f[2])) + std::abs(static_cast<Long>(f[3]));
  if (scale == 0) return {};
  std::vector<Long> cuts{0};
  const Long a = 3 * static_cast<Long>(f[3]);
  const Long b = 2 * static_cast<Long>(f[2]);
  const Long c = static_cast<Long>(f[1]);
  std::vector<Long> extrema;
  if (a != 0 && b * b - 4 * a * c >= 0) {
    const Long q = -(b + (b < 0 ? -1 : 1) * std::sqrt(b * b - 4 * a * c)) / 2;
    extrema = {q / a};
    if (q != 0) extrema.push_back(c / q);
  } else if (a == 0 && b != 0) {
    extrema = {-c / b};
  }
  std::sort(extrema.begin(), extrema.end());
  for (const Long t : extrema)
    if (t > 0 && t < 1) cuts.push_back(t);
  cuts.push_back(1);
  for (const Long t : cuts)
    if (std::abs(value(t)) < 1e-6 * scale) return {};
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    Long low = cuts[i];
    Long high = cuts[i + 1];
    if ((value(low) > 0) == (value(high) > 0)) continue;
    const bool rises = value(high) > 0;
    for (int k = 0; k < 70; ++k) {
      const Long middle = (low + high) / 2;
      ((value(middle) > 0) == rises ? high : low) = middle;
    }
    const Long least = inside(places(points, low));
    if (std::abs(least) < 1e-6 || std::isnan(least)) return {};
    if (least > 0) return {Verdict::touches, low};
  }
  return {Verdict::misses, 0};
}

/// Least weight of the point in the triangle whose plane it is in.
inline Long least_weight(const std::array<LongVec, 4>& x) {
  const LongVec n = cross_of(x[2] - x[1], x[3] - x[1]);
  if (dot_of(n, n) < 1e-6L) return 0;  // of no area: unclear
  Long least = INFINITY;
  for (std::size_t i = 0; i < 3; ++i) {
    const LongVec& a = x[1 + (i + 1) % 3];
    const LongVec& b = x[1 + (i + 2) % 3];
    least = std::min(least, dot_of(cross_of(b - a, x[0] - a), n) / dot_of(n, n));
  }
  return least;
}

/// Least distance of the parameters of two lines in a plane to the ends of the edges; negative: outside.
inline Long least_parameter(const std::array<LongVec, 4>& x) {
  const LongVec u = x[1] - x[0];
  const LongVec v = x[3] - x[2];
  const LongVec w = x[2] - x[0];
  const LongVec n = cross_of(u, v);
  if (dot_of(n, n) < 1e-6L) return 0;  // parallel: unclear
  const Long s = dot_of(cross_of(w, v), n) / dot_of(n, n);
  const Long r = dot_of(cross_of(w, u), n) / dot_of(n, n);
  return std::min({s, 1 - s, r, 1 - r});
}

}  // namespace palpate::test
