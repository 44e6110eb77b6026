#include "sim/pair_support.hpp"

#include <algorithm>
#include <cmath>

#include "room.hpp"

namespace palpate {
namespace {

/// A pair of bodies counts as fully supported if the variance of its supporting contacts is at least this
/// fraction of that of all its contacts. Flush faces of 4 x 4 cells reach it.
constexpr double enough = 0.3;
/// Added to the variance of all contacts, as a fraction of the total: contacts that are longer than wide by a
/// factor of more than ten do not resist tilting about their length. Along the normals of the contacts it is
/// added to the supporting ones, too, because both are zero along the normal of a flat contact.
constexpr double floor_of_variance = 0.01;

/// Whether a symmetric matrix (xx, yy, zz, xy, xz, yz) is positive definite, by Cholesky.
bool is_positive(const std::array<double, 6>& m) {
  if (!(m[0] > 0.0)) return false;
  const double yy = m[1] - m[3] * m[3] / m[0];
  const double yz = m[5] - m[3] * m[4] / m[0];
  const double zz = m[2] - m[4] * m[4] / m[0];
  return yy > 0.0 && zz - yz * yz / yy > 0.0;
}

}  // namespace

void PairSupport::Moments::add(double w, const Vec3& x) {
  weight += w;
  first += w * x;
  const std::array<double, 6> products{x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.x * x.z, x.y * x.z};
  for (std::size_t k = 0; k < 6; ++k) second[k] += w * products[k];
}

std::array<double, 6> PairSupport::Moments::variance() const {
  if (!(weight > 0.0)) return {};
  const Vec3 m = (1.0 / weight) * first;
  const std::array<double, 6> of_mean{m.x * m.x, m.y * m.y, m.z * m.z, m.x * m.y, m.x * m.z, m.y * m.z};
  std::array<double, 6> variance{};
  for (std::size_t k = 0; k < 6; ++k) variance[k] = second[k] / weight - of_mean[k];
  return variance;
}

/// Bisects for the smallest t for which (supporting - t all) is not positive definite.
double PairSupport::lack_of(const Support& support) {
  std::array<double, 6> all = support.all.variance();
  std::array<double, 6> held = support.held.variance();
  const double floor = floor_of_variance * (all[0] + all[1] + all[2]);
  if (!(floor > 0.0)) return 1.0;
  for (std::size_t k = 0; k < 3; ++k) all[k] += floor;
  for (std::size_t k = 0; k < 6; ++k) held[k] += floor / support.all.weight * support.normals.second[k];
  const auto holds = [&](double t) {
    std::array<double, 6> rest{};
    for (std::size_t k = 0; k < 6; ++k) rest[k] = held[k] - t * all[k];
    return is_positive(rest);
  };
  if (holds(enough)) return 0.0;
  double low = 0.0;
  double high = enough;
  constexpr int halvings = 20;
  for (int i = 0; i < halvings; ++i) {
    const double t = 0.5 * (low + high);
    (holds(t) ? low : high) = t;
  }
  return 1.0 - low / enough;
}

void PairSupport::measure(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
                          std::span<const double> scales) {
  pairs_.clear();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Index own = at(bodies.body_of_point(), contacts.point[c]);
    const PairOfBodies pair = pair_of(own, contacts.body[c]);
    const Vec3& x = at(positions, contacts.point[c]);
    auto place = std::ranges::lower_bound(pairs_, pair, {}, &Support::pair);
    if (place == pairs_.end() || place->pair != pair) {
      const auto number = place - pairs_.begin();
      make_room(pairs_, pairs_.size() + 1);
      place = pairs_.insert(pairs_.begin() + number,
                            {.pair = pair, .origin = x, .all = {}, .held = {}, .normals = {}});
    }
    place->all.add(1.0, x - place->origin);
    place->held.add(scales[c], x - place->origin);
    place->normals.add(1.0, contacts.direction[c]);
  }
  for (Support& support : pairs_) support.lack = lack_of(support);
}

/// The place of a pair in `pairs_`, or its size.
std::size_t PairSupport::find(Index body_a, Index body_b) const {
  const PairOfBodies pair = pair_of(body_a, body_b);
  const auto place = std::ranges::lower_bound(pairs_, pair, {}, &Support::pair);
  return place != pairs_.end() && place->pair == pair ? static_cast<std::size_t>(place - pairs_.begin())
                                                      : pairs_.size();
}

double PairSupport::lack(Index body_a, Index body_b) const {
  const std::size_t pair = find(body_a, body_b);
  return pair < pairs_.size() ? pairs_[pair].lack : 1.0;
}

void PairSupport::soften(Index body_a, Index body_b, double part) {
  Support& support = pairs_[find(body_a, body_b)];
  support.softness = std::min(support.softness, part);
}

double PairSupport::softness(Index body_a, Index body_b) const {
  const std::size_t pair = find(body_a, body_b);
  return pair < pairs_.size() ? pairs_[pair].softness : 1.0;
}

}  // namespace palpate
