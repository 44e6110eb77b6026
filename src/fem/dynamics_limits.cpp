// What stops a run, and where it says that it was: the part of Dynamics that looks at a step before it is
// taken.
#include <algorithm>
#include <string>

#include "fem/body_title.hpp"
#include "fem/dynamics.hpp"
#include "geometry/scaled_length.hpp"
#include "number_text.hpp"

namespace palpate::fem {

Error Dynamics::error_at_element(Index element, const std::string& found, const std::string& expected) const {
  const Body& body = at(bodies_, at(elements_.body_of_element(), element));
  const Index tet = at(elements_.tet_of_element(), element) - body.tets.begin;
  return {body_title(body), "tet " + std::to_string(tet), found, expected};
}

/// Names the first element at a point; the point itself where it has none.
Error Dynamics::error_at_point(std::size_t point, const std::string& found,
                               const std::string& expected) const {
  const auto elements = matrix_.elements_of_point()[static_cast<Index>(point)];
  if (!elements.empty()) return error_at_element(elements.front(), found, expected);
  const Body& body = at(bodies_, body_of_point_[point]);
  const Index own = static_cast<Index>(point) - body.points.begin;
  return {body_title(body), "point " + std::to_string(own), found, expected};
}

void Dynamics::check_limits(double max_speed, int inverted_steps) {
  // Not by squares, which overflow before the speeds do.
  const auto speed = [](const Vec3& v) { return scaled_length(v); };
  const double too_fast = parallel::sum(threads_, masses_.size(), partial_, [&](std::size_t i) {
    return speed(mean_velocities_[i]) > max_speed ? 1.0 : 0.0;
  });
  if (too_fast > 0.0) {
    const auto fastest = std::ranges::max_element(mean_velocities_, {}, speed);
    throw error_at_point(static_cast<std::size_t>(fastest - mean_velocities_.begin()),
                         "a speed of " + number_text(speed(*fastest)),
                         "at most " + number_text(max_speed) + " (limits.max_speed)");
  }
  const auto stuck = [&](std::size_t e) {
    return elements_.inverted(static_cast<Index>(e)) && inverted_steps_[e] >= inverted_steps;
  };
  const double all_stuck = parallel::sum(threads_, inverted_steps_.size(), partial_,
                                         [&](std::size_t e) { return stuck(e) ? 1.0 : 0.0; });
  if (all_stuck == 0.0) return;
  std::size_t first = 0;
  while (!stuck(first)) ++first;
  throw error_at_element(static_cast<Index>(first),
                         "it inverted for " + std::to_string(inverted_steps_[first]) + " steps in a row",
                         "fewer than " + std::to_string(inverted_steps) + " (limits.inverted_steps)");
}

}  // namespace palpate::fem
