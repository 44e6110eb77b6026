#include "fem/single_contact.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

/// The contact without its limits: A f = b with A = I + R response.
struct Unlimited {
  Matrix3 a;
  Vec3 b;
  Vec3 normal;
  double friction = 0.0;
};

/// The contact if its friction has the direction d and its largest size. Then f = N (n + mu d), and the pull
/// of the friction spring is r + mu N d. The contact slides if r has the direction d.
struct Sliding {
  Vec3 direction;
  double below = 0.0;  ///< N = n . b / below
  Vec3 remainder;      ///< r times `below`, so that it is finite
  double turn = 0.0;   ///< n . (d x remainder): zero if the two are parallel
};

Sliding slide(const Unlimited& contact, const Vec3& d) {
  const Vec3 a_force = contact.a * (contact.normal + contact.friction * d);
  const double along_b = dot(contact.normal, contact.b);
  const double below = dot(contact.normal, a_force);
  const Vec3 whole = below * contact.b - along_b * a_force;
  const Vec3 remainder = whole - dot(whole, contact.normal) * contact.normal;
  return {d, below, remainder, dot(contact.normal, cross(d, remainder))};
}

/// Finds the direction between two others with turns of unlike sign: regula falsi (Illinois).
Sliding find_zero(const Unlimited& contact, Sliding from, Sliding to) {
  constexpr int most = 40;
  constexpr double rounding = 1e-14;
  const double enough = rounding * (std::abs(from.turn) + std::abs(to.turn));
  Sliding middle = from;
  for (int i = 0; i < most; ++i) {
    middle =
        slide(contact, normalized(std::abs(to.turn) * from.direction + std::abs(from.turn) * to.direction));
    if (!(std::abs(middle.turn) > enough)) break;
    const bool replaces_from = (middle.turn > 0.0) == (from.turn > 0.0);
    Sliding& same = replaces_from ? from : to;
    Sliding& other = replaces_from ? to : from;
    same = middle;
    other.turn *= 0.5;
  }
  return middle;
}

/// The force of a sliding contact, if there is one.
std::optional<Vec3> sliding_force(const Unlimited& contact, const Vec3& last) {
  // Unit vectors, 22.5 degrees apart.
  constexpr double c = 0.92387953251128674;
  constexpr double s = 0.38268343236508977;
  constexpr double r = 0.70710678118654752;
  constexpr std::array<std::array<double, 2>, 16> circle{{{1, 0},
                                                          {c, s},
                                                          {r, r},
                                                          {s, c},
                                                          {0, 1},
                                                          {-s, c},
                                                          {-r, r},
                                                          {-c, s},
                                                          {-1, 0},
                                                          {-c, -s},
                                                          {-r, -r},
                                                          {-s, -c},
                                                          {0, -1},
                                                          {s, -c},
                                                          {r, -r},
                                                          {c, -s}}};
  const Vec3& n = contact.normal;
  const Vec3 x = normalized(cross(n, std::abs(n.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 y = cross(n, x);
  const auto at_angle = [&](std::size_t i) {
    const auto& d = circle[i % circle.size()];
    return slide(contact, d[0] * x + d[1] * y);
  };
  std::optional<Vec3> found;
  double closest = 0.0;
  Sliding before = at_angle(0);
  for (std::size_t i = 1; i <= circle.size(); ++i) {
    const Sliding after = at_angle(i);
    if ((before.turn > 0.0) != (after.turn > 0.0)) {
      const Sliding zero = find_zero(contact, before, after);
      const double angle = dot(zero.direction, last);
      if (zero.below > 0.0 && dot(zero.remainder, zero.direction) >= 0.0 && (!found || angle > closest)) {
        const double normal = dot(n, contact.b) / zero.below;
        found = normal * (n + contact.friction * zero.direction);
        closest = angle;
      }
    }
    before = after;
  }
  return found;
}

}  // namespace

Vec3 single_contact_force(const ContactLaw& law, const StepFriction& step, const Matrix3& response,
                          const Vec3& free, const Vec3& last) {
  const double resistance = law.resistance(step.time_step);
  const Vec3& n = law.direction;
  Unlimited contact{.a = identity(),
                    .b = law.stiffness * (law.depth * n - law.slip) - resistance * free,
                    .normal = n,
                    .friction = step.coefficient};
  for (std::size_t k = 0; k < 9; ++k) contact.a.values[k] += resistance * response.values[k];
  if (!(dot(n, contact.b) > 0.0)) return {};
  if (step.coefficient == 0.0) return (dot(n, contact.b) / dot(n, contact.a * n)) * n;
  const Vec3 stuck = inverse(contact.a) * contact.b;
  const double normal = dot(n, stuck);
  const Vec3 pull = stuck - normal * n;
  const double bound = step.coefficient * normal;
  if (normal > 0.0 && squared_length(pull) <= bound * bound) return stuck;
  if (const auto sliding = sliding_force(contact, last)) return *sliding;
  return normal > 0.0 ? normal * n + (bound / length(pull)) * pull : Vec3{};
}

}  // namespace palpate::fem
