#include "contact/swept_pair.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace palpate {
namespace {

constexpr int most_advances = 10000;
/// After this number of advances, rotating directions are tried as well.
constexpr int few_advances = 3;

using EdgeCorners = std::array<std::size_t, 2>;

/// A candidate for the direction of smallest distance of the two primitives, with the points at its ends.
struct Candidate {
  Vec3 direction;                   ///< unit, or zero: none
  std::array<double, 3> weights{};  ///< barycentric weights, or parameters, of the two points
  double distance = 0.0;            ///< distance of the two points
  EdgeCorners first{};              ///< if the corners differ, the direction is orthogonal to these edges
  EdgeCorners second{};
};

/// Coordinates relative to a corner, so that rounding depends on the size of the pair and not on its
/// position.
struct LocalSweep {
  std::array<Vec3, 4> start;
  std::array<Vec3, 4> motion;
  double rounding = 0.0;  ///< bound of the rounding error of a separation, m
  double least = 0.0;     ///< distance below which directions are too inaccurate, m

  explicit LocalSweep(const SweptPoints& points) {
    const Vec3 origin = points.start[3];
    double largest = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      start[i] = points.start[i] - origin;
      const Vec3 end = points.end[i] - origin;
      motion[i] = end - start[i];
      for (const Vec3& p : {start[i], end})
        largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    }
    // With u = 2^-53, coordinates up to M, and N the sum of the direction's components: coordinates and
    // motions are off by u M and 4 u M, a product of a direction and a corner in time by 20 u N M, and the
    // difference of two by 46 u N M. N is at most 1.74. Below 1e-290 products lose bits; no mesh is so small.
    constexpr double unit = 0x1p-53;
    rounding = 64.0 * 1.74 * unit * largest + 1e-290;
    // A direction between two points at distance d has an angular error of about u M / d. Over a length of M
    // this reduces the separation by u M^2 / d, which is small against d if d is well above sqrt(u) M.
    least = 0x1p-22 * largest + 32.0 * rounding;
  }
  [[nodiscard]] std::array<Vec3, 4> at_time(double time) const {
    std::array<Vec3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = start[i] + time * motion[i];
    return corners;
  }
};

/// Separation along a direction: the minimum of direction . (a - b) over all a of the first `leading` points
/// and b of the others.
template <std::size_t leading>
double separation(const std::array<double, 4>& along) {
  double first = along[0];
  for (std::size_t i = 1; i < leading; ++i) first = std::min(first, along[i]);
  double second = along[leading];
  for (std::size_t i = leading + 1; i < 4; ++i) second = std::max(second, along[i]);
  return first - second;
}

template <std::size_t leading>
double separation(const Vec3& direction, const std::array<Vec3, 4>& corners) {
  std::array<double, 4> along{};
  for (std::size_t i = 0; i < 4; ++i) along[i] = dot(direction, corners[i]);
  return separation<leading>(along);
}

/// Corners along a direction as functions of time.
template <std::size_t leading>
class Along {
 public:
  Along(const LocalSweep& sweep, const Vec3& direction) {
    for (std::size_t i = 0; i < 4; ++i) {
      start_[i] = dot(direction, sweep.start[i]);
      motion_[i] = dot(direction, sweep.motion[i]);
    }
  }
  [[nodiscard]] double separation_at(double time) const {
    std::array<double, 4> along{};
    for (std::size_t i = 0; i < 4; ++i) along[i] = start_[i] + time * motion_[i];
    return separation<leading>(along);
  }
  /// The time at which the first pair of corners comes to the distance `least`, or 1; up to rounding.
  [[nodiscard]] double time_of(double least) const {
    double time = 1.0;
    for (std::size_t i = 0; i < leading; ++i) {
      for (std::size_t j = leading; j < 4; ++j) {
        const double closing = motion_[j] - motion_[i];
        const double gap = start_[i] - start_[j] - least;
        if (closing > 0.0 && gap < time * closing) time = gap / closing;
      }
    }
    return time;
  }

 private:
  std::array<double, 4> start_{};
  std::array<double, 4> motion_{};
};

/// Parameter of the point of the edge (a, b) nearest to p.
double parameter_on_edge(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 edge = b - a;
  const double square = squared_length(edge);
  return square > 0.0 ? std::clamp(dot(p - a, edge) / square, 0.0, 1.0) : 0.0;
}

Candidate from_difference(const Vec3& difference, const std::array<double, 3>& weights,
                          const EdgeCorners& edge) {
  const double distance = length(difference);
  const Vec3 direction = distance > 0.0 ? (1.0 / distance) * difference : Vec3{};
  return {.direction = direction, .weights = weights, .distance = distance, .first = edge};
}

/// A direction orthogonal to both edges, oriented from the second to the first.
Candidate across(const Vec3& normal, const Vec3& difference, const std::array<double, 3>& weights,
                 const Vec3& between_places, const EdgeCorners& first, const EdgeCorners& second) {
  const Vec3 unit = normalized(normal);
  return {.direction = dot(unit, difference) < 0.0 ? -unit : unit,
          .weights = weights,
          .distance = length(between_places),
          .first = first,
          .second = second};
}

struct PointTriangle {
  static constexpr std::size_t first = 1;
  using Candidates = std::array<Candidate, 4>;

  static Candidates candidates(const std::array<Vec3, 4>& x) {
    Candidates all;
    all[0] = on_face(x);
    for (std::size_t e = 0; e < 3; ++e) {
      const std::size_t next = (e + 1) % 3;
      const Vec3& a = x[1 + e];
      const Vec3& b = x[1 + next];
      const double s = parameter_on_edge(x[0], a, b);
      std::array<double, 3> weights{};
      weights[e] = 1.0 - s;
      weights[next] = s;
      all[1 + e] = from_difference((x[0] - a) - s * (b - a), weights, {1 + e, 1 + next});
    }
    return all;
  }
  static Candidate on_face(const std::array<Vec3, 4>& x) {
    const Vec3 u = x[2] - x[1];
    const Vec3 v = x[3] - x[1];
    const Vec3 p = x[0] - x[1];
    const Vec3 normal = cross(u, v);
    const double square = squared_length(normal);
    std::array<double, 3> weights{1.0, 0.0, 0.0};
    if (square > 0.0) {
      weights[1] = std::clamp(dot(cross(p, v), normal) / square, 0.0, 1.0);
      weights[2] = std::clamp(dot(cross(u, p), normal) / square, 0.0, 1.0 - weights[1]);
      weights[0] = std::max(1.0 - weights[1] - weights[2], 0.0);
    }
    return across(normal, p, weights, p - weights[1] * u - weights[2] * v, {1, 2}, {1, 3});
  }
};

struct EdgeEdge {
  static constexpr std::size_t first = 2;
  using Candidates = std::array<Candidate, 5>;

  static Candidates candidates(const std::array<Vec3, 4>& x) {
    Candidates all;
    all[0] = inside_both(x);
    for (std::size_t end = 0; end < 2; ++end) {
      const double s = parameter_on_edge(x[end], x[2], x[3]);
      all[1 + end] =
          from_difference((x[end] - x[2]) - s * (x[3] - x[2]), {static_cast<double>(end), s, 0.0}, {2, 3});
      const double r = parameter_on_edge(x[2 + end], x[0], x[1]);
      all[3 + end] = from_difference((x[0] - x[2 + end]) + r * (x[1] - x[0]),
                                     {r, static_cast<double>(end), 0.0}, {0, 1});
    }
    return all;
  }
  static Candidate inside_both(const std::array<Vec3, 4>& x) {
    const Vec3 u = x[1] - x[0];
    const Vec3 v = x[3] - x[2];
    const Vec3 from = x[0] - x[2];
    const Vec3 normal = cross(u, v);
    const double square = squared_length(normal);
    // For nearly parallel edges both parameters are inaccurate: the second is computed from the first.
    const double s = square > 0.0 ? std::clamp(dot(cross(v, from), normal) / square, 0.0, 1.0) : 0.0;
    const double r = parameter_on_edge(x[0] + s * u, x[2], x[3]);
    return across(normal, from, {s, r, 0.0}, from + s * u - r * v, {0, 1}, {2, 3});
  }
};

/// The candidate with the largest separation; also returns that separation.
template <class Pair>
struct Best {
  Candidate candidate{};
  double separation = -std::numeric_limits<double>::infinity();

  Best(const typename Pair::Candidates& candidates, const std::array<Vec3, 4>& corners) {
    for (const Candidate& one : candidates) {
      const double by = palpate::separation<Pair::first>(one.direction, corners);
      if (!(by > separation)) continue;
      separation = by;
      candidate = one;
    }
  }
};

/// The time up to which `along` is proved to separate the primitives; `now` if nothing can be proved.
template <std::size_t leading>
double advanced(const Along<leading>& along, double now, double least, double rounding) {
  if (along.separation_at(now) <= rounding) return now;
  double next = std::max(along.time_of(least), now);
  // Linear between two times: positive at both is positive throughout.
  while (next > now && along.separation_at(next) <= rounding) {
    const double middle = 0.5 * (now + next);
    if (middle >= next) return now;
    next = middle;
  }
  return next;
}

/// A direction that rotates with the primitives between two times, as a quadratic in Bernstein form: the
/// common normal of two edges, or a direction orthogonal to one edge and a fixed vector. Any direction gives
/// a valid bound; a good one is valid for long, where primitives rotate fast and approach slowly.
struct RotatingDirection {
  std::array<Vec3, 3> controls;
  double longest = 0.0;

  RotatingDirection(const Candidate& candidate, const std::array<Vec3, 4>& now,
                    const std::array<Vec3, 4>& then) {
    const auto edge = [](const std::array<Vec3, 4>& x, const EdgeCorners& e) { return x[e[1]] - x[e[0]]; };
    const Vec3 u0 = edge(now, candidate.first);
    const Vec3 u1 = edge(then, candidate.first);
    const bool of_two = candidate.second[0] != candidate.second[1];
    const Vec3 v0 = of_two ? edge(now, candidate.second) : cross(candidate.direction, u0);
    const Vec3 v1 = of_two ? edge(then, candidate.second) : v0;
    controls = {cross(u0, v0), 0.5 * (cross(u0, v1) + cross(u1, v0)), cross(u1, v1)};
    const bool reversed = dot(controls[0], candidate.direction) < 0.0;
    for (Vec3& control : controls) {
      if (reversed) control = -control;
      longest = std::max(longest, length(control));
    }
  }
  /// Whether the direction keeps the corners of both primitives at least `least` apart. Its products with
  /// differences of corners are cubics, which are positive if their Bernstein coefficients are.
  template <std::size_t leading>
  [[nodiscard]] bool separates(const std::array<Vec3, 4>& now, const std::array<Vec3, 4>& then,
                               double least) const {
    const double bound = least * longest;
    for (std::size_t i = 0; i < leading; ++i) {
      for (std::size_t j = leading; j < 4; ++j) {
        const Vec3 d0 = now[i] - now[j];
        const Vec3 d1 = then[i] - then[j];
        const bool positive = dot(controls[0], d0) > bound && dot(controls[2], d1) > bound &&
                              dot(controls[0], d1) + 2.0 * dot(controls[1], d0) > 3.0 * bound &&
                              dot(controls[2], d0) + 2.0 * dot(controls[1], d1) > 3.0 * bound;
        if (!positive) return false;
      }
    }
    return true;
  }
};

/// If `next` is a short step from `now`: doubles the step as long as a rotating direction proves it.
/// \param least  m; well above rounding
template <std::size_t leading>
double advanced_rotating(const LocalSweep& sweep, const Candidate& candidate, double now, double next,
                         double least) {
  const std::array<Vec3, 4> from = sweep.at_time(now);
  for (double step = 2.0 * (next - now); next < 1.0; step *= 2.0) {
    const double then = std::min(now + step, 1.0);
    const std::array<Vec3, 4> to = sweep.at_time(then);
    if (!RotatingDirection(candidate, from, to).separates<leading>(from, to, least)) break;
    next = then;
  }
  return next;
}

/// \param direction  separates the two at `time`; or zero
template <class Pair>
SweptTouch touch_at(const typename Pair::Candidates& candidates, double time, const Vec3& direction) {
  const auto nearest =
      std::min_element(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  return {.time = time, .weights = nearest->weights, .direction = direction};
}

template <class Pair>
std::optional<SweptTouch> first_touch(const SweptPoints& points, double tolerance) {
  const LocalSweep sweep(points);
  const double touching = std::max(tolerance, sweep.least);
  double time = 0.0;
  Vec3 before{};
  for (int advance = 0;; ++advance) {
    const std::array<Vec3, 4> corners = sweep.at_time(time);
    const typename Pair::Candidates candidates = Pair::candidates(corners);
    const Best<Pair> best(candidates, corners);
    const Vec3& direction = best.candidate.direction;
    const Along<Pair::first> along(sweep, direction);
    const bool apart = best.separation > sweep.rounding && along.separation_at(time) > sweep.rounding;
    if (apart) before = direction;
    const bool near = !(best.separation > 0.75 * touching);  // the true distance is slightly larger
    if (near || advance == most_advances) return touch_at<Pair>(candidates, time, before);
    double next = advanced(along, time, 0.25 * touching, sweep.rounding);
    if (advance >= few_advances && next > time)
      next = advanced_rotating<Pair::first>(sweep, best.candidate, time, next, 0.25 * touching);
    if (next >= 1.0) return std::nullopt;
    if (!(next > time)) return touch_at<Pair>(candidates, time, before);
    time = next;
  }
}

}  // namespace

std::optional<SweptTouch> point_meets_triangle(const SweptPoints& points, double tolerance) {
  return first_touch<PointTriangle>(points, tolerance);
}

std::optional<SweptTouch> edge_meets_edge(const SweptPoints& points, double tolerance) {
  return first_touch<EdgeEdge>(points, tolerance);
}

double swept_tolerance(const SweptPoints& points, double tolerance) {
  return std::max(tolerance, LocalSweep(points).least);
}

}  // namespace palpate
