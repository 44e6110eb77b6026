// The checks of Dynamics before a step is completed; and the inversion clocks.
#include <algorithm>
#include <string>

#include "fem/body_title.hpp"
#include "fem/check_length.hpp"
#include "fem/dynamics.hpp"
#include "geometry/scaled_length.hpp"
#include "number_text.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t limited_element_grain = 256;
/// Largest lambda / mu of an inverted element: the value for nu = 1/3.
constexpr double inverted_ratio = 2.0;
/// Time in which the bulk modulus returns after inversion, s: several periods of one tet of soft tissue. A
/// faster return pushes neighbours that are still inverted (docs/inversion.md).
constexpr double bulk_return_time = 0.3;

}  // namespace

Error Dynamics::error_at_element(Index element, const std::string& found, const std::string& expected) const {
  const Body& body = at(bodies_, at(elements_.body_of_element(), element));
  const Index tet = at(elements_.tet_of_element(), element) - body.tets.begin;
  return {body_title(body), "tet " + std::to_string(tet), found, expected};
}

/// Names the first element at a point, or the point if it has no element.
Error Dynamics::error_at_point(std::size_t point, const std::string& found,
                               const std::string& expected) const {
  const auto elements = matrix_.elements_of_point()[static_cast<Index>(point)];
  if (!elements.empty()) return error_at_element(elements.front(), found, expected);
  const Body& body = at(bodies_, body_of_point_[point]);
  const Index own = static_cast<Index>(point) - body.points.begin;
  return {body_title(body), "point " + std::to_string(own), found, expected};
}

/// Lowers the bulk modulus of inverted tets, because a large one locks the tets around them.
void Dynamics::set_bulk_fraction(std::size_t element) {
  const double clock = inversion_clocks_[element];
  double returned = clock > 0.0 ? 0.0 : 1.0;
  if (clock < 0.0) returned = std::max(0.0, 1.0 + clock / bulk_return_time);
  const double ratio = elements_.ratios()[element];
  const double least = ratio > inverted_ratio ? inverted_ratio / ratio : 1.0;
  elements_.set_bulk_fraction(static_cast<Index>(element), least + (1.0 - least) * returned * returned);
}

/// Advances the clocks by a completed step.
void Dynamics::advance_inversion_clocks() {
  parallel::for_each(threads_, inversion_clocks_.size(), limited_element_grain, [&](std::size_t e) {
    const double before = inversion_clocks_[e];
    const bool inverted = elements_.inverted(static_cast<Index>(e));
    if (!inverted && before == 0.0) return;
    double& clock = inversion_clocks_[e];
    if (inverted) {
      clock = std::max(0.0, before) + duration_;
    } else {
      clock = before > 0.0 ? -bulk_return_time : std::min(0.0, before + duration_);
    }
    set_bulk_fraction(e);
  });
  const double changing = parallel::sum(threads_, inversion_clocks_.size(), partial_, [&](std::size_t e) {
    return inversion_clocks_[e] == 0.0 ? 0.0 : 1.0;
  });
  if (changing > 0.0) updated_ = false;
}

void Dynamics::set_inversion_clocks(std::span<const double> clocks) {
  check_length("inversion_clocks", clocks.size(), inversion_clocks_.size(), "element");
  for (const double clock : clocks) {
    if (!std::isfinite(clock))
      throw Error("dynamics", "inversion_clocks", "a value that is not finite", "finite values");
  }
  std::ranges::copy(clocks, inversion_clocks_.begin());
  for (std::size_t e = 0; e < inversion_clocks_.size(); ++e) set_bulk_fraction(e);
  updated_ = false;
}

void Dynamics::check_limits(double max_speed, std::optional<double> inverted_time) {
  // Squares would overflow before the speeds do, so compare without them.
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
  if (!inverted_time) return;
  constexpr double rounding = 1e-9;  // rounding error of the sum of the steps
  const double longest = *inverted_time * (1.0 - rounding);
  const auto stuck = [&](std::size_t e) {
    return elements_.inverted(static_cast<Index>(e)) && inversion_clocks_[e] >= longest;
  };
  const double all_stuck = parallel::sum(threads_, inversion_clocks_.size(), partial_,
                                         [&](std::size_t e) { return stuck(e) ? 1.0 : 0.0; });
  if (all_stuck == 0.0) return;
  std::size_t first = 0;
  while (!stuck(first)) ++first;
  throw error_at_element(static_cast<Index>(first),
                         "an inversion that has lasted " + number_text(inversion_clocks_[first]) + " s",
                         "less than " + number_text(*inverted_time) + " s (limits.inverted_time)");
}

}  // namespace palpate::fem
